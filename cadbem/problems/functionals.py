"""Numbers that are asked of a solution, as linear functionals of its boundary fields."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from cadbem.boundary import Boundary
from cadbem.errors import ConditionError
from cadbem.problems.enclosure import inside
from cadbem.spline.basis import Array

Goal = str | ArrayLike
MEAN_PRESSURE, FLOW_RATE = "mean pressure", "flow rate"
FORCES = ("x force", "y force", "z force")
OPENINGS, WALL_SHEAR, HEAT_RATES = "openings", "wall shear", "heat rates"  # goals


@dataclass(frozen=True, eq=False)
class Functional:
    """J = value_weights · u + flux_weights · f for coefficients (components, F) of a solution's
    value u and flux f.

    ``kind`` and ``place`` say what it is ("flow rate" of "outlet"), ``value`` is J of the solution,
    ``scale`` the size that errors are compared with; estimates of its errors are
    multiplied by ``safety``.
    """

    kind: str
    place: str
    value: float
    scale: float
    value_weights: Array
    flux_weights: Array
    safety: float = 1.0

    @property
    def name(self) -> str:
        """What it is, in words."""
        return f"{self.kind} '{self.place}'" if self.place else self.kind


def points_of(goal: Goal, boundary: Boundary, *names: str) -> Array:
    """Points (dim, M) of a ``goal`` that is none of the ``names``.

    Raises ``ConditionError`` unless they are finite coordinates of points that a boundary holds.
    """
    dimension = boundary.dimension
    if isinstance(goal, str):
        known = ", ".join(f"'{name}'" for name in names)
        raise ConditionError(
            f"goal={goal!r} is not known; give {known}, or points ({dimension}, M)"
        )
    points = np.asarray(goal, dtype=float)
    if points.ndim != 2 or len(points) != dimension or not np.isfinite(points).all():
        raise ConditionError(
            f"goal has the shape {points.shape}; give finite coordinates ({dimension}, M), a "
            "column a point"
        )
    outside = ~inside(boundary, points)
    if outside.any():
        place = ", ".join(f"{x:.4g}" for x in points[:, int(outside.argmax())])
        raise ConditionError(f"the goal's point ({place}) is outside the boundary; move it inside")
    return points
