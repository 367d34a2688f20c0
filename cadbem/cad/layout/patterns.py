"""Patterns that fill simple regions with parts around their middle, or around their only hole."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from cadbem.cad.layout.parts import CORNER, STRAIGHT, Part, Side, part_of
from cadbem.cad.layout.region import (
    BorderPoint,
    Loop,
    Region,
    between,
    distance,
    interior_angles,
    merged,
)
from cadbem.cad.layout.trimming_curves import line

MOST_SPOKES = 8


def patterns(region: Region) -> list[list[Part]]:
    """A core for at most three corners, a star for three, a ring for one hole."""
    if any(trim.is_degenerate for trim in region.trims):
        return []  # spokes from its ends would touch there
    if len(region.loops) == 2:
        return [way for way in [_ring(*region.loops)] if way]
    if len(region.loops) > 2:
        return []
    return _centred(region.loops[0])


def _ring(outer: Loop, hole: Loop) -> list[Part]:
    """Spokes from the corners of one loop to those of the other, or to its nearest points."""
    inner = tuple(trim.reversed() for trim in reversed(hole))
    ends = [_corners(loop) for loop in (outer, inner)]
    counts = [len(places) for places in ends]
    if max(counts) < 3 or max(counts) > MOST_SPOKES or counts[0] != counts[1] and min(counts) > 2:
        return []
    if counts[0] == counts[1]:
        ends[1] = _matched(outer, ends[0], inner, ends[1])
    else:
        bare = int(np.argmin(counts))
        ends[bare] = _facing((outer, inner)[bare], (outer, inner)[1 - bare], ends[1 - bare])
    around = [_sides(loop, places) for loop, places in zip((outer, inner), ends, strict=True)]
    if not all(around):
        return []
    parts = []
    for far, near in zip(*around, strict=True):
        a, b = far[0].samples[:, 0], far[-1].samples[:, -1]
        c, d = near[-1].samples[:, -1], near[0].samples[:, 0]
        back = tuple(trim.reversed() for trim in reversed(near))
        parts.append(part_of([(line(d, a),), far, (line(b, c),), back]))
    return [part for part in parts if part] if all(parts) else []


def _corners(loop: Loop) -> list[BorderPoint]:
    """Where a loop turns by more than a side may."""
    bends = np.abs(interior_angles(loop) - np.pi)
    return [BorderPoint(int(k), 0.0) for k in np.flatnonzero(bends > STRAIGHT)]


def _matched(
    outer: Loop, far: list[BorderPoint], inner: Loop, near: list[BorderPoint]
) -> list[BorderPoint]:
    """The inner corners in the order that makes spokes shortest."""
    a = np.array([outer[place.trim].samples[:, 0] for place in far])
    b = np.array([inner[place.trim].samples[:, 0] for place in near])
    sums = [np.linalg.norm(a - np.roll(b, -k, axis=0), axis=1).sum() for k in range(len(near))]
    shift = int(np.argmin(sums))
    return [*near[shift:], *near[:shift]]


def _facing(loop: Loop, other: Loop, corners: list[BorderPoint]) -> list[BorderPoint]:
    """The points of a loop nearest to the corners of another."""
    region = Region((loop,))
    points = np.array([other[place.trim].samples[:, 0] for place in corners]).T
    segments = distance(points, region.segments).argmin(axis=1)
    shares = region.shares(points)[np.arange(len(segments)), segments]
    return [region.border_point(int(s), float(f)) for s, f in zip(segments, shares, strict=True)]


def _sides(loop: Loop, places: list[BorderPoint]) -> list[Side]:
    """The loop between successive places; [] if they do not follow each other once round."""
    at = np.array([place.trim + place.fraction for place in places])
    steps = np.diff([*at, at[0]]) % len(loop)
    if (steps < 1e-6).any() or abs(steps.sum() - len(loop)) > 1e-9:
        return []
    return [between(loop, *pair) for pair in pairwise([*places, places[0]])]


def _centred(loop: Loop) -> list[list[Part]]:
    """Ways to fill a loop with at most three corners round a point in its middle."""
    angles = interior_angles(loop)
    corners = np.flatnonzero(angles < CORNER).tolist()
    if (np.abs(np.delete(angles, corners) - np.pi) > STRAIGHT).any() or len(corners) > 3:
        return []
    ways = [_core(_rim(loop, corners))]
    if len(corners) == 3:
        ends = [*corners, corners[0] + len(loop)]
        ways.append(_star([tuple(loop[k % len(loop)] for k in range(a, b))
                           for a, b in pairwise(ends)]))  # fmt: skip
    return [way for way in ways if way]


def _star(sides: list[Side]) -> list[Part]:
    """One part a corner, between the middles of its sides and the centre."""
    halves = [split_side(side, 0.5) for side in sides]
    middles = [second[0].samples[:, 0] for _, second in halves]
    centre = np.mean([*middles, *[first[0].samples[:, 0] for first, _ in halves]], axis=0)
    parts = []
    for k in range(len(sides)):
        spokes = (line(centre, middles[k - 1]),), (line(middles[k], centre),)
        parts.append(part_of([spokes[0], halves[k - 1][1], halves[k][0], spokes[1]]))
    return [part for part in parts if part] if all(parts) else []


def _core(rim: list[Side]) -> list[Part]:
    """A four-sided core half way to the centre, and a part between it and each of four sides."""
    corners = [side[0].samples[:, 0] for side in rim]
    centre = np.mean(corners, axis=0)
    inner = [0.5 * (centre + corner) for corner in corners]
    parts = [part_of([(line(inner[k], inner[(k + 1) % 4]),) for k in range(4)])]
    for k in range(4):
        after = (k + 1) % 4
        spokes = (line(inner[k], corners[k]),), (line(corners[after], inner[after]),)
        parts.append(part_of([spokes[0], rim[k], spokes[1], (line(inner[after], inner[k]),)]))
    return [part for part in parts if part] if all(parts) else []


def _rim(loop: Loop, corners: list[int]) -> list[Side]:
    """The loop as four sides between its corners, and between points where it has turned most."""
    if not corners and len(loop) == 1:  # from its joint, lest a patch is cut there
        return _by_turning(loop, 4)
    if not corners:
        start = max(range(len(loop)), key=lambda k: loop[k].length if loop[k].is_straight else 0.0)
        first, second = split_turning((*loop[start:], *loop[:start]), 0.125)
        return _by_turning(merged((*second, *first), closed=False), 4)
    ends = [*corners, corners[0] + len(loop)]
    sides = [tuple(loop[k % len(loop)] for k in range(a, b)) for a, b in pairwise(ends)]
    counts = [1] * len(sides)
    while sum(counts) < 4:
        shares = [
            _turning(side) / n + 1e-3 * _length(side) / _length(loop)
            for side, n in zip(sides, counts, strict=True)
        ]
        counts[int(np.argmax(shares))] += 1
    return [p for side, n in zip(sides, counts, strict=True) for p in _by_turning(side, n)]


def _turning(side: Side) -> float:
    return sum(trim.turning for trim in side)


def _length(side: Side) -> float:
    return sum(trim.length for trim in side)


def _by_turning(side: Side, count: int) -> list[Side]:
    """Cut where equal shares of the turning are done."""
    parts = []
    for k in range(count, 1, -1):
        first, side = split_turning(side, 1 / k)
        parts.append(first)
    return [*parts, side]


def split_turning(side: Side, share: float) -> tuple[Side, Side]:
    """A side divided where a share of its turning is done; by length if it is straight."""
    weights = [trim.turning + 1e-6 * trim.length / _length(side) for trim in side]
    return _split(side, share, weights)


def split_side(side: Side, share: float) -> tuple[Side, Side]:
    """A side divided at a share of its length."""
    return _split(side, share, [trim.length for trim in side])


def _split(side: Side, share: float, weights: list[float]) -> tuple[Side, Side]:
    wanted = share * sum(weights)
    for k, (trim, weight) in enumerate(zip(side, weights, strict=True)):
        if wanted < weight * (1 - 1e-6) or k == len(side) - 1:
            fraction = wanted / weight
            if fraction < 1e-6:
                return side[:k], side[k:]
            return (*side[:k], trim.part(0, fraction)), (trim.part(fraction, 1), *side[k + 1 :])
        wanted -= weight
    return side, ()
