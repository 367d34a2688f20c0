"""Arcs in polygons: layouts store rounded shapes as many corners."""

from __future__ import annotations

import numpy as np

from cadbem.cad.drawings.drawing import segment
from cadbem.cad.faces.curves import arc
from cadbem.spline.basis import Array
from cadbem.spline.nurbs import Nurbs

FEWEST = 4  # sides in a row that make an arc
TURN = np.radians(30)  # largest turning at a corner of an arc
OFF = 2.0  # distance of corners from the circle, in steps of the grid
MEANT = 1e-3  # turning (radians) of an arc, off right angles, by which these are meant
UNEVEN = 0.3  # difference of sides of an arc, per mean side; the last ones may be short


def rounded(ring: Array, grid: float) -> tuple[list[Nurbs], int]:
    """Lines and arcs through the corners (n, 2) of a closed polygon, and the number of arcs."""
    steps = np.roll(ring, -1, axis=0) - ring
    corner = _corner_to_start(steps)
    ring = np.roll(ring, -corner, axis=0)
    points = np.concatenate([ring, ring[:1]])
    pieces: list[Nurbs] = []
    k = count = 0
    while k < len(points) - 1:
        stop = _arc_end(points, k, grid)
        if stop - k >= FEWEST:
            pieces.append(_arc(points[k : stop + 1]))
            k, count = stop, count + 1
        else:
            pieces.append(segment(points[k], points[k + 1]))
            k += 1
    return pieces, count


def _corner_to_start(steps: Array) -> int:
    """Where the polygon turns most, so that no arc goes on beyond the start."""
    before = np.roll(steps, 1, axis=0)
    cross = before[:, 0] * steps[:, 1] - before[:, 1] * steps[:, 0]
    turns = np.abs(np.arctan2(cross, (before * steps).sum(axis=1)))
    lengths = np.maximum(np.hypot(*steps.T), np.hypot(*before.T))
    largest = turns.max()
    return int(np.argmax(np.where(turns > largest - 1e-3, lengths, 0.0)))


def _arc_end(points: Array, start: int, grid: float) -> int:
    """The last corner of the longest arc from a corner on; the start itself if there is none."""
    stop = start
    for end in range(start + 3, len(points)):
        if not _is_arc(points[start : end + 1], grid):
            break
        stop = end
    return stop


def _is_arc(points: Array, grid: float) -> bool:
    steps = np.diff(points, axis=0)
    lengths = np.hypot(*steps.T)
    cross = steps[:-1, 0] * steps[1:, 1] - steps[:-1, 1] * steps[1:, 0]
    turns = np.arctan2(cross, (steps[:-1] * steps[1:]).sum(axis=1))
    if np.abs(turns).max() > TURN or not (turns > 0).all() and not (turns < 0).all():
        return False
    inner = lengths[1:-1] if len(lengths) > 3 else lengths
    if (
        np.ptp(inner) > UNEVEN * inner.mean() + OFF * grid
        or max(lengths[0], lengths[-1]) > (1 + UNEVEN) * inner.mean() + OFF * grid
    ):
        return False
    centre, radius = _circle(points)
    off = np.abs(np.hypot(*(points - centre).T) - radius)
    return bool(off.max() < OFF * grid)


def _circle(points: Array) -> tuple[Array, float]:
    """Centre and radius of the circle nearest to points, by least squares."""
    middle = points.mean(axis=0)
    arms = points - middle
    matrix = np.column_stack([2 * arms, np.ones(len(arms))])
    x, y, rest = np.linalg.lstsq(matrix, (arms**2).sum(axis=1), rcond=None)[0]
    return middle + [x, y], float(np.sqrt(max(rest + x * x + y * y, 0.0)))


def _arc(points: Array) -> Nurbs:
    """The arc from the first to the last of points on a circle, through the one in the middle."""
    first, last = points[0], points[-1]
    if np.abs(last - first).max() == 0:  # a full circle
        centre, radius = _circle(points)
        angle = float(np.arctan2(*(first - centre)[::-1]))
        side = 1.0 if _turning(points) > 0 else -1.0
        return arc(centre, radius * np.array([1.0, 0]), radius * np.array([0, side]),
                   (side * angle, side * angle + 2 * np.pi))  # fmt: skip
    turn = _turning(points) * (1 + 1 / (len(points) - 2))  # without corners at both ends
    chord = last - first
    half = np.arcsin(min(1.0, float(np.hypot(*chord)) / (2 * _circle(points)[1])))
    turn = np.sign(turn) * 2 * (half if abs(turn) < np.pi else np.pi - half)
    right = np.pi / 2 * round(turn / (np.pi / 2))
    turn = right if abs(turn - right) < MEANT else turn
    normal = np.array([-chord[1], chord[0]])
    centre = 0.5 * (first + last) + normal / (2 * np.tan(turn / 2))
    arm = first - centre
    across = np.array([-arm[1], arm[0]]) * np.sign(turn)
    return arc(centre, arm, across, (0.0, abs(turn)))


def _turning(points: Array) -> float:
    steps = np.diff(points, axis=0)
    cross = steps[:-1, 0] * steps[1:, 1] - steps[:-1, 1] * steps[1:, 0]
    return float(np.arctan2(cross, (steps[:-1] * steps[1:]).sum(axis=1)).sum())
