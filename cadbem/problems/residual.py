"""By how much a solution misses the boundary equation between its collocation points."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from cadbem.kernels.kernel import Index
from cadbem.operators.interactions import Targets
from cadbem.operators.layers import applied
from cadbem.points import SurfacePoints, join, surface_points
from cadbem.problems.mixed import MixedSystem
from cadbem.quadrature import Rules
from cadbem.quadrature.gauss import gauss_on_breaks, tensor_rule
from cadbem.space import Field, Space
from cadbem.spline.basis import Array

MORE = 2  # Gauss points a direction and element, beyond the degree


@dataclass(frozen=True, eq=False)
class CheckPoints:
    """Points where equations are checked: ``patch`` (N,), ``parameters`` (p, N) and ``weights``
    (N,) of an integral over the boundary.

    They lie between the collocation points: one more Gauss point a direction than functions.
    """

    space: Space
    points: SurfacePoints
    patch: Index
    parameters: Array
    weights: Array

    @classmethod
    def of(cls, space: Space) -> CheckPoints:
        """On all patches of a space."""
        owners, parameters, points, weights = [], [], [], []
        for number, patch in enumerate(space.boundary.patches):
            surface = patch.surface
            rules = [
                gauss_on_breaks(degree + MORE, surface.breaks(d))
                for d, degree in enumerate(surface.degrees)
            ]
            place, weight = tensor_rule(rules)
            parameters.append(np.array(place))
            points.append(surface_points(surface, *place))
            weights.append(weight * points[-1].jacobian)
            owners.append(np.full(len(weight), number))
        return cls(
            space, join(points), np.concatenate(owners),
            np.concatenate(parameters, axis=1), np.concatenate(weights),
        )  # fmt: skip

    @property
    def targets(self) -> Targets:
        """The same as targets of layers."""
        return Targets(np.ascontiguousarray(self.points.position), self.patch, self.parameters)

    def values(self, coefficients: Array) -> Array:
        """Values (components, N) of a field's coefficients (components, F)."""
        field = Field(self.space, coefficients)
        parts = [
            field.on_patch(i, *self.parameters[:, self.patch == i])
            for i in range(len(self.space.boundary.patches))
        ]
        return np.concatenate(parts, axis=1)

    def by_patch(self, values: Array) -> Array:
        """Integrals (P,) over each patch of values (N,)."""
        count = len(self.space.boundary.patches)
        return np.bincount(self.patch, values * self.weights, minlength=count).astype(float)


def residual(
    system: MixedSystem,
    checks: CheckPoints,
    value: Array,
    flux: Array,
    source: Callable[[CheckPoints], Array] | None,
    quadrature: Rules,
) -> Array:
    """flux_factor S f + D u + source - c u at check points: (rows, N); 0 for the exact solution.

    ``value`` and ``flux`` (components, F) are coefficients of u and f.
    """
    kernel, space = system.layers.kernel, system.space
    single = system.flux_factor * flux
    result = applied(kernel, space, checks.targets, quadrature, single, value)
    result -= system.free_term * checks.values(value)
    return result if source is None else result + source(checks)
