"""Tips: corners of 0°, where curves of a border touch, as at a port as wide as its channel.

A tip is cut off where both curves are equally far from its point, so that they run alike from
there: its part has a point as one side, and lines across it stay across up to the point.
"""

from __future__ import annotations

import numpy as np
from scipy.optimize import brentq

from cadbem.cad.layout.parts import CUSP, Part, collapsed, taken_off
from cadbem.cad.layout.region import BorderPoint, Region
from cadbem.cad.layout.trimming_curves import TrimmingCurve

SHARP = np.radians(3)  # corner that is a tip; lunes, of two curves, have others up to `CUSP`
SHARES = (0.45, 0.3, 0.15, 0.05)  # of the shorter curve at a tip, tried as its length


def without_tips(region: Region) -> tuple[list[Part], list[Region]]:
    """Parts in the tips of a region, and what is left of it."""
    return taken_off(region, _cut_tip)


def _cut_tip(region: Region) -> tuple[Part, list[Region]] | None:
    """The part in one tip and the rest; None if there is no tip that can be cut off."""
    for k, angle in enumerate(region.angles):
        same = np.flatnonzero(region.owner == region.owner[k])
        before = k - 1 if k > same[0] else int(same[-1])
        after, ahead = region.trims[k], region.trims[before].reversed()
        curved = not (after.is_straight and ahead.is_straight)
        limit = SHARP if len(same) > 2 else CUSP
        if len(same) < 2 or angle > limit or not curved or after.is_degenerate:
            continue
        for share in SHARES:
            length = share * min(after.length, ahead.length)
            first, last = (at_distance(trim, length) for trim in (after, ahead))
            if first is None or last is None:
                continue
            cut = region.cut(BorderPoint(k, first), BorderPoint(before, 1 - last))
            tip = min(cut, key=lambda part: abs(part.area))
            part = collapsed(tip.loops[0]) if len(cut) == 2 and len(tip.loops) == 1 else None
            if part is not None:
                return part, [other for other in cut if other is not tip]
    return None


def at_distance(trim: TrimmingCurve, length: float) -> float | None:
    """The first fraction of a curve that is so far from its start; None if it is short."""
    start = trim.samples[:, :1]
    beyond = np.flatnonzero(np.hypot(*(trim.samples - start)) > length)
    if not len(beyond):
        return None

    def off(fraction: float) -> float:
        return float(np.hypot(*(trim.points(np.array([fraction])) - start))[0] - length)

    return float(brentq(off, 0.0, trim.fractions[beyond[0]]))
