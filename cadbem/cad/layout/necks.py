"""Necks: places where a curve of a border nearly touches another one, as a port that is almost as
wide as its channel. A cut across each leaves short edges, which other rules take care of."""

from __future__ import annotations

import numpy as np
from scipy.optimize import minimize

from cadbem.cad.layout.region import BorderPoint, Region, distance
from cadbem.cad.layout.trimming_curves import TrimmingCurve

NARROW = 0.015  # width of a neck, per length of the shorter curve at it
NEAR = 0.1  # distance of samples, per length of the curve, at which one looks closer
END = 0.02  # fraction of a curve at its ends that belongs to the corner there
SMOOTH = 0.1  # turning (radians) up to which a joint is no corner
LEAST = 1e-6  # width of a neck as NARROW, below which curves touch


def without_necks(region: Region) -> list[Region]:
    """The region cut across its necks."""
    left, done = [region], []
    while left:
        whole = left.pop()
        neck = _neck(whole)
        if neck is None:
            done.append(whole)
        else:
            left += whole.cut(*neck)
    return done


def _neck(region: Region) -> tuple[BorderPoint, BorderPoint] | None:
    """Both ends of the shortest way across one neck; None if there is none."""
    for k, trim in enumerate(region.trims):
        if trim.is_straight or trim.is_degenerate:
            continue
        beside = _beside(region, k)
        gaps = distance(trim.samples[:, 1:-1], region.segments)
        for other in np.unique(region.segment_curve[gaps.min(axis=0) < NEAR * trim.length]):
            if other in beside:
                continue
            of_other = np.flatnonzero(region.segment_curve == other)
            to_other = gaps[:, of_other]
            sample, segment = np.unravel_index(np.argmin(to_other), to_other.shape)
            place = int(of_other[segment])
            share = region.shares(trim.samples[:, [sample + 1]])[0, place]
            start = region.border_point(place, float(share)).fraction
            ends = _closest(trim, region.trims[other], float(trim.fractions[sample + 1]), start)
            if ends is not None:
                first, last = _place(region, k, ends[0]), _place(region, int(other), ends[1])
                if first is not None and last is not None:
                    return first, last
    return None


def _place(region: Region, k: int, fraction: float) -> BorderPoint | None:
    """A fraction of a trim; None if it is at a corner, where necks are none."""
    if END < fraction < 1 - END:
        return BorderPoint(k, fraction)
    joint = k if fraction <= END else _beside(region, k)[2]
    if abs(region.angles[joint] - np.pi) > SMOOTH:
        return None
    return BorderPoint(k, fraction) if LEAST < fraction < 1 - LEAST else BorderPoint(joint, 0.0)


def _beside(region: Region, k: int) -> list[int]:
    """A trim and its neighbours."""
    same = np.flatnonzero(region.owner == region.owner[k])
    at = int(k - same[0])
    return [int(same[(at + step) % len(same)]) for step in (-1, 0, 1)]


def _closest(
    trim: TrimmingCurve, other: TrimmingCurve, first: float, last: float
) -> tuple[float, float] | None:
    """Fractions of two curves at their closest points; None if they are far apart, or one."""

    def square(fractions: np.ndarray) -> float:
        step = trim.points(fractions[:1]) - other.points(fractions[1:])
        return float((step**2).sum()) / least**2

    least = min(trim.length, other.length)
    found = minimize(square, [first, last], bounds=[(0, 1)] * 2, tol=1e-14)
    narrow = LEAST**2 < found.fun < NARROW**2
    return (float(found.x[0]), float(found.x[1])) if narrow else None
