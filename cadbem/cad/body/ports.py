"""Openings of a channel in a chip: faces in the flat sides of the chip's box."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from cadbem.cad.faces.face_geometry import edge_points
from cadbem.cad.kernel.brep import BrepFace
from cadbem.cad.kernel.brep_geometry import PLANE
from cadbem.spline.basis import Array

ON_BOX = 1e-6  # distance from a side of the box, per size, within which a face is a port


@dataclass(frozen=True, eq=False)
class Ports:
    """Finds ports in the sides of a box (2, 3), corners in millimetres. Behind a side that is not
    `flat` (2, 3) the chip's outside begins."""

    box: Array
    flat: np.ndarray

    def names(self, faces: Sequence[BrepFace]) -> dict[int, str]:
        """port_1, port_2, ... by x, then y, then z of the middle of each, by number of the face."""
        sides = [face for face in faces if self._sides(face).any()]
        ports = [(self.grid(_middle(face)), face.number) for face in sides]
        return {number: f"port_{k}" for k, (_, number) in enumerate(sorted(ports), start=1)}

    def grid(self, point: Array) -> tuple[float, ...]:
        """Coordinates on a grid, so that rounding does not decide an order."""
        return tuple(np.round((point - self.box[0]) / self._tolerance).tolist())

    @property
    def _tolerance(self) -> float:
        return ON_BOX * float(np.ptp(self.box, axis=0).max())

    def is_outside(self, faces: Sequence[BrepFace]) -> bool:
        """Whether a room reaches the outside."""
        return any((self._sides(face) & ~self.flat).any() for face in faces)

    def _sides(self, face: BrepFace) -> np.ndarray:
        """The sides (2, 3) that the face lies in."""
        if face.surface.kind != PLANE:
            return np.zeros((2, 3), dtype=bool)
        off = np.abs(edge_points(face)[:, None] - self.box).max(axis=0)
        return off < self._tolerance


def _middle(face: BrepFace) -> Array:
    points = edge_points(face)
    return 0.5 * (points.min(axis=0) + points.max(axis=0))
