"""What in a face's outline is likely to keep it from being divided into patches."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cadbem.cad.kernel.brep import BrepFace
from cadbem.cad.layout.charts import chart_of
from cadbem.cad.layout.region import Region, distance
from cadbem.errors import CadError
from cadbem.spline.basis import Array

SHARP = 8.0  # degrees of a corner that is named
SHORT = 0.05  # length of an edge, per size of the region, that is named
NARROW = 0.02  # distance between edges, per size of the region, that is named


@dataclass(frozen=True, eq=False)
class Cause:
    """A corner (degrees), an edge or a gap between edges (mm), and where it is (3,), mm."""

    kind: str
    size: float
    place: Array


def likely_cause(face: BrepFace) -> Cause | None:
    """The sharpest corner, else the narrowest gap, else the shortest edge, if it is remarkable."""
    try:
        chart = chart_of(face)
    except (CadError, ValueError):
        return None
    if chart is None:
        return None
    for find in (_corner, _gap, _edge):
        for region in chart.regions:
            found = find(region)
            if found is not None:
                kind, size, flat = found
                return Cause(kind, size, chart.points(flat[:, None])[:, 0])
    return None


def _corner(region: Region) -> tuple[str, float, Array] | None:
    sharpest = int(np.argmin(region.angles))
    angle = float(np.degrees(region.angles[sharpest]))
    return ("corner", angle, region.trims[sharpest].samples[:, 0]) if angle < SHARP else None


def _gap(region: Region) -> tuple[str, float, Array] | None:
    """Between edges of which none follows the other."""
    best: tuple[float, Array] | None = None
    for k, trim in enumerate(region.trims):
        same = np.flatnonzero(region.owner == region.owner[k])
        beside = same[(k - same[0] + np.array([-1, 0, 1])) % len(same)]
        facing = ~np.isin(region.segment_curve, beside)
        if not facing.any():
            continue
        points = trim.points(np.linspace(0, 1, 33))
        gaps = distance(points, region.segments[:, :, facing]).min(axis=1)
        nearest = int(np.argmin(gaps))
        if best is None or gaps[nearest] < best[0]:
            best = float(gaps[nearest]), points[:, nearest]
    return ("gap", *best) if best is not None and best[0] < NARROW * region.size else None


def _edge(region: Region) -> tuple[str, float, Array] | None:
    lengths = [np.inf if trim.is_degenerate else trim.length for trim in region.trims]
    shortest = int(np.argmin(lengths))
    middle = region.trims[shortest].points(np.array([0.5]))[:, 0]
    return ("edge", lengths[shortest], middle) if lengths[shortest] < SHORT * region.size else None
