"""A region of the plane inside loops of trims, the interior to the left of each."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np
from scipy.optimize import brentq

from cadbem.cad.layout.trimming_curves import TrimmingCurve, line, turns
from cadbem.spline.basis import Array

Loop = tuple[TrimmingCurve, ...]
TOUCHING = 1e-6  # distance, per size, at which a hole's corner lies on the outer loop
LEAST_PART = 1e-9  # share of a trim that is not cut off


@dataclass(frozen=True)
class BorderPoint:
    """A point of a region's border: number of the trim among all, fraction of it (below 1)."""

    trim: int
    fraction: float


@dataclass(frozen=True, eq=False)
class Region:
    """`loops[0]` is the outer one, counter-clockwise; holes run clockwise."""

    loops: tuple[Loop, ...]

    @cached_property
    def area(self) -> float:
        """Of the polygons through the samples."""
        return sum(loop_area(loop) for loop in self.loops)

    @cached_property
    def size(self) -> float:
        """A length: the root of the area."""
        return float(np.sqrt(abs(self.area)))

    @cached_property
    def trims(self) -> Loop:
        """The trims of all loops, one loop after the other."""
        return tuple(trim for loop in self.loops for trim in loop)

    @cached_property
    def owner(self) -> np.ndarray:
        """Number of each trim's loop."""
        return np.repeat(np.arange(len(self.loops)), [len(loop) for loop in self.loops])

    @cached_property
    def angles(self) -> Array:
        """Interior angle where each trim starts."""
        return np.concatenate([interior_angles(loop) for loop in self.loops])

    @cached_property
    def segments(self) -> Array:
        """Chords between samples (2 ends, 2, n)."""
        chords = [np.stack([s.samples[:, :-1], s.samples[:, 1:]]) for s in self.trims]
        return np.concatenate(chords, axis=2)

    @cached_property
    def segment_curve(self) -> np.ndarray:
        """Number of each segment's trim."""
        return np.repeat(np.arange(len(self.trims)), [len(s.fractions) - 1 for s in self.trims])

    def shares(self, points: Array) -> Array:
        """Where on each segment (m) the nearest point to each of the points (2, n) is: (n, m)."""
        return _shares(points, self.segments)

    def border_point(self, segment: int, share: float) -> BorderPoint:
        """The place at a share of a segment."""
        trim = int(self.segment_curve[segment])
        first = int(np.searchsorted(self.segment_curve, trim))
        low, high = self.trims[trim].fractions[segment - first : segment - first + 2]
        return BorderPoint(trim, float(low + share * (high - low)))

    def hit(self, point: Array, direction: Array) -> BorderPoint | None:
        """Where a ray from a point meets the border first."""
        start, end = self.segments
        step = end - start
        cross = direction[0] * step[1] - direction[1] * step[0]
        arm = start - point[:, None]
        with np.errstate(divide="ignore", invalid="ignore"):
            along = (arm[0] * step[1] - arm[1] * step[0]) / cross
            share = (arm[0] * direction[1] - arm[1] * direction[0]) / cross
        valid = (share >= -1e-9) & (share <= 1 + 1e-9) & (along > 1e-4 * self.size)
        if not valid.any():
            return None
        best = int(np.argmin(np.where(valid, along, np.inf)))
        return self.border_point(best, float(np.clip(share[best], 0, 1)))

    def point(self, place: BorderPoint) -> Array:
        return self.trims[place.trim].points(np.array([place.fraction]))[:, 0]

    def _place(self, place: BorderPoint) -> tuple[int, BorderPoint]:
        """Loop of a border point, and the same point numbered within the loop."""
        loop = int(self.owner[place.trim])
        first = int(np.searchsorted(self.owner, loop))
        return loop, BorderPoint(place.trim - first, place.fraction)

    def cut(self, first: BorderPoint, last: BorderPoint) -> tuple[Region, ...]:
        """Divided by the straight line between two points of the border that see each other: two
        regions, or one if the line joins two loops."""
        there = line(self.point(first), self.point(last))
        back = there.reversed()
        (one, start), (two, end) = self._place(first), self._place(last)
        others = [lp for i, lp in enumerate(self.loops) if i not in (one, two)]
        if one != two:
            around = turned(self.loops[one], start), turned(self.loops[two], end)
            return (_arranged([merged((*around[0], there, *around[1], back)), *others]),)
        loop = self.loops[one]
        pair = [
            merged((*between(loop, start, end), back)),
            merged((*between(loop, end, start), there)),
        ]
        return _divided(pair, others)


def turned(loop: Loop, place: BorderPoint) -> Loop:
    """The whole loop, starting at a place on it."""
    k = place.trim
    trim, rest = loop[k], (*loop[k + 1 :], *loop[:k])
    if place.fraction < LEAST_PART:
        return (trim, *rest)
    return (trim.part(place.fraction, 1.0), *rest, trim.part(0.0, place.fraction))


def between(loop: Loop, first: BorderPoint, last: BorderPoint) -> Loop:
    """The trims of a loop from one place to another."""
    k, stop = first.trim, last.trim
    if k == stop and first.fraction < last.fraction:
        return (loop[k].part(first.fraction, last.fraction),)
    parts = []
    if first.fraction < 1 - LEAST_PART:
        parts.append(loop[k].part(first.fraction, 1.0))
    k = (k + 1) % len(loop)
    while k != stop:
        parts.append(loop[k])
        k = (k + 1) % len(loop)
    if last.fraction > LEAST_PART:
        parts.append(loop[k].part(0.0, last.fraction))
    return merged(tuple(parts), closed=False)


def distance(points: Array, segments: Array) -> Array:
    """Of points (2, n) from segments (2 ends, 2, m): (n, m)."""
    start, step = segments[0], segments[1] - segments[0]
    share = _shares(points, segments)
    x, y = (points[d][:, None] - start[d] - share * step[d] for d in (0, 1))
    return np.hypot(x, y)


