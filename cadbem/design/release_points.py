"""Release points of passive tracers on inlets, each with the flow rate that it represents."""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil

import numpy as np

from cadbem.checks import whole
from cadbem.errors import ConditionError
from cadbem.points import surface_points
from cadbem.problems.conditions import OPEN
from cadbem.problems.mixed import patches_named
from cadbem.problems.solution import StokesSolution
from cadbem.quadrature.gauss import gauss_on_breaks, tensor_rule
from cadbem.spline.basis import Array


@dataclass(frozen=True, eq=False)
class ReleasePoints:
    """Release points of tracers: ``points`` (dim, N), and the flow rate (N,) that each
    represents."""

    points: Array
    flow_rates: Array


def inlet_points(solution: StokesSolution, *names: str, count: int = 100) -> ReleasePoints:
    """About ``count`` release points on the openings of some ``names``, by default on all inlets.

    They are Gauss points, so that ∫ u·n g dS over the openings is the sum of flow rate times g.
    Raises ``ConditionError`` where nothing flows in, ``SelectionError`` for an unknown name.
    """
    whole("count", count)
    conditions = solution.problem.conditions
    chosen = names or [n for n, c in conditions.items() if isinstance(c, OPEN)]
    entering = [n for n in chosen if solution.flow_rate(n) > 0]
    if not entering:
        openings = ", ".join(f"'{n}'" for n in chosen)
        raise ConditionError(f"no fluid enters through {openings}; name an inlet")
    patches = [i for n in entering for i in patches_named(solution.space.boundary, n)]
    parts = [_on_patch(solution, i, count / len(patches)) for i in patches]
    return ReleasePoints(
        np.concatenate([p.points for p in parts], axis=1),
        np.concatenate([p.flow_rates for p in parts]),
    )


def _on_patch(solution: StokesSolution, patch: int, count: float) -> ReleasePoints:
    surface = solution.space.boundary.patches[patch].surface
    order = max(1, ceil(count ** (1 / len(surface.degrees)) - 1e-9))
    rules = [gauss_on_breaks(order, np.array(domain)) for domain in surface.domain]
    parameters, weights = tensor_rule(rules)
    points = surface_points(surface, *parameters)
    velocity = solution.velocity.on_patch(patch, *parameters)
    entering = (velocity * points.normal).sum(axis=0) * points.jacobian * weights
    kept = entering > 0
    return ReleasePoints(points.position[:, kept], entering[kept])
