"""Openings of a channel in a chip: faces in the sides of the chip's box."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from cadbem.cad.brep import BrepFace
from cadbem.cad.brep_geometry import PLANE
from cadbem.cad.face_geometry import edge_points
from cadbem.spline.basis import Array

ON_BOX = 1e-6  # distance from a side of the box, per size, within which a face is a port


@dataclass(frozen=True, eq=False)
class Ports:
    """Finds ports in the sides of a box (2, 3), corners in millimetres."""

    box: Array

    def names(self, faces: Sequence[BrepFace]) -> dict[int, str]:
        """port_1, port_2, ... by x, then y, then z of the middle of each, by number of the face."""
        ports = [(self.grid(_middle(face)), face.number) for face in faces if self._is_port(face)]
        return {number: f"port_{k}" for k, (_, number) in enumerate(sorted(ports), start=1)}

    def grid(self, point: Array) -> tuple[float, ...]:
        """Coordinates on a grid, so that rounding does not decide an order."""
        return tuple(np.round((point - self.box[0]) / self._tolerance).tolist())

    @property
    def _tolerance(self) -> float:
        return ON_BOX * float(np.ptp(self.box, axis=0).max())

    def _is_port(self, face: BrepFace) -> bool:
        if face.surface.kind != PLANE:
            return False
        off = np.abs(edge_points(face)[:, None] - self.box).max(axis=0)
        return bool(off.min() < self._tolerance)


def _middle(face: BrepFace) -> Array:
    points = edge_points(face)
    return 0.5 * (points.min(axis=0) + points.max(axis=0))
