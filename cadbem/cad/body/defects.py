"""Defects of a shell: edges that belong to one face only or to three, and edges that coincide but
are not joined."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from cadbem.cad.faces.face_geometry import points_on, real_uses
from cadbem.cad.kernel.brep import BrepFace, EdgeUse
from cadbem.spline.basis import Array

OPEN = "belongs to this face only"
APART = "touches another face without being joined to it"
CROWDED = "belongs to more than two faces"
TURNED = "has its faces turned to different sides"
_SAME = 1e-6  # share of the size within which edges lie on each other


@dataclass(frozen=True, eq=False)
class Defect:
    """An edge, the numbers of the faces that have it, and what is wrong with it."""

    reason: str
    faces: tuple[int, ...]
    use: EdgeUse

    def place(self) -> Array:
        """A point (3,) in the middle of the edge, in millimetres."""
        points = points_on(self.use)
        return points[len(points) // 2]


def find_defects(faces: Sequence[BrepFace]) -> list[Defect]:
    """All edges that keep the faces from being a closed, oriented surface."""
    pairs = [(face, use) for face in faces for use in real_uses(face)]
    counts = Counter(use.key for _, use in pairs)
    return [*_free(pairs, counts), *_joined_badly(pairs, counts)]


def widest_gap(defects: Sequence[Defect]) -> float:
    """Largest distance (mm) of an open edge from the nearest other ones; inf if there are none."""
    points = [points_on(defect.use) for defect in defects]
    others = ([p for j, p in enumerate(points) if j != i] for i in range(len(points)))
    return max(map(_distances, points, others), default=np.inf)


def _distances(points: Array, others: list[Array]) -> float:
    """Largest distance of points (n, 3) from polylines (m, 3)."""
    if not others:
        return np.inf
    nearest = []
    for line in others:
        start, step = line[:-1], np.diff(line, axis=0)
        arm = points[:, None] - start
        share = (arm * step).sum(axis=2) / np.maximum((step**2).sum(axis=1), 1e-300)
        feet = start + np.clip(share, 0, 1)[:, :, None] * step
        nearest.append(np.linalg.norm(points[:, None] - feet, axis=2).min(axis=1))
    return float(np.min(nearest, axis=0).max())


def _free(pairs: list[tuple[BrepFace, EdgeUse]], counts: Counter) -> Iterator[Defect]:
    """Edges of one face: open ones, and those on the edge of another face. Both sides of a seam
    that are edges of their own are none."""
    alone: dict[int, list[EdgeUse]] = {}
    for face, use in pairs:
        if counts[use.key] == 1:
            alone.setdefault(face.number, []).append(use)
    left = [(n, use) for n, uses in alone.items() for use in _unpaired(uses)]
    open_uses = _unpaired([use for uses in alone.values() for use in uses])
    for number, use in left:
        is_open = any(use is other for other in open_uses)
        yield Defect(OPEN if is_open else APART, (number,), use)


def _joined_badly(pairs: list[tuple[BrepFace, EdgeUse]], counts: Counter) -> Iterator[Defect]:
    """Neighbours that are turned alike run along their common edge in opposite directions."""
    turns: Counter = Counter()
    numbers: dict[tuple, list[int]] = {}
    uses = {}
    for face, use in pairs:
        turns[use.key] += face.outward * use.sign
        numbers.setdefault(use.key, []).append(face.number)
        uses[use.key] = use
    for key, use in uses.items():
        if counts[key] > 2:
            yield Defect(CROWDED, tuple(numbers[key]), use)
        elif abs(turns[key]) > 1:
            yield Defect(TURNED, tuple(numbers[key]), use)


def _unpaired(free: list[EdgeUse]) -> list[EdgeUse]:
    """Edges that do not lie on another one."""
    points = [points_on(use) for use in free]
    if not points:
        return []
    tolerance = _SAME * float(np.ptp(np.concatenate(points), axis=0).max())
    middles = np.array([p.mean(axis=0) for p in points])
    paired: set[int] = set()
    for i, j in sorted(cKDTree(middles).query_pairs(tolerance)):
        if paired.isdisjoint((i, j)) and _coincide(points[i], points[j], tolerance):
            paired |= {i, j}
    return [use for k, use in enumerate(free) if k not in paired]


def _coincide(first: Array, second: Array, tolerance: float) -> bool:
    if len(first) != len(second):
        return False
    gaps = [np.abs(first - other).max() for other in (second, second[::-1])]
    return bool(min(gaps) < tolerance)
