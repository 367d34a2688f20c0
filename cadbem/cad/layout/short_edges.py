"""Short straight edges between long ones, such as bevels: a four-sided part of the corner that they
take off has them as one side, and leaves a region without short edges."""

from __future__ import annotations

import numpy as np

from cadbem.cad.layout.parts import Part, four_sided, taken_off
from cadbem.cad.layout.region import BorderPoint, Region
from cadbem.cad.layout.tips import at_distance
from cadbem.cad.layout.trimming_curves import TrimmingCurve

SHORT = 0.03  # length, per that of the shorter neighbour, below which an edge is short
CORNER = np.radians(150.0)  # largest angle between neighbours of an edge that takes off a corner
LEAST = 0.28  # quality of such a part below which other ways are tried
SHARES = (0.5, 0.3, 0.15)  # of the shorter neighbour, tried as the part's length


def without_short_edges(region: Region) -> tuple[list[Part], list[Region]]:
    """Parts at the short edges of a region, and what is left of it."""
    return taken_off(region, _cut_off)


def _cut_off(region: Region) -> tuple[Part, list[Region]] | None:
    """The part at one short edge, and the rest; None if there is none that can be cut off."""
    for k, short in enumerate(region.trims):
        same = np.flatnonzero(region.owner == region.owner[k])
        before = k - 1 if k > same[0] else int(same[-1])
        following = k + 1 if k < same[-1] else int(same[0])
        ahead, after = region.trims[before].reversed(), region.trims[following]
        nearest = min(ahead.length, after.length)
        corner = region.angles[k] + region.angles[following] - np.pi
        if len(same) < 4 or short.is_degenerate or not short.is_straight:
            continue
        if short.length > SHORT * nearest or corner > CORNER:
            continue
        for share in SHARES:
            found = _part(region, before, following, (ahead, after), share * nearest)
            if found is not None:
                return found
    return None


def _part(
    region: Region,
    before: int,
    following: int,
    sides: tuple[TrimmingCurve, TrimmingCurve],
    length: float,
) -> tuple[Part, list[Region]] | None:
    """The part that reaches a length into both neighbours, and the rest."""
    first, last = (at_distance(trim, length) for trim in sides)
    if first is None or last is None:
        return None
    cut = region.cut(BorderPoint(following, last), BorderPoint(before, 1 - first))
    corner = min(cut, key=lambda piece: abs(piece.area))
    part = four_sided(corner.loops[0]) if len(cut) == 2 and len(corner.loops) == 1 else None
    if part is None or part.quality < LEAST:
        return None
    return part, [other for other in cut if other is not corner]
