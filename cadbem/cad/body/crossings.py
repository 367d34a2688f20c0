"""Patches that cross each other, or themselves, away from their borders.

Each patch is cut into blocks at its knots, each block into cells. Boxes of blocks and cells that
meet are sorted out from the largest to the smallest. Of a pair of cells that is left, each must
have corners on both sides of the other one's plane; from there Newton's method looks for a point
that both surfaces have in common. Neighbours have those on their borders only.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise, product

import numpy as np

from cadbem.boundary import Patch
from cadbem.points import area_vector
from cadbem.spline.basis import Array
from cadbem.spline.nurbs import Nurbs

CELLS = 8  # of a block in each direction, a power of two
MOST_BLOCKS = 16  # of a patch in each direction
MARGIN = 2e-4  # distance from borders, per size of all patches, from which on points count
IN_PLANE = 1e-9  # distance of a plane, per size of the model, that is none
EXACT = 1e-9  # distance, per size, of points that are the same
FLAT = 0.02  # sine of the angle between surfaces that only touch
TRIALS = 4  # pairs of cells of two patches from which Newton's method starts
STEPS = 6  # of Newton's method
ROWS = 256  # boxes that are compared with all others at a time


@dataclass(frozen=True, eq=False)
class Crossing:
    """A point (3,) that two patches, or one twice, have in common, and their indices."""

    patches: tuple[int, int]
    place: Array


@dataclass(frozen=True, eq=False)
class _Blocks:
    """Pieces of patches: index of the patch (n,), ends (n, 2, 2) of parameters, and points
    (n, 3, CELLS + 1, CELLS + 1)."""

    patch: np.ndarray
    ends: Array
    points: Array

    def boxes(self) -> list[Array]:
        """Corners (2, n, m, m, 3) of the boxes of m × m cells, for m = 1, 2, 4, ... `CELLS`."""
        p = np.moveaxis(self.points, 1, -1)
        four = np.stack([p[:, :-1, :-1], p[:, 1:, :-1], p[:, :-1, 1:], p[:, 1:, 1:]])
        sag = self.sags()[:, None, None, None]
        levels = [np.stack([four.min(axis=0) - sag, four.max(axis=0) + sag])]
        while levels[0].shape[2] > 1:
            fine = levels[0]
            m = fine.shape[2] // 2
            parts = fine.reshape(2, len(p), m, 2, m, 2, 3)
            levels.insert(0, np.stack([parts[0].min(axis=(2, 4)), parts[1].max(axis=(2, 4))]))
        return levels

    def sags(self) -> Array:
        """How far (n,) a surface bulges from its cells: twice what second differences say."""
        bends = [np.diff(self.points, 2, axis=axis) for axis in (2, 3)]
        return 0.25 * np.sum([np.linalg.norm(b, axis=1).max(axis=(1, 2)) for b in bends], axis=0)


def find_crossing(patches: Sequence[Patch]) -> Crossing | None:
    """The first place at which two patches, or parts of one, cross; None if there is none."""
    surfaces = [patch.surface for patch in patches]
    blocks = _blocks(surfaces)
    size = float(np.ptp(blocks.points, axis=(0, 2, 3)).max())
    starts: dict[tuple[int, int], list] = {}
    for first, second in _straddling(blocks, *_close_cells(blocks), 1e-7 * size):
        a, b = blocks.patch[first[0]], blocks.patch[second[0]]
        starts.setdefault((int(a), int(b)), []).append((first, second))
    for (a, b), pairs in starts.items():
        chosen = pairs[:: -(-len(pairs) // TRIALS)]
        at = np.array([[*_middle(blocks, f), *_middle(blocks, s)] for f, s in chosen]).T
        for place in _common_points(surfaces[a], surfaces[b], at, size, a == b):
            return Crossing((a, b), place)
    return None


def _blocks(surfaces: Sequence[Nurbs]) -> _Blocks:
    shares = np.linspace(0, 1, CELLS + 1)
    patch, ends, points = [], [], []
    for index, surface in enumerate(surfaces):
        breaks = []
        for axis in (0, 1):
            found = surface.breaks(axis)
            count = min(len(found) - 1, MOST_BLOCKS)
            breaks.append(found[np.linspace(0, len(found) - 1, count + 1).astype(int)])
        lines = [
            np.append((b[:-1, None] + np.diff(b)[:, None] * shares[:-1]).ravel(), b[-1])
            for b in breaks
        ]
        grid = surface.evaluate(*np.meshgrid(*lines, indexing="ij"))
        spans = [enumerate(pairwise(b)) for b in breaks]
        for (i, u), (j, v) in product(*spans):
            patch.append(index)
            ends.append((u, v))
            rows, columns = (slice(k * CELLS, (k + 1) * CELLS + 1) for k in (i, j))
            points.append(grid[:, rows, columns])
    return _Blocks(np.array(patch), np.array(ends), np.array(points))


def _close_cells(blocks: _Blocks) -> tuple[np.ndarray, np.ndarray]:
    """Block, row and column (n, 3) of cells whose boxes meet: first and second of pairs."""
    levels = blocks.boxes()
    low, high = (levels[0][k].reshape(-1, 3) for k in (0, 1))
    found = []
    for start in range(0, len(low), ROWS):
        rows = slice(start, start + ROWS)
        meet = (low[rows, None] <= high).all(axis=2) & (high[rows, None] >= low).all(axis=2)
        a, b = np.nonzero(np.triu(meet, start))
        found.append(np.stack([a + start, b]))
    a, b = np.concatenate(found, axis=1)
    a, b = np.stack([a, b])[:, ~_in_one_plane(blocks, a, b)]
    zeros = np.zeros((len(a), 2), dtype=int)
    first, second = np.column_stack([a, zeros]), np.column_stack([b, zeros])
    quarters = np.array(list(product((0, 1), repeat=2)))
    for boxes in levels[1:]:
        first, second = (
            np.repeat(np.repeat(cells, 4, axis=0), 4, axis=0) if k == 0
            else np.repeat(cells, 16, axis=0)
            for k, cells in enumerate((first, second))
        )  # fmt: skip
        count = len(first) // 16
        first[:, 1:] = 2 * first[:, 1:] + np.tile(np.repeat(quarters, 4, axis=0), (count, 1))
        second[:, 1:] = 2 * second[:, 1:] + np.tile(quarters, (4 * count, 1))
        one, other = boxes[:, *first.T], boxes[:, *second.T]
        meet = (one[0] <= other[1]).all(axis=1) & (one[1] >= other[0]).all(axis=1)
        ordered = (first[:, 0] != second[:, 0]) | (_number(first) <= _number(second))
        first, second = first[meet & ordered], second[meet & ordered]
    apart = np.abs(first[:, 1:] - second[:, 1:]).max(axis=1) > 1
    kept = apart | (first[:, 0] != second[:, 0])
    return first[kept], second[kept]


def _in_one_plane(blocks: _Blocks, first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """Which pairs of blocks lie in one plane, where they do not cross."""
    points = blocks.points.reshape(*blocks.points.shape[:2], -1)
    corners = blocks.points[:, :, [0, -1, 0], [0, 0, -1]]
    normals = np.cross(corners[:, :, 1] - corners[:, :, 0], corners[:, :, 2] - corners[:, :, 0])
    lengths = np.linalg.norm(normals, axis=1)
    normals /= np.maximum(lengths, 1e-300)[:, None]
    size = float(np.ptp(points, axis=(0, 2)).max())
    heights = np.einsum("nd,ndp->np", normals, points)
    flat = (np.ptp(heights, axis=1) < IN_PLANE * size) & (lengths > IN_PLANE * size**2)
    level = np.einsum("nd,ndp->np", normals[first], points[second])
    off = np.abs(level - heights[first, :1]).max(axis=1)
    return flat[first] & flat[second] & (off < IN_PLANE * size)


def _number(cells: np.ndarray) -> np.ndarray:
    return cells[:, 1] * CELLS + cells[:, 2]


def _straddling(
    blocks: _Blocks, first: np.ndarray, second: np.ndarray, near: float
) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Pairs of cells of which each has corners on both sides of the other."""
    sags = blocks.sags()
    kept = np.ones(len(first), dtype=bool)
    for one, other in ((first, second), (second, first)):
        base, corners = _corners(blocks, one), _corners(blocks, other)
        normal = np.cross(base[:, 3] - base[:, 0], base[:, 2] - base[:, 1])
        length = np.linalg.norm(normal, axis=1)
        normal = normal / np.maximum(length, 1e-300)[:, None]
        off = ((corners - base.mean(axis=1)[:, None]) * normal[:, None]).sum(axis=2)
        room = 0.02 * sags[one[:, 0]] + near  # what only seems to cross is found out later
        kept &= (off.min(axis=1) < -room) & (off.max(axis=1) > room)
    return zip(first[kept], second[kept], strict=True)


