"""Jumps of the wall shear where elements join smoothly: the exact one has none there."""

from __future__ import annotations

from itertools import product

import numpy as np

from cadbem.boundary import Boundary
from cadbem.elements.shape import side_parameters
from cadbem.operators.locate import touching
from cadbem.points import SurfacePoints, join, surface_points
from cadbem.problems.conditions import NoSlip
from cadbem.problems.equations import StokesEquations
from cadbem.space import Field
from cadbem.spline.basis import Array

SAMPLES = 5  # a side of an element
ON = 1e-6  # share of an element's length within which a point lies on it
SMOOTH = 0.999  # cosine of the angle between normals


def shear(traction: Field, patch: int, parameters: list[Array]) -> Array:
    """Tangential traction (dim, N) at parameters of a patch."""
    values = traction.on_patch(patch, *parameters)
    normal = surface_points(traction.space.boundary.patches[patch].surface, *parameters).normal
    return values - (values * normal).sum(axis=0) * normal


def shear_jumps(equations: StokesEquations, traction: Field) -> Array:
    """The largest difference (P,) of the wall shear across the sides of each wall's patch to
    others that go on smoothly; 0 where there are none."""
    boundary = equations.boundary
    walls = [i for i, kind in enumerate(equations.kinds) if isinstance(kind, NoSlip)]
    result = np.zeros(len(boundary.patches))
    if boundary.dimension == 2 or not walls:
        return result
    points, owner, here = _sides(boundary, traction, walls)
    for i in walls:
        target, parameters = touching(boundary.patches[i].surface, points.position, ON)
        others = owner[target] != i
        target, place = target[others], list(parameters[:, others])
        if not len(target):
            continue
        normal = surface_points(boundary.patches[i].surface, *place).normal
        smooth = (normal * points.normal[:, target]).sum(axis=0) > SMOOTH
        jump = np.linalg.norm(shear(traction, i, place) - here[:, target], axis=0)[smooth]
        result[i] = max(result[i], jump.max(initial=0.0))
        np.maximum.at(result, owner[target[smooth]], jump)
    return result


def _sides(
    boundary: Boundary, traction: Field, walls: list[int]
) -> tuple[SurfacePoints, Array, Array]:
    """Points on the sides of walls' patches, their patches (N,), and the shear there (dim, N)."""
    points, owner, values = [], [], []
    for i in walls:
        surface = boundary.patches[i].surface
        for side in product((0, 1), (0, 1)):
            place = side_parameters(surface, side, SAMPLES)
            points.append(surface_points(surface, *place))
            owner.append(np.full(SAMPLES, i))
            values.append(shear(traction, i, place))
    return join(points), np.concatenate(owner), np.concatenate(values, axis=1)
