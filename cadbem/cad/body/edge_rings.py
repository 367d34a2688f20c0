"""Closed rings of edges: holes in faces, and full circles."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from cadbem.cad.faces.face_geometry import edge_points, plane_of, points_on, real_uses
from cadbem.cad.faces.wraps import parameter_loop
from cadbem.cad.kernel.brep import BrepFace, EdgeUse
from cadbem.cad.kernel.brep_geometry import PLANE
from cadbem.spline.basis import Array

NEARLY = 1e-4  # distance of edges from a plane or a circle, per its size, that is let pass


@dataclass(frozen=True, eq=False)
class Pass:
    """The index of a face, and its pass along an edge."""

    face: int
    use: EdgeUse


@dataclass(frozen=True, eq=False)
class EdgeRing:
    """Passes that follow each other round a ring."""

    passes: tuple[Pass, ...]

    @property
    def keys(self) -> frozenset[tuple]:
        return frozenset(p.use.key for p in self.passes)

    @property
    def points(self) -> Array:
        """Points (n, 3) along the edges, mm."""
        return np.concatenate([points_on(p.use) for p in self.passes])

    @property
    def middle(self) -> Array:
        points = self.points
        return 0.5 * (points.min(axis=0) + points.max(axis=0))

    @property
    def diameter(self) -> float:
        """Of the ring's box, along the axis where it is widest."""
        return float(np.ptp(self.points, axis=0).max())

    @property
    def normal(self) -> Array:
        """Of the plane nearest to the ring, to either side."""
        points = self.points
        return np.linalg.svd(points - points.mean(axis=0))[2][2]

    def is_flat(self, near: float) -> bool:
        points = self.points
        off = np.abs((points - points.mean(axis=0)) @ self.normal).max()
        return bool(off < max(near, NEARLY * self.diameter))


def holes(
    faces: Sequence[BrepFace], at_edge: dict[tuple, list[int]], near: float
) -> Iterator[tuple[frozenset[int], EdgeRing]]:
    """Groups of faces that continue each other, each with one of its holes."""
    for group in _coplanar(faces, at_edge, near):
        for loop in _loops(faces, group, near):
            yield frozenset(group), EdgeRing(tuple(loop))


def circles(
    faces: Sequence[BrepFace], at_edge: dict[tuple, list[int]], near: float
) -> list[EdgeRing]:
    """Edges that form full circles together, each of which two faces share."""
    arcs: list[tuple[Array, list[Pass]]] = []  # centre and radius of each circle
    known = set()
    for index, face in enumerate(faces):
        for use in real_uses(face):
            pair = at_edge[use.key]
            if use.key in known or not len(set(pair)) == len(pair) == 2:
                continue
            known.add(use.key)
            circle = _circle(points_on(use))
            if circle is not None:
                reach = max(near, NEARLY * circle[3])
                same = [found for place, found in arcs if np.abs(place - circle).max() < reach]
                if same:
                    same[0].append(Pass(index, use))
                else:
                    arcs.append((circle, [Pass(index, use)]))
    loops = [loop for _, passes in arcs for loop in chained(faces, passes, near, oriented=False)]
    return [EdgeRing(tuple(loop)) for loop in loops]


def _circle(points: Array) -> Array | None:
    """Centre and radius (4,) of the circle on which points lie; None if there is none."""
    a, b, c = points[0], points[len(points) // 3], points[2 * len(points) // 3]
    u, v = b - a, c - a
    w = np.cross(u, v)
    square = float(w @ w)
    if square < 1e-12 * float((u @ u) * (v @ v)):
        return None
    centre = a + np.cross((u @ u) * v - (v @ v) * u, w) / (2 * square)
    radii = np.linalg.norm(points - centre, axis=1)
    off = max(np.ptp(radii), np.abs((points - a) @ w).max() / np.sqrt(square))
    return np.append(centre, radii[0]) if off < NEARLY * radii[0] else None


def _coplanar(
    faces: Sequence[BrepFace], at_edge: dict[tuple, list[int]], near: float
) -> list[list[int]]:
    """Plane faces that hang together by edges and lie in one plane; every other face alone."""
    left = list(range(len(faces)))
    groups = []
    while left:
        group = [left.pop(0)]
        for index in group:
            if faces[index].surface.kind != PLANE:
                break
            others = {k for use in real_uses(faces[index]) for k in at_edge[use.key]}
            joined = [k for k in left if k in others and _same_plane(faces[index], faces[k], near)]
            group += joined
            left = [k for k in left if k not in joined]
        groups.append(group)
    return groups


def _same_plane(face: BrepFace, other: BrepFace, near: float) -> bool:
    if other.surface.kind != PLANE:
        return False
    origin, axes = plane_of(face)
    normal = np.cross(*axes)
    facing = face.outward * other.outward * float(normal @ np.cross(*plane_of(other)[1]))
    return facing > 0 and bool(np.abs((edge_points(other) - origin) @ normal).max() < near)


def _loops(faces: Sequence[BrepFace], group: list[int], near: float) -> list[list[Pass]]:
    """The holes of a group of faces."""
    passes = [Pass(k, use) for k in group for use in real_uses(faces[k])]
    counts = Counter(item.use.key for item in passes)
    loops = chained(faces, [item for item in passes if counts[item.use.key] == 1], near)
    if faces[group[0]].surface.kind != PLANE:
        return [loop for loop in loops if _is_hole(faces[group[0]], loop)]
    sizes = [float(np.linalg.norm(np.ptp(EdgeRing(tuple(loop)).points, axis=0))) for loop in loops]
    return [loop for k, loop in enumerate(loops) if k != int(np.argmax(sizes))]


def _is_hole(face: BrepFace, loop: list[Pass]) -> bool:
    """Whether a loop of a curved face runs round a hole, not round the axis."""
    uses = [item.use for item in (loop if face.outward > 0 else loop[::-1])]
    around = parameter_loop(face, uses)
    return around is not None and around.area < 0


def chained(
    faces: Sequence[BrepFace], passes: list[Pass], near: float, oriented: bool = True
) -> list[list[Pass]]:
    """Passes along edges from end to end, closed loops only; edges may be run against their
    faces' sense if they are not `oriented`."""
    ends = [item.use.ends[:: item.use.sign * faces[item.face].outward] for item in passes]
    left, loops = list(range(len(passes))), []
    while left:
        chain = [left.pop(0)]
        start, here = ends[chain[0]]
        while np.abs(here - start).max() > near:
            after = [
                (k, side)
                for k in left
                for side in ((0,) if oriented else (0, 1))
                if np.abs(ends[k][side] - here).max() <= near
            ]
            if not after:
                break
            k, side = after[0]
            chain.append(k)
            left.remove(k)
            here = ends[k][1 - side]
        else:
            loops.append([passes[k] for k in chain])
    return loops
