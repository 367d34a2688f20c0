"""Mouths of rooms in a solid: rings of edges in a face from which a wall goes into the material.

A hole in a face is a mouth if the faces beyond its edges lie behind it; a stub's base, whose wall
rises, is none. Plane faces that continue each other count as one. A mouth is capped by a face of
its own, on the same surface.
"""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from cadbem.cad.faces.evaluate import KernelSurface
from cadbem.cad.faces.face_geometry import (
    edge_points,
    parameter_box,
    parameter_curves,
    plane_of,
    points_on,
    real_uses,
    size_of,
)
from cadbem.cad.kernel.brep import BrepFace, EdgeUse
from cadbem.cad.kernel.brep_geometry import PLANE
from cadbem.spline.basis import Array

SAME = 1e-6  # distance, per size of the model, within which planes and corners are the same


@dataclass(frozen=True, eq=False)
class Mouth:
    """A ring of edges: indices of the faces that it is a hole of and of those beyond, the face that
    caps it (normal out of the material, number 0), its middle (3,) and its diameter, mm."""

    hosts: frozenset[int]
    walls: frozenset[int]
    keys: frozenset[tuple]
    cap: BrepFace
    middle: Array
    diameter: float


def find_mouths(faces: Sequence[BrepFace]) -> list[Mouth]:
    """All mouths in the faces of solids, whose normals point out of the material."""
    at_edge: dict[tuple, set[int]] = defaultdict(set)
    for index, face in enumerate(faces):
        for use in real_uses(face):
            at_edge[use.key].add(index)
    near = SAME * size_of(*faces)
    found = []
    for group in _coplanar(faces, at_edge, near):
        for loop in _loops(faces, group, near):
            mouth = _mouth(faces, group, loop, at_edge)
            if mouth is not None:
                found.append(mouth)
    return found


def _coplanar(
    faces: Sequence[BrepFace], at_edge: dict[tuple, set[int]], near: float
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


def _loops(
    faces: Sequence[BrepFace], group: list[int], near: float
) -> list[list[tuple[int, EdgeUse]]]:
    """The holes of a group of faces: face and pass of each edge. The outer loop is the largest."""
    if len(group) == 1:
        loops = [[(group[0], use) for use in loop] for loop in faces[group[0]].loops]
        loops = [loop for loop in loops if all(use.curve is not None for _, use in loop)]
    else:
        uses = [(k, use) for k in group for use in real_uses(faces[k])]
        counts = Counter(use.key for _, use in uses)
        loops = _chained(faces, [item for item in uses if counts[item[1].key] == 1], near)
    if len(loops) < 2:
        return []
    sizes = [float(np.linalg.norm(np.ptp(_points(loop), axis=0))) for loop in loops]
    return [loop for k, loop in enumerate(loops) if k != int(np.argmax(sizes))]


def _points(loop: list[tuple[int, EdgeUse]]) -> Array:
    return np.concatenate([points_on(use) for _, use in loop])


def _chained(
    faces: Sequence[BrepFace], uses: list[tuple[int, EdgeUse]], near: float
) -> list[list[tuple[int, EdgeUse]]]:
    """Passes along edges from end to end, closed loops only."""
    ends = [
        use.ends[:: use.sign * faces[k].outward] for k, use in uses
    ]  # as the border of the group runs
    left, loops = list(range(len(uses))), []
    while left:
        chain = [left.pop(0)]
        while np.abs(ends[chain[-1]][1] - ends[chain[0]][0]).max() > near:
            here = ends[chain[-1]][1]
            after = [k for k in left if np.abs(ends[k][0] - here).max() <= near]
            if not after:
                break
            chain.append(after[0])
            left.remove(after[0])
        else:
            loops.append([uses[k] for k in chain])
    return loops


def _mouth(
    faces: Sequence[BrepFace],
    group: list[int],
    loop: list[tuple[int, EdgeUse]],
    at_edge: dict[tuple, set[int]],
) -> Mouth | None:
    keys = frozenset(use.key for _, use in loop)
    walls = frozenset(k for key in keys for k in at_edge[key]) - frozenset(group)
    host = faces[loop[0][0]]
    ring = _points(loop)
    middle = 0.5 * (ring.min(axis=0) + ring.max(axis=0))
    normal = _normal(host, loop[0][1])
    if not walls or normal is None:
        return None
    beyond = np.concatenate([edge_points(faces[k]) for k in walls])
    if (beyond - ring.mean(axis=0)).mean(axis=0) @ normal >= 0:  # a stub stands there
        return None
    around = tuple(
        replace(use, sign=-use.sign * faces[k].outward * host.outward) for k, use in reversed(loop)
    )
    cap = replace(host, number=0, loops=(around,), key=("cap", *sorted(map(hash, keys))))
    return Mouth(
        frozenset(group), walls, keys, cap, middle, float(np.ptp(ring, axis=0).max())
    )


def _normal(host: BrepFace, use: EdgeUse) -> Array | None:
    """The face's normal out of the material, at the middle of one of its edges."""
    if host.surface.kind == PLANE:
        normal = np.cross(*plane_of(host)[1])
    else:
        box = parameter_box(host)
        if box is None:
            return None
        uses = [u for loop in host.loops for u in loop]
        curve = parameter_curves(host)[next(k for k, u in enumerate(uses) if u is use)]
        at = curve.evaluate(np.array([np.mean(curve.domain[0])]))
        surface = KernelSurface(host.surface, *box, host.matrix)
        _, along_u, along_v = surface.frames(*at)
        normal = np.cross(along_u[:, 0], along_v[:, 0])
    return host.outward * normal / np.linalg.norm(normal)
