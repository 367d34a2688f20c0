"""What a CAD file's text says beside its geometry: unit of length, names of faces."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial import cKDTree

from cadbem.cad.brep import BrepFace, EdgeUse
from cadbem.cad.face_geometry import points_on
from cadbem.spline.basis import Array

MATCH = 1e-6  # distance, per size of the model, within which corners are the same


@dataclass(frozen=True)
class Unit:
    """A unit of length; the kernel always works in millimetres."""

    name: str
    millimetres: float


@dataclass(frozen=True, eq=False)
class FaceMark:
    """A face as the text describes it: enough to find it again in the kernel's model."""

    name: str
    corners: Array  # (n, 3), in the file's unit
    middles: Array  # (m, 3), a point for each edge: the middle, or the mean of control points
    layer: str = ""
    colour: str = ""  # "#rrggbb"

    def scaled(self, factor: float) -> FaceMark:
        return replace(self, corners=self.corners * factor, middles=self.middles * factor)


def match_names(marks: list[FaceMark], faces: list[BrepFace], unit: Unit) -> dict[int, str]:
    """Names by face number. A mark belongs to the face with the same corners; among several,
    to the one whose edges run through the same places."""
    own = {face.number: _mark_of(face) for face in faces}
    marks = [_distinct(mark.scaled(unit.millimetres)) for mark in marks]
    marks = [mark for mark in marks if len(mark.corners)]
    if not any(mark.name for mark in marks):
        return {}
    corners = np.concatenate([mark.corners for mark in marks])
    tolerance = MATCH * float(np.ptp(corners, axis=0).max())
    centres = np.array([mark.corners.mean(axis=0) for mark in marks])
    names = {}
    for number, mark in own.items():
        near = np.linalg.norm(centres - mark.corners.mean(axis=0), axis=1) < 2 * tolerance
        same = [marks[i] for i in np.flatnonzero(near) if _agree(marks[i], mark, tolerance)]
        if same:
            names[number] = min(same, key=lambda other: _distance(other, mark)).name
    return {number: name for number, name in names.items() if name}


def _mark_of(face: BrepFace) -> FaceMark:
    uses = [use for loop in face.loops for use in loop]
    corners = np.concatenate([use.ends for use in uses]) if uses else np.zeros((0, 3))
    middles = [_middle(use) for use in uses if use.curve is not None]
    return _distinct(FaceMark("", corners, np.array(middles).reshape(-1, 3)))


def _middle(use: EdgeUse) -> Array:
    assert use.curve is not None
    if use.curve.spline is not None:
        return use.matrix[:3, :3] @ use.curve.spline.points.mean(axis=0) + use.matrix[:3, 3]
    points = points_on(use)
    return points[len(points) // 2]


def _distinct(mark: FaceMark) -> FaceMark:
    """Each corner once."""
    if not len(mark.corners):
        return mark
    size = float(np.ptp(mark.corners, axis=0).max())
    again = {later for _, later in cKDTree(mark.corners).query_pairs(MATCH * size)}
    kept = [index for index in range(len(mark.corners)) if index not in again]
    return replace(mark, corners=mark.corners[kept])


def _agree(first: FaceMark, second: FaceMark, tolerance: float) -> bool:
    if len(first.corners) != len(second.corners):
        return False
    gaps = np.linalg.norm(first.corners[:, None] - second.corners, axis=2)
    return bool(gaps.min(axis=0).max() < tolerance and gaps.min(axis=1).max() < tolerance)


def _distance(first: FaceMark, second: FaceMark) -> float:
    if not len(first.middles) or not len(second.middles):
        return 0.0
    gaps = np.linalg.norm(first.middles[:, None] - second.middles, axis=2)
    return float(gaps.min(axis=0).max() + gaps.min(axis=1).max())
