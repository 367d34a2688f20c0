"""Labels of the faces in a CAD file: names, layers and colours; and its unit of length."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial import cKDTree

from cadbem.cad.faces.face_geometry import points_on
from cadbem.cad.kernel.brep import BrepFace, EdgeUse
from cadbem.cad.text.unit import Unit
from cadbem.errors import CadError, printable
from cadbem.spline.basis import Array

MATCH = 1e-6  # distance, per size of the model, within which corners are the same
LIKE = 0.25  # distance of edges' middles, per size of the face, up to which faces are the same
CLEAR = 1e-3  # as LIKE, by which the next best match must be worse
CHOICES = {"names": "name", "layers": "layer", "colours": "colour"}


@dataclass(frozen=True, eq=False)
class FaceLabel:
    """A face as the text describes it: enough to find it again in the kernel's model."""

    name: str
    corners: Array  # (n, 3), in the file's unit
    middles: Array  # (m, 3), a point for each edge: the middle, or the mean of control points
    layer: str = ""
    colour: str = ""  # "#rrggbb"

    def __post_init__(self) -> None:
        for kind in ("name", "layer", "colour"):
            object.__setattr__(self, kind, printable(getattr(self, kind)))

    @property
    def texts(self) -> tuple[str, str, str]:
        return self.name, self.layer, self.colour

    def scaled(self, factor: float) -> FaceLabel:
        return replace(self, corners=self.corners * factor, middles=self.middles * factor)

    def moved(self, matrix: Array) -> FaceLabel:
        """Turned and shifted by a matrix (4, 4)."""
        turning, shift = matrix[:3, :3].T, matrix[:3, 3]
        corners, middles = self.corners @ turning + shift, self.middles @ turning + shift
        return replace(self, corners=corners, middles=middles)


def check_choice(names: str) -> None:
    """Raises CadError if faces cannot be named by that."""
    if names not in CHOICES:
        raise CadError(f"names={names!r}: faces are named by 'names', 'layers' or 'colours'")


def chosen(labels: dict[int, FaceLabel], names: str) -> dict[int, str]:
    """The label of each face by "names", "layers" or "colours"; faces without one are left out."""
    called = {number: getattr(label, CHOICES[names]) for number, label in labels.items()}
    return {number: name for number, name in called.items() if name}


def match_labels(
    labels: list[FaceLabel], faces: list[BrepFace], unit: Unit
) -> dict[int, FaceLabel]:
    """Labels by face number. A label belongs to a face with the same corners, in the model's axes
    or those of the face's part; among several, to the one whose edges run through the same
    places. A face without such a label, or with two that differ in what they say, has none."""
    labels = [_distinct(label.scaled(unit.millimetres)) for label in labels]
    labels = [label for label in labels if len(label.corners)]
    if not any(any(label.texts) for label in labels):
        return {}
    search = _Search.among(labels)
    claims = {face.number: search.nearest(face) for face in faces}
    best: dict[int, float] = {}
    for index, distance in claims.values():
        best[index] = min(distance, best.get(index, np.inf))
    return {
        number: labels[index]
        for number, (index, distance) in claims.items()
        if index >= 0 and distance < best[index] + CLEAR
    }


@dataclass(frozen=True, eq=False)
class _Search:
    labels: list[FaceLabel]
    centres: Array  # (n, 3), means of the corners
    tolerance: float

    @classmethod
    def among(cls, labels: list[FaceLabel]) -> _Search:
        points = np.concatenate([p for label in labels for p in (label.corners, label.middles)])
        centres = np.array([label.corners.mean(axis=0) for label in labels])
        return cls(labels, centres, MATCH * float(np.ptp(points, axis=0).max()))

    def nearest(self, face: BrepFace) -> tuple[int, float]:
        """Index of the label that is this face's, or -1, and how far its edges are off."""
        own = _mark_of(face)
        found = self._nearest(own)
        if found[0] < 0 and not np.allclose(face.matrix, np.eye(4)):
            return self._nearest(own.moved(np.linalg.inv(face.matrix)))
        return found

    def _nearest(self, own: FaceLabel) -> tuple[int, float]:
        if not len(own.corners):
            return -1, np.inf
        near = np.linalg.norm(self.centres - own.corners.mean(axis=0), axis=1) < 2 * self.tolerance
        same = [i for i in np.flatnonzero(near) if _agree(self.labels[i], own, self.tolerance)]
        ranked = sorted((_distance(self.labels[i], own), int(i)) for i in same)
        if not ranked or ranked[0][0] > LIKE:
            return -1, np.inf
        distance, first = ranked[0]
        rivals = [i for d, i in ranked[1:] if d < distance + CLEAR]
        if any(self.labels[i].texts != self.labels[first].texts for i in rivals):
            return -1, np.inf
        return first, distance


def _mark_of(face: BrepFace) -> FaceLabel:
    uses = [use for loop in face.loops for use in loop]
    corners = np.concatenate([use.ends for use in uses]) if uses else np.zeros((0, 3))
    middles = [_middle(use) for use in uses if use.curve is not None]
    return _distinct(FaceLabel("", corners, np.array(middles).reshape(-1, 3)))


def _middle(use: EdgeUse) -> Array:
    assert use.curve is not None
    if use.curve.spline is not None:
        return use.matrix[:3, :3] @ use.curve.spline.points.mean(axis=0) + use.matrix[:3, 3]
    points = points_on(use)
    return points[len(points) // 2]


def _distinct(label: FaceLabel) -> FaceLabel:
    """Each corner once."""
    if not len(label.corners):
        return label
    size = float(np.ptp(label.corners, axis=0).max())
    again = {later for _, later in cKDTree(label.corners).query_pairs(MATCH * size)}
    kept = [index for index in range(len(label.corners)) if index not in again]
    return replace(label, corners=label.corners[kept])


def _agree(first: FaceLabel, second: FaceLabel, tolerance: float) -> bool:
    if len(first.corners) != len(second.corners):
        return False
    gaps = np.linalg.norm(first.corners[:, None] - second.corners, axis=2)
    return bool(gaps.min(axis=0).max() < tolerance and gaps.min(axis=1).max() < tolerance)


def _distance(first: FaceLabel, second: FaceLabel) -> float:
    """Distance of the edges' middles, relative to the size of the face."""
    if not len(first.middles) or not len(second.middles):
        return 0.0
    gaps = np.linalg.norm(first.middles[:, None] - second.middles, axis=2)
    size = np.ptp(np.concatenate([second.corners, second.middles]), axis=0).max()
    return float(max(gaps.min(axis=0).max(), gaps.min(axis=1).max()) / max(size, 1e-300))
