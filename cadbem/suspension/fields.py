"""Velocity inside and around a droplet in unbounded flow."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from cadbem.operators.closed import ClosedLayers
from cadbem.operators.closed_field import nearest_points, off_surface
from cadbem.points import area_vector
from cadbem.spline.basis import Array
from cadbem.spline.closed import ClosedSpline
from cadbem.suspension.droplet import Droplet
from cadbem.suspension.free_flow import FreeFlow
from cadbem.suspension.together import Response


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
    flow: FreeFlow, droplet: Droplet, layers: ClosedLayers, response: Response, points: ArrayLike
) -> Array:
    """Velocity (dim, M) at points (dim, M) off the interface.

    α u = 2h u∞ - S[Δf] / μ + (1 - λ) D[u] with α = 2h outside and 2h λ inside, h = 4π (3D) or 2π.
    """
    position, targets = np.ascontiguousarray(points, dtype=float), layers.targets
    basis, ratio = layers.operator.basis, droplet.viscosity_ratio
    jump = basis.fit(response.jump(targets).reshape(-1, *basis.shape))
    doubled = None if ratio == 1.0 else (1 - ratio) * response.velocity
    half = 2 * np.pi * (layers.spline.dimension - 1)
    disturbance = off_surface(layers, -jump / flow.viscosity, doubled, position) / (2 * half)
    share = np.where(is_inside(droplet.shape, position), ratio, 1.0)
    return (flow.background.velocity(position) + disturbance) / share
