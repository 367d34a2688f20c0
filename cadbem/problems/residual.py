"""By how much a solution misses the boundary equation between its collocation points."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from math import ceil

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from cadbem.kernels.kernel import Index
from cadbem.operators.interactions import Targets
from cadbem.operators.layers import applied
from cadbem.points import SurfacePoints, join, surface_points
from cadbem.problems.mixed import MixedSystem
from cadbem.quadrature import Rules
from cadbem.quadrature.gauss import gauss_on_breaks, tensor_rule
from cadbem.space import Space, rational_basis
from cadbem.spline.basis import Array


@dataclass(frozen=True, eq=False)
class CheckPoints:
    """Points where equations are checked: ``patch`` (N,), ``parameters`` (p, N) and ``weights``
    (N,) of an integral over the boundary.

    They are Gauss points of each element, some more than there are functions, so that they lie
    between the collocation points.
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
            axes = range(len(surface.degrees))
            rules = [
                gauss_on_breaks(_order(degree, len(breaks) - 1), breaks)
                for degree, breaks in zip(surface.degrees, map(surface.breaks, axes), strict=True)
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

    def on(self, chosen: NDArray[np.bool_]) -> CheckPoints:
        """Those on chosen patches (P,)."""
        here = chosen[self.patch]
        return replace(
            self, points=self.points.chosen(here), patch=self.patch[here],
            parameters=self.parameters[:, here], weights=self.weights[here],
        )  # fmt: skip

    @property
    def targets(self) -> Targets:
        """The same as targets of layers."""
        return Targets(np.ascontiguousarray(self.points.position), self.patch, self.parameters)

    def values(self, coefficients: Array) -> Array:
        """Values (components, N) of a field's coefficients (components, F)."""
        parts = [
            basis @ coefficients[:, self.space.functions(i)].T for i, basis in self._bases.items()
        ]
        return np.concatenate(parts).T

    @cached_property
    def _bases(self) -> dict[int, csr_array]:
        """Values of each patch's functions at its points: sparse (n, functions)."""
        patches = self.space.boundary.patches
        return {
            int(i): rational_basis(patches[i].surface, self.parameters[:, self.patch == i])
            for i in np.unique(self.patch)
        }

    def by_patch(self, values: Array) -> Array:
        """Integrals (P,) over each patch of values (N,)."""
        count = len(self.space.boundary.patches)
        return np.bincount(self.patch, values * self.weights, minlength=count).astype(float)


def _order(degree: int, elements: int) -> int:
    """Gauss points an element, of which a direction has degree + elements functions."""
    return max(2, ceil((degree + 1) / elements) + 2)


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
