"""Velocity inside and around bodies."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from cadbem.operators.far.equivalent import FarField
from cadbem.spline.basis import Array
from cadbem.suspension.bodies.body import Placed
from cadbem.suspension.multibody.multibody import FAR, MultibodySystem
from cadbem.suspension.surroundings.surroundings import Surroundings


def velocity_at(
    surroundings: Surroundings,
    bodies: Sequence[Placed],
    responses: Sequence[Any],
    points: ArrayLike,
    far: FarField | None = FAR,
) -> Array:
    """Velocity (dim, M) at points (dim, M) off the bodies' surfaces.

    The sum of the flow without bodies, of the velocity that each body induces, and of the velocity
    that walls reflect.  Inside a droplet this sum is λ times the velocity; inside a rigid body the
    velocity is that of the rigid motion.
    """
    position = np.ascontiguousarray(points, dtype=float)
    system = MultibodySystem(surroundings, tuple(bodies), far=far)
    densities = [r.densities for r in responses]
    at_walls = system.velocity_at_walls(densities)
    total = surroundings.at(position).velocity(at_walls)
    total = total + system.induced_at(position, densities)
    for body, response in zip(bodies, responses, strict=True):
        inside = body.distance(position) < 0
        total[:, inside] = body.inner_velocity(response, position[:, inside], total[:, inside])
    return total
