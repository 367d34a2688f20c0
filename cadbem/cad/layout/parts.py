"""Four-sided parts of a region: their sides, and the quality of the Coons map inside."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from cadbem.cad.layout.region import Loop, Region, interior_angles
from cadbem.cad.layout.trimming_curves import TrimmingCurve, line
from cadbem.spline.basis import Array

POOR = 0.12  # least quality of a part that is used
CUSP = np.radians(15)  # corner in which a patch is collapsed
COLLAPSED = 0.3  # largest quality of such a patch: others are preferred
NEARLY_A_POINT = 0.03  # length of a side, per that of the opposite one, that is like a point
CORNER, STRAIGHT = np.radians(160), np.radians(40)  # largest corner; largest kink within a side

Side = tuple[TrimmingCurve, ...]


@dataclass(frozen=True, eq=False)
class Part:
    """Four sides round a region, counter-clockwise; `quality` as `part_quality` says."""

    sides: tuple[Side, Side, Side, Side]
    quality: float

    @property
    def patches(self) -> int:
        """The number of smooth patches of the part, which is cut where trims of a side meet, or
        where an arc passes a right angle."""
        across = [np.concatenate([joints(self.sides[k]), 1 - joints(self.sides[k + 2])[::-1]])
                  for k in (0, 1)]  # fmt: skip
        counts = [1 + len(np.unique(np.round(at, 6))) for at in across]
        return counts[0] * counts[1]


def joints(side: Side) -> Array:
    """Shares of a side's length at which its trims, or pieces of arcs, meet."""
    lengths = np.maximum([trim.length for trim in side], 1e-300)
    starts = np.concatenate([[0.0], np.cumsum(lengths)[:-1]])
    at = [
        start + length * np.arange(pieces) / pieces
        for trim, start, length in zip(side, starts, lengths, strict=True)
        for pieces in [trim.arcs]
    ]
    return np.concatenate(at)[1:] / lengths.sum()


def four_sided(loop: Loop) -> Part | None:
    """The loop as one part, if it has four corners and no other strong kink."""
    if len(loop) < 4:
        return None
    angles = interior_angles(loop)
    corners = np.sort(np.argsort(angles, kind="stable")[:4])
    others = np.delete(angles, corners)
    if angles[corners].max() > CORNER or (np.abs(others - np.pi) > STRAIGHT).any():
        return None
    ends = [*corners.tolist(), int(corners[0]) + len(loop)]
    sides = [tuple(loop[k % len(loop)] for k in range(a, b)) for a, b in pairwise(ends)]
    if any(len(side) > 1 and any(trim.is_degenerate for trim in side) for side in sides):
        return None
    return part_of(sides)


def collapsed(loop: Loop) -> Part | None:
    """A loop with three corners as one part whose fourth side is a point, if a corner is so sharp
    that no four-sided part fits into it."""
    angles = interior_angles(loop)
    corners = np.flatnonzero(angles < CORNER)
    others = np.delete(angles, corners)
    if len(corners) != 3 or (np.abs(others - np.pi) > STRAIGHT).any():
        return None
    sharpest = int(np.argmin(angles[corners]))
    if angles[corners[sharpest]] > CUSP:
        return None
    first = int(corners[sharpest])
    steps = np.sort((corners - first) % len(loop))  # 0, then the other two corners
    ends = [*(first + steps).tolist(), first + len(loop)]
    sides = [tuple(loop[k % len(loop)] for k in range(a, b)) for a, b in pairwise(ends)]
    point = sides[0][0].samples[:, 0]
    return part_of([(line(point, point),), *sides])


def part_of(sides: list[Side]) -> Part | None:
    """A part, or None if its Coons map folds."""
    quality = part_quality(sides)
    return Part((sides[0], sides[1], sides[2], sides[3]), quality) if quality > 0 else None


def part_quality(sides: list[Side]) -> float:
    """The smaller of the least sine between parameter lines and four times the ratio of least to
    largest area element of the Coons map; where a side is or nearly is a point, of the sine and
    `COLLAPSED` if that is more."""
    points = coons_points([along(side, np.linspace(0, 1, 11)) for side in sides])
    forth = np.diff(points, axis=1)
    up = np.diff(points, axis=2)
    quality = np.inf
    elements = []
    for a in (forth[:, :, :-1], forth[:, :, 1:]):
        for b in (up[:, :-1], up[:, 1:]):
            area = a[0] * b[1] - a[1] * b[0]
            lengths = np.hypot(*a) * np.hypot(*b)
            there = lengths > 1e-6 * lengths.max()  # elsewhere a side is a point
            quality = min(quality, float((area[there] / lengths[there]).min(initial=1.0)))
            elements.append(area)
    if any(len(side) == 1 and side[0].length == 0 for side in sides):
        return min(quality, COLLAPSED)
    largest = float(np.max(elements))
    even = 4 * float(np.min(elements)) / largest if largest > 0 else -1.0
    return min(quality, max(even, COLLAPSED) if _nearly_collapsed(sides) else even)


def _nearly_collapsed(sides: list[Side]) -> bool:
    """Whether a side is so much shorter than the opposite one that the part is like a triangle."""
    lengths = [sum(trim.length for trim in side) for side in sides]
    return any(lengths[k] < NEARLY_A_POINT * lengths[k - 2] for k in range(4))


def ends_of(side: Side) -> Array:
    """Shares of a side's length at which its trims begin and end."""
    ends = np.concatenate([[0.0], np.cumsum([trim.length for trim in side])])
    return ends / ends[-1] if ends[-1] > 0 else np.array([0.0, 1.0])  # a side that is a point


def along(side: Side, shares: Array, ends: Array | None = None) -> Array:
    """Points (2, n) at shares (n,) of a side, whose trims lie between `ends`, by default shares
    of the length."""
    ends = ends_of(side) if ends is None else ends
    index = np.clip(np.searchsorted(ends, shares, side="right") - 1, 0, len(side) - 1)
    points = np.empty((2, len(shares)))
    for k, trim in enumerate(side):
        here = index == k
        fractions = (shares[here] - ends[k]) / (ends[k + 1] - ends[k])
        points[:, here] = trim.at_shares(np.clip(fractions, 0, 1))
    return points


def coons_points(borders: list[Array]) -> Array:
    """Bilinearly blended points (dim, n, n) of four borders (dim, n) that follow each other."""
    south, east, north, west = borders[0], borders[1], borders[2][:, ::-1], borders[3][:, ::-1]
    xi = np.linspace(0, 1, south.shape[1])[None, :, None]
    eta = np.linspace(0, 1, east.shape[1])[None, None, :]
    ruled = (1 - eta) * south[:, :, None] + eta * north[:, :, None]
    ruled = ruled + (1 - xi) * west[:, None, :] + xi * east[:, None, :]
    low = (1 - xi) * south[:, :1, None] + xi * south[:, -1:, None]
    high = (1 - xi) * north[:, :1, None] + xi * north[:, -1:, None]
    return ruled - (1 - eta) * low - eta * high


def taken_off(
    region: Region, cut: Callable[[Region], tuple[Part, list[Region]] | None]
) -> tuple[list[Part], list[Region]]:
    """Parts that are ``cut`` off a region one after another, and what is left when there are no
    more: ``cut`` gives one part and the rest, or None."""
    parts: list[Part] = []
    left, done = [region], []
    while left:
        whole = left.pop()
        found = cut(whole)
        if found is None:
            done.append(whole)
        else:
            parts.append(found[0])
            left += found[1]
    return parts, done
