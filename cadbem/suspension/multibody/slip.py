"""How far off the velocities of bodies may be because the flow slips on walls near them.

Between the collocation points the boundary equation is not fulfilled: the velocity

    u = u∞ - (S f / μ - D u) / 2c

of bodies and walls together does not tend to the wall's own, but misses it by w, the residual of
the equation over 2c.  By reciprocity a body's velocity is then off by ∫ σ·w dS, where σ is the
traction on the wall of a unit force on the body.  All of σ makes up that force, and it falls like
the cube of the distance; so a mean of w with such weights says how far off the velocity is.
Contributions of patches may cancel by luck, so their sizes are added.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from cadbem.problems.conditions import OPEN
from cadbem.problems.estimates import coarser
from cadbem.problems.residual import CheckPoints, residual
from cadbem.spline.basis import Array
from cadbem.suspension.bodies.body import Densities
from cadbem.suspension.multibody.elements import Cloud
from cadbem.suspension.multibody.multibody import MultibodySystem
from cadbem.suspension.surroundings.channel_flow import ChannelFlow

NEAR = 1.0  # sizes of a body within which walls are checked
SAFETY = 4.0  # what the weights are off by, measured with spheres in a pipe and beside a plate


def velocity_errors(
    flow: ChannelFlow, system: MultibodySystem, densities: Sequence[Densities], sizes: list[float]
) -> list[float]:
    """By how much the velocity of each body, of a size, may be off: 0 far from walls."""
    clouds = [Cloud.of(body, size) for body, size in zip(system.bodies, sizes, strict=True)]
    away = [flow.elements.least(cloud.distance_to) for cloud in clouds]
    near = np.zeros(len(flow.solved.boundary.patches), dtype=bool)
    for distance, size in zip(away, sizes, strict=True):
        near[flow.elements.patch[distance < NEAR * size]] = True
    for i, kind in enumerate(flow.solved.kinds):
        near[i] &= not isinstance(kind, OPEN)
    if not near.any():
        return [0.0] * len(clouds)
    checks = CheckPoints.of(flow.solved.space).on(near)
    slip = _slip(flow, system, densities, checks)
    return [_error(cloud, checks, slip) for cloud in clouds]


def _slip(
    flow: ChannelFlow, system: MultibodySystem, densities: Sequence[Densities], checks: CheckPoints
) -> Array:
    """The slip (dim, N) at check points."""
    problem = flow.solved
    solution = flow.solution(system.velocity_at_walls(densities))
    twice = 2 * problem.system.free_term

    def source(points: CheckPoints) -> Array:
        return twice * system.induced_at(np.ascontiguousarray(points.points.position), densities)

    missed = residual(
        problem.system, checks, solution.velocity.coefficients, solution.traction.coefficients,
        source, coarser(problem.quadrature),
    )  # fmt: skip
    return missed / twice


def _error(cloud: Cloud, checks: CheckPoints, slip: Array) -> float:
    """The error of one body's velocity."""
    weights = checks.weights / cloud.distance_to(checks.points.position) ** len(slip)
    weights /= weights.sum()
    parts = [np.abs(np.bincount(checks.patch, weights * part)).sum() for part in slip]
    return SAFETY * float(max(parts))
