"""Shear flow between moving plates, in space and in a plane."""

from __future__ import annotations

import numpy as np

from cadbem.boundary import Boundary, Patch
from cadbem.problems.conditions import Background, Velocity
from cadbem.problems.stokes import StokesProblem
from cadbem.quadrature import Quadrature
from cadbem.spline.outlines import rectangle
from cadbem.spline.shapes import plate
from cadbem.suspension.surroundings.channel_flow import ChannelFlow


def between_plates(
    half_width: float, side: float = 12.0, spans: int = 8, rings: int = 2
) -> ChannelFlow:
    """Shear flow between plates of a ``side`` in half widths, with ``spans`` elements a side of
    their middle, and ``rings`` outwards."""
    middle = max(3.5, 2 * half_width)
    square = plate(middle, side * half_width, degree=2, spans=spans, rings=rings)
    heights = {"plate_low": -half_width, "plate_high": half_width}
    patches = [
        Patch(surface.transformed(np.eye(3), np.array([0.0, 0.0, z])), name)
        for name, z in heights.items()
        for surface in square
    ]
    speeds = {name: Velocity((z, 0.0, 0.0)) for name, z in heights.items()}
    shear = Background(lambda x: np.stack([x[2], 0 * x[0], 0 * x[0]]))
    boundary = Boundary(tuple(patches))
    return ChannelFlow(StokesProblem(boundary, 1.0, speeds, Quadrature(1e-4), shear))


def between_plane_plates(half_width: float, length: float = 10.0, parts: int = 8) -> ChannelFlow:
    """Shear flow between plates, in a channel whose length is in half widths; elements are one of
    so many parts of a half width."""
    high = np.array([length * half_width / 2, half_width])
    names = ("left", "right", "wall_low", "wall_high")
    sides = zip(rectangle(-high, high), names, strict=True)
    boundary = Boundary(tuple(Patch(side, name) for side, name in sides))
    boundary = boundary.elevated(2).refined(size=half_width / parts)
    shear = Velocity(lambda x: np.stack([x[1], 0 * x[0]]))
    conditions = {name: shear for name in names}
    return ChannelFlow(StokesProblem(boundary, 1.0, conditions, Quadrature(1e-6)))
