"""Curves in which a plane cuts faces: the face of each, and its exact curve where there is one."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from cadbem.cad.faces.face_geometry import located, parameter_box, parameter_curves
from cadbem.cad.faces.surfaces import surface_nurbs
from cadbem.cad.kernel.brep import BrepFace
from cadbem.cad.layout.rings import crossings, polyline
from cadbem.errors import CadError
from cadbem.spline.basis import Array
from cadbem.spline.nurbs import Nurbs
from cadbem.spline.project import closest_point

SNAP = 1e-9  # parameters this near to a knot, relative to the range, mean the knot


@dataclass(frozen=True, eq=False)
class CutFace:
    """A face, with its surface over the rectangle of its parameters."""

    face: BrepFace
    surface: Nurbs

    def touches(self, point: Array, near: float) -> Array | None:
        """Parameters (2,) of a point (3,) of the surface; None if it lies elsewhere."""
        net = self.surface.points.reshape(-1, 3)
        if (point < net.min(axis=0) - near).any() or (point > net.max(axis=0) + near).any():
            return None
        parameters, distance = closest_point(self.surface, point)
        return parameters if distance < near else None

    def holds(self, parameters: Array) -> bool:
        """Whether the face's loops run round the parameters."""
        borders = map(polyline, parameter_curves(self.face))
        return sum(crossings(border, parameters) for border in borders) % 2 == 1

    def curve(self, cut: Nurbs, near: float) -> Nurbs:
        """The parameter line of the surface that runs along the cut, else the cut itself."""
        low, high = cut.domain[0]
        middle = cut.evaluate(0.5 * (low + high))
        place, _ = closest_point(self.surface, middle)
        for direction in (0, 1):
            line = _parameter_line(self.surface, direction, place[direction])
            ends = sorted(_snapped(line, closest_point(line, x)[0][0]) for x in cut.points[[0, -1]])
            if ends[0] < ends[1]:
                piece = line.restricted((ends[0], ends[1]))
                samples = cut.evaluate(np.linspace(low, high, 9)).T
                if max(closest_point(piece, x)[1] for x in samples) < near:
                    return piece
        return cut


def face_at(faces: Iterable[CutFace], point: Array, near: float) -> CutFace | None:
    """The face that a point (3,) lies in, or on the border of; None if there is none."""
    touched = [(face, face.touches(point, near)) for face in faces]
    around = [(face, place) for face, place in touched if place is not None]
    inside = [face for face, place in around if face.holds(place)]
    return next(iter([*inside, *(face for face, _ in around)]), None)


def cut_faces(faces: Iterable[BrepFace]) -> list[CutFace]:
    """Faces whose surfaces are NURBS; curves on other faces cannot be assigned to them."""
    found = []
    for face in faces:
        box = parameter_box(face)
        try:
            if box is not None:
                found.append(CutFace(face, located(surface_nurbs(face.surface, *box), face)))
        except CadError:
            continue
    return found


def _parameter_line(surface: Nurbs, direction: int, value: float) -> Nurbs:
    """The curve on which one parameter has a value."""
    low, high = surface.domain[direction]
    bounds = list(surface.domain)
    bounds[direction] = (low, value) if value > low else (low, high)
    part = surface.restricted(*bounds)
    row = -1 if value > low else 0
    points, weights = (np.take(net, row, axis=direction) for net in (part.points, part.weights))
    return Nurbs((part.degrees[1 - direction],), (part.knots[1 - direction],), points, weights)


def _snapped(curve: Nurbs, parameter: float) -> float:
    knots = curve.breaks(0)
    nearest = knots[np.argmin(np.abs(knots - parameter))]
    return float(nearest if abs(nearest - parameter) < SNAP * np.ptp(knots) else parameter)
