"""Velocity inside and around droplets."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from cadbem.operators.closed import ClosedLayers
from cadbem.operators.closed_field import nearest_points
from cadbem.points import area_vector
from cadbem.spline.basis import Array
from cadbem.spline.closed import ClosedSpline
from cadbem.suspension.droplet import Droplet
from cadbem.suspension.together import Response, Surroundings, made_outside


def is_inside(shape: ClosedSpline, points: Array) -> Array:
    """Whether points (dim, M) lie inside a closed curve or surface: bool (M,)."""
    foot = nearest_points(shape, points)
    # away from the poles, where the parameters' derivatives vanish but the normal does not turn
    if shape.dimension == 3:
        foot = np.stack([np.clip(foot[0], 1e-6, np.pi - 1e-6), foot[1]])
    units = np.eye(len(foot), dtype=int)
    normal = area_vector(*(shape.evaluate(foot, tuple(unit)) for unit in units))
    return ((points - shape.evaluate(foot)) * normal).sum(axis=0) < 0


def velocity_at(
    surroundings: Surroundings,
    droplets: Sequence[Droplet],
    layers: Sequence[ClosedLayers],
    responses: Sequence[Response],
    points: ArrayLike,
) -> Array:
    """Velocity (dim, M) at points (dim, M) off the interfaces.

    The flow without droplets, what each of them makes (see ``together``) and what walls make of
    that; inside a droplet all this is λ times the velocity.
    """
    position = np.ascontiguousarray(points, dtype=float)

    def induced(at: Array) -> Array:
        parts = zip(droplets, layers, responses, strict=True)
        return np.sum([_made(surroundings, *part, at) for part in parts], axis=0)

    total = surroundings.velocity(position, induced) + induced(position)
    for d in droplets:
        total = np.where(is_inside(d.shape, position), total / d.viscosity_ratio, total)
    return total


def _made(
    surroundings: Surroundings,
    droplet: Droplet,
    layers: ClosedLayers,
    response: Response,
    points: Array,
) -> Array:
    """What a droplet makes: (-S[Δf] / μ + (1 - λ) D[u]) / 2h."""
    basis, ratio = layers.operator.basis, droplet.viscosity_ratio
    jump = basis.fit(response.jump(layers.targets).reshape(-1, *basis.shape))
    doubled = None if ratio == 1.0 else (1 - ratio) * response.velocity
    return made_outside(layers, -jump / surroundings.viscosity, doubled, points)
