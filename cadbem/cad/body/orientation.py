"""Faces as closed shells, each turned so that its normals point out of the material.

Neighbours must run along their common edge in opposite directions. One sign for each shell remains,
which follows from the volume that the shell encloses. So mirrored locations are read correctly, and
solids that a program wrote inside out as well.
"""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from cadbem.cad.faces.face_geometry import edge_points, real_uses
from cadbem.cad.faces.flux import face_flux
from cadbem.cad.kernel.brep import BrepFace
from cadbem.errors import CadError
from cadbem.spline.basis import Array


@dataclass(frozen=True, eq=False)
class Shell:
    """Faces that hang together by their edges, and the volume (mm³) on the side their normals
    (`outward` times ∂u × ∂v) point away from; nan if it is open or cannot be computed."""

    faces: tuple[BrepFace, ...]
    volume: float

    def flipped(self) -> Shell:
        """The same faces with normals to the other side."""
        turned = tuple(replace(face, outward=-face.outward) for face in self.faces)
        return Shell(turned, -self.volume)

    def bounds(self) -> Array:
        """Corners (2, 3) of the box of all edges, in millimetres."""
        points = np.concatenate([edge_points(face) for face in self.faces])
        return np.stack([points.min(axis=0), points.max(axis=0)])


def shells_of(faces: Sequence[BrepFace]) -> list[Shell]:
    """The faces of one solid, or loose ones, as shells with normals out of the material.

    The shell with the largest volume is the first; if all are closed, it is the outer one and the
    others are holes in it. Faces keep their numbers and their order within a shell.
    """
    shells = [_measured(group) for group in _connected(faces)]
    shells.sort(key=lambda shell: -np.nan_to_num(abs(shell.volume)))
    turned = [s if s.volume >= 0 or np.isnan(s.volume) else s.flipped() for s in shells[:1]]
    return turned + [s.flipped() if s.volume > 0 else s for s in shells[1:]]


def _connected(faces: Sequence[BrepFace]) -> list[list[BrepFace]]:
    """Groups that share edges, with their faces turned alike as far as possible."""
    at_edge: dict[tuple, list[int]] = defaultdict(list)
    for index, face in enumerate(faces):
        for use in real_uses(face):
            at_edge[use.key].append(index)
    turns: dict[int, int] = {}
    groups = []
    for start in range(len(faces)):
        if start in turns:
            continue
        turns[start], queue, group = 1, [start], []
        while queue:
            index = queue.pop()
            group.append(index)
            for other, same in _neighbours(faces, index, at_edge):
                if other not in turns:
                    turns[other] = turns[index] if same else -turns[index]
                    queue.append(other)
        groups.append([_turned(faces[index], turns[index]) for index in sorted(group)])
    return groups


def _turned(face: BrepFace, sign: int) -> BrepFace:
    return face if sign > 0 else replace(face, outward=-face.outward)


def _neighbours(
    faces: Sequence[BrepFace], index: int, at_edge: dict[tuple, list[int]]
) -> Iterator[tuple[int, bool]]:
    """Faces that share an edge with this one, and whether both are turned alike."""
    for use in real_uses(faces[index]):
        run = faces[index].outward * use.sign
        for other in at_edge[use.key]:
            if other != index:
                theirs = {u.sign for u in real_uses(faces[other]) if u.key == use.key}
                yield other, faces[other].outward * -run in theirs


def _measured(faces: list[BrepFace]) -> Shell:
    counts = Counter(use.key for face in faces for use in real_uses(face))
    return Shell(tuple(faces), enclosed(faces) if set(counts.values()) <= {2} else np.nan)


def enclosed(faces: Iterable[BrepFace]) -> float:
    """The volume (mm³) that closed faces enclose, positive if normals point out; nan if an edge or
    a surface does not allow it."""
    points = [points for face in faces if len(points := edge_points(face))]
    centre = np.mean([p.mean(axis=0) for p in points], axis=0) if points else np.zeros(3)
    try:
        return float(sum(face.outward * face_flux(face, centre) for face in faces))
    except CadError:
        return float("nan")