def _shares(points: Array, segments: Array) -> Array:
    start, step = segments[0], segments[1] - segments[0]
    product = sum((points[d][:, None] - start[d]) * step[d] for d in (0, 1))
    return np.clip(product / np.maximum((step**2).sum(axis=0), 1e-300), 0, 1)


def divided_along(region: Region, axis: int, value: float) -> list[Region]:
    """The region cut along the line on which a coordinate has a value, wherever that is inside."""
    found = sorted(_crossings(region, axis, value), key=lambda a: region.point(a)[1 - axis])
    for first, last in pairwise(found):
        middle = 0.5 * (region.point(first) + region.point(last))
        clear = float(distance(middle[:, None], region.segments).min()) > 1e-6 * region.size
        if clear and sum(_winding(middle, loop) for loop in region.loops) > np.pi:
            parts = region.cut(first, last)
            return [piece for part in parts for piece in divided_along(part, axis, value)]
    return [region]


def _crossings(region: Region, axis: int, value: float) -> list[BorderPoint]:
    """Where the border passes a line on which a coordinate has a value."""
    tiny = 1e-9 * region.size
    ends = []
    for k, trim in enumerate(region.trims):
        off = trim.samples[axis] - value
        if abs(off[0]) <= tiny:
            ends.append(BorderPoint(k, 0.0))
        off = np.where(np.abs(off) <= tiny, 0.0, off)
        for i in np.flatnonzero(off[:-1] * off[1:] < 0):
            low, high = trim.fractions[i : i + 2]
            at = brentq(lambda f, s=trim: s.points(np.array([f]))[axis, 0] - value, low, high)
            ends.append(BorderPoint(k, float(at)))
        for i in np.flatnonzero(off[1:-1] == 0):
            ends.append(BorderPoint(k, float(trim.fractions[i + 1])))
    return ends


def region_of(loops: list[Loop]) -> Region | None:
    """Loops in any direction and order as a region; None if they enclose nothing."""
    directed = []
    areas = [loop_area(loop) for loop in loops]
    if not loops or max(map(abs, areas)) == 0:
        return None
    outer = int(np.argmax(np.abs(areas)))
    for index, (loop, area) in enumerate(zip(loops, areas, strict=True)):
        backwards = area < 0 if index == outer else area > 0
        directed.append(tuple(s.reversed() for s in reversed(loop)) if backwards else loop)
    return _spliced(_arranged([directed.pop(outer), *directed]))


def _spliced(region: Region) -> Region:
    """Holes whose corner lies on the outer loop made part of it: it passes that corner twice."""
    outer, *holes = region.loops
    for hole in holes:
        for k, trim in enumerate(hole):
            corner = trim.samples[:, :1]
            alone = Region((outer,))
            gaps = distance(corner, alone.segments)[0]
            if gaps.min() > TOUCHING * region.size:
                continue
            nearest = int(np.argmin(gaps))
            place = alone.border_point(nearest, float(alone.shares(corner)[0, nearest]))
            around = *turned(outer, place), *turned(hole, BorderPoint(k, 0.0))
            others = [loop for loop in region.loops[1:] if loop is not hole]
            return _spliced(_arranged([merged(around), *others]))
    return region


def loop_area(loop: Loop) -> float:
    """Enclosed by the polygon through the samples, positive if it runs counter-clockwise."""
    points = np.concatenate([trim.samples[:, :-1] for trim in loop], axis=1)
    x, y = points - points[:, :1]
    return 0.5 * float(x @ np.roll(y, -1) - y @ np.roll(x, -1))


def interior_angles(loop: Loop) -> Array:
    """At the start of each trim, on the left side, between 0 and 2 π."""
    before = np.array([trim.directions[1] for trim in (loop[-1], *loop[:-1])]).T
    after = np.array([trim.directions[0] for trim in loop]).T
    steps = np.stack([before, after], axis=2).reshape(2, -1)
    return np.pi - turns(steps)[::2]


def merged(trims: Loop, closed: bool = True) -> Loop:
    """Straight trims that continue each other, and pieces of one curve, made one."""
    chain = list(trims[:1])
    for trim in trims[1:]:
        one = chain[-1].continued(trim)
        chain[-1:] = [one] if one else [chain[-1], trim]
    one = chain[-1].continued(chain[0]) if closed and len(chain) > 2 else None
    return (one, *chain[1:-1]) if one else tuple(chain)


def is_inside(point: Array, loop: Loop) -> bool:
    """Whether the polygon through the samples winds round the point."""
    return abs(_winding(point, loop)) > np.pi


def _winding(point: Array, loop: Loop) -> float:
    """Angle that the loop subtends at a point, 2 π if it runs round the point once."""
    points = np.concatenate([trim.samples for trim in loop], axis=1) - point[:, None]
    return float(turns(points).sum())


def _arranged(loops: list[Loop]) -> Region:
    areas = [loop_area(loop) for loop in loops]
    outer = int(np.argmax(areas))
    return Region((loops[outer], *[lp for i, lp in enumerate(loops) if i != outer]))


def _divided(pair: list[Loop], others: list[Loop]) -> tuple[Region, ...]:
    """Two loops made by a cut, and the loops that it did not touch, shared among them."""
    pair.sort(key=loop_area)
    pocket, rest = pair[1], [pair[0]]
    kept: list[Loop] = []
    for loop in others:
        outer = loop_area(loop) > 0  # then a hole was cut, and its pocket lies outside of it
        inside = not outer and is_inside(loop[0].samples[:, 0], pocket)
        (kept if inside else rest).append(loop)
    return Region((pocket, *kept)), _arranged(rest)