def _corners(blocks: _Blocks, cells: np.ndarray) -> Array:
    """Corners (n, 4, 3) of cells."""
    block, row, column = cells.T
    places = ((row, column), (row + 1, column), (row, column + 1), (row + 1, column + 1))
    return np.stack([blocks.points[block, :, i, j] for i, j in places], axis=1)


def _middle(blocks: _Blocks, cell: np.ndarray) -> Array:
    """Parameters (2,) of the middle of a cell."""
    low, high = blocks.ends[cell[0]].T
    return low + (high - low) * (cell[1:] + 0.5) / CELLS


def _common_points(
    first: Nurbs, second: Nurbs, at: Array, size: float, same: bool
) -> Iterator[Array]:
    """Points (3,) inside both surfaces, reached from parameters (4, n), where they cross."""
    low, high = np.array([*first.domain, *second.domain]).T[:, :, None]
    for _ in range(STEPS):
        gap, tangents = _tangents(first, second, at)
        step = np.einsum("nij,jn->in", np.linalg.pinv(tangents, rcond=1e-6), -gap)
        at = np.clip(at + np.clip(step, -0.2 * (high - low), 0.2 * (high - low)), low, high)
    gap, tangents = _tangents(first, second, at)
    lengths = np.linalg.norm(tangents, axis=1).T
    inside = (np.minimum(at - low, high - at) * lengths).min(axis=0) > MARGIN * size
    normals = [area_vector(tangents[:, :, k].T, tangents[:, :, k + 1].T) for k in (0, 2)]
    one, other = (n / np.maximum(np.linalg.norm(n, axis=0), 1e-300) for n in normals)
    across = np.linalg.norm(area_vector(one, other), axis=0) > FLAT
    apart = np.ones(at.shape[1], dtype=bool)
    if same:
        apart = (np.abs(at[:2] - at[2:]) > 0.02 * (high - low)[:2]).any(axis=0)
    found = inside & across & apart & (np.linalg.norm(gap, axis=0) < EXACT * size)
    if found.any():
        yield from first.evaluate(*at[:2, found]).T


def _tangents(first: Nurbs, second: Nurbs, at: Array) -> tuple[Array, Array]:
    """The distance (3, n) between points of both surfaces, and its derivatives (n, 3, 4)."""
    one, other = first.derivatives(1, *at[:2]), second.derivatives(1, *at[2:])
    gap = one[0, 0] - other[0, 0]
    tangents = np.stack([one[1, 0], one[0, 1], -other[1, 0], -other[0, 1]], axis=1)
    return gap, np.moveaxis(tangents, 2, 0)
