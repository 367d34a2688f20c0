"""Straight cuts through a region, ranked by how well the parts will divide into quadrilaterals.

Good corners of patches have right angles, or straight ones where two patches meet at the side of
a third; a cut costs what it takes away from that (compare Talbert and Parkinson, *Development of
an automatic, two-dimensional finite element mesh generator using quadrilateral elements*, 1990),
its length, and how close it passes to other parts of the border.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cadbem.cad.layout.cut_ends import BorderPoints, candidates
from cadbem.cad.layout.region import BorderPoint, Region, distance
from cadbem.spline.basis import Array

NARROWEST = np.radians(12)  # angle between a cut and the border
ROOM = 0.2  # distance to other parts of the border, in lengths of the cut, that costs nothing
LENGTH_COST = 0.25  # for a cut as long as the root of the region's area
CORNERS = np.array([2.0, 1.6, 1.0, 0.6, 0.0, 0.5, 0.5, 0.9, 1.0])  # cost by number of right angles
JOINING, POCKET, SEPARATING = -0.5, 0.3, -1.8  # cost of cuts between loops, on one, between holes
BATCH = 64
INNER = np.array([0.3, 0.5, 0.7])  # where on a cut its room is measured


@dataclass(frozen=True)
class Cut:
    first: BorderPoint
    last: BorderPoint
    cost: float


def best_cuts(region: Region, count: int) -> list[Cut]:
    """Up to `count` cuts, the cheapest first."""
    ends, pairs, separating = candidates(region)
    if not len(pairs):
        return []
    costs, lengths = _angle_costs(region, ends, pairs, separating)
    order = np.argsort(costs, kind="stable")
    order = order[np.isfinite(costs[order])]
    found: list[Cut] = []
    for batch in np.array_split(order, max(1, len(order) // BATCH)):
        if len(found) >= count and len(batch) and costs[batch[0]] > found[count - 1].cost:
            break
        total = costs[batch] + _crowding(region, ends, pairs[batch], lengths[batch])
        found += [
            Cut(ends.border_point(pairs[i, 0]), ends.border_point(pairs[i, 1]), float(cost))
            for i, cost in zip(batch, total, strict=True)
            if np.isfinite(cost)
        ]
        found.sort(key=lambda cut: cut.cost)
    return found[:count]


def corner_cost(angle: Array) -> Array:
    """The difference of a corner from one, two or three right angles, in units of 60 degrees;
    corners of three want another cut, and sharp ones are bad."""
    right, straight = np.abs(angle - np.pi / 2), np.abs(angle - np.pi)
    reflex = np.abs(angle - 1.5 * np.pi) + np.pi / 3
    cost = np.minimum(np.minimum(right, straight), reflex) / (np.pi / 3)
    return cost + np.maximum(0, np.pi / 4 - angle) / (np.pi / 12)


def right_angles(angle: Array) -> Array:
    """The number of right angles in a corner: 1 up to 135 degrees, 2 up to 225, ..."""
    return np.maximum(1, np.round(angle / (np.pi / 2)))


def _angle_costs(
    region: Region, ends: BorderPoints, pairs: np.ndarray, separating: np.ndarray
) -> tuple[Array, Array]:
    """Cost (n,) of cuts by the angles that they make, and their lengths; inf if not possible."""
    p, q = pairs.T
    step = ends.point[:, q] - ends.point[:, p]
    length = np.hypot(*step)
    left, right = _parts(ends, p, step), _parts(ends, q, -step)
    cost = sum(corner_cost(part) for part in (*left, *right))
    cost = cost - corner_cost(ends.angle[p]) - corner_cost(ends.angle[q])
    cost = cost + LENGTH_COST * length / region.size
    if len(region.loops) == 1:
        cost = cost + _corner_counts(region, ends, pairs, left, right)
    else:
        same = ends.loop[p] == ends.loop[q]
        cost = cost + np.where(same, np.where(separating, SEPARATING, POCKET), JOINING)
    sharpest = np.min([*left, *right], axis=0)
    sharpest = np.where(_at_degenerate_edge(region, ends)[pairs].any(axis=1), 0.0, sharpest)
    small = length < 1e-6 * region.size
    return np.where((sharpest < NARROWEST) | small, np.inf, cost), length


def _at_degenerate_edge(region: Region, ends: BorderPoints) -> np.ndarray:
    """Which border points are ends of degenerate edges: there all lines are tangent in space."""
    degenerate = np.array([trim.is_degenerate for trim in region.trims])
    loops = range(len(region.loops))
    before = np.concatenate([np.roll(degenerate[region.owner == k], 1) for k in loops])
    return (ends.fraction == 0) & (degenerate | before)[ends.trim]


def _parts(ends: BorderPoints, index: np.ndarray, step: Array) -> tuple[Array, Array]:
    """The angles in which a cut divides the corner where it starts: after the border's onward
    direction, and the rest; negative if the cut leaves the region."""
    onward = ends.onward[:, index]
    cross, dot = onward[0] * step[1] - onward[1] * step[0], (onward * step).sum(axis=0)
    first = np.arctan2(cross, dot) % (2 * np.pi)
    return first, ends.angle[index] - first


def _corner_counts(
    region: Region,
    ends: BorderPoints,
    pairs: np.ndarray,
    left: tuple[Array, Array],
    right: tuple[Array, Array],
) -> Array:
    """Cost of the numbers of right angles of both parts of a region without holes."""
    p, q = pairs.T
    surplus = 2 - right_angles(region.angles)
    own = np.where(ends.fraction == 0, surplus[ends.trim], 0.0)
    before = np.concatenate([[0.0], np.cumsum(surplus)])
    upto = before[ends.trim + 1]  # of all joints up to the point, its own among them
    position = ends.trim + ends.fraction
    swap = position[p] > position[q]
    between = np.where(swap, upto[p] - own[p] - upto[q], upto[q] - own[q] - upto[p])
    around = before[-1] - between - own[p] - own[q]
    # the part along the border from the first end to the last has the first's left angle
    one = np.where(swap, around, between) + 4 - right_angles(left[0]) - right_angles(right[1])
    other = np.where(swap, between, around) + 4 - right_angles(left[1]) - right_angles(right[0])
    return _count_cost(one) + _count_cost(other) - _count_cost(before[-1:])


def _count_cost(count: Array) -> Array:
    index = np.clip(count, 0, len(CORNERS) - 1).astype(int)
    return CORNERS[index] + 0.3 * np.maximum(0, count - len(CORNERS) + 1) + 0.5 * (count < 0)


def _crowding(region: Region, ends: BorderPoints, pairs: np.ndarray, length: Array) -> Array:
    """Cost of passing close to the border; inf if a cut meets it between its ends."""
    start, end = ends.point[:, pairs[:, 0]], ends.point[:, pairs[:, 1]]
    cost = np.where(_meets(region, start, end, length), np.inf, 0.0)
    free = np.flatnonzero(np.isfinite(cost))
    if not len(free):
        return cost
    inner = start[:, free, None] + (end - start)[:, free, None] * INNER
    room = distance(inner.reshape(2, -1), region.segments).min(axis=1).reshape(len(free), -1)
    cost[free] += np.maximum(0, 1 - room.min(axis=1) / (ROOM * length[free]))
    for side in (0, 1):
        near = ends.to_joint[pairs[free, side]]
        cost[free] += np.maximum(0, 1 - near / (ROOM * length[free]))
    return cost


def _meets(region: Region, start: Array, end: Array, length: Array) -> np.ndarray:
    """Whether cuts (2, n) meet a chord of the border, other than where they begin and end."""
    a, b = region.segments
    direction = (end - start) / length
    arm = a[:, None, :] - start[:, :, None]
    other = b[:, None, :] - start[:, :, None]
    across = [direction[0][:, None] * v[1] - direction[1][:, None] * v[0] for v in (arm, other)]
    along = [direction[0][:, None] * v[0] + direction[1][:, None] * v[1] for v in (arm, other)]
    tiny = 1e-9 * region.size
    crosses = (np.minimum(*across) <= tiny) & (np.maximum(*across) >= -tiny)
    spread = across[0] - across[1]
    flat = np.abs(spread) < tiny
    share = np.where(flat, 0.5, across[0] / np.where(flat, 1.0, spread))
    where = along[0] + np.clip(share, 0, 1) * (along[1] - along[0])
    margin = np.minimum(0.02 * length, 0.05 * region.size)[:, None]
    inside = (where > margin) & (where < length[:, None] - margin)
    return (crosses & inside).any(axis=1)
