"""The solution of a heat conduction problem, and the fields and totals that follow from it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from cadbem.kernels.kernel import Kernel
from cadbem.points import surface_points
from cadbem.problems.estimates import Accuracy
from cadbem.problems.heat_accuracy import analyse_heat
from cadbem.problems.heat_equations import HeatEquations
from cadbem.problems.heat_source import gradient_kernel, total_source
from cadbem.problems.mixed import MixedSystem, patches_named, represent
from cadbem.problems.summary import heat_summary
from cadbem.quadrature.options import Quadrature
from cadbem.space import Field, Space
from cadbem.spline.basis import Array

FINER = 1e3  # how much finer gradients are integrated


@dataclass(frozen=True, eq=False)
class HeatSolution:
    """``temperature`` and ``flux``, heat into the body per area, as scalar fields (1, ·)."""

    problem: HeatEquations
    system: MixedSystem
    temperature: Field
    flux: Field

    def __repr__(self) -> str:
        return heat_summary(self).text()

    def _repr_html_(self) -> str:
        return heat_summary(self).html()

    @property
    def space(self) -> Space:
        """Unknowns and collocation points."""
        return self.temperature.space

    @cached_property
    def accuracy(self) -> Accuracy:
        """How wrong heat rates and the temperature may be: see ``Accuracy``.

        Raises ``ConditionError`` without a dense matrix.
        """
        return analyse_heat(self.problem, self.system, self.temperature, self.flux).accuracy

    def temperature_at(self, points: ArrayLike) -> Array:
        """Temperature (M,) at points (dim, M) in the body or on its boundary.

        φ = (1/c) [(1/k) S q + D φ + (1/k) ∫ b G dV] inside, c = 4π (3D) or 2π (2D).
        """
        sources = self.problem.source_kernels
        source = None if sources is None else sources.value
        kernel, quadrature = self.problem.kernel, self.problem.quadrature
        return self._at(kernel, source, points, quadrature, self.temperature.on_patch)[0]

    def heat_flux_at(self, points: ArrayLike) -> Array:
        """Flux of heat -k ∇φ (dim, M) at points (dim, M) in the body or on its boundary.

        Close to the boundary, at a distance d, the tolerance of ``quadrature`` counts 1/d fold.
        """
        sources = self.problem.source_kernels
        source = None if sources is None else sources.gradient
        kernel, k = gradient_kernel(self.space.boundary.dimension), self.problem.conductivity
        # these kernels are more singular than those that the tolerance is meant for
        finer = Quadrature(max(self.problem.quadrature.tolerance / FINER, 1e-14))
        return -k * self._at(kernel, source, points, finer, self._surface_gradient)

    def _at(
        self,
        kernel: Kernel,
        source: Kernel | None,
        points: ArrayLike,
        quadrature: Quadrature,
        on_patch: Callable,
    ) -> Array:
        problem, space = self.problem, self.space
        solid_angle = 2 * problem.kernel.free_term
        heat = 1 / (solid_angle * problem.conductivity)
        single = heat * self.flux.coefficients
        double = self.temperature.coefficients / solid_angle
        result = represent(kernel, space, points, quadrature, single, double, on_patch)
        if source is not None:
            ones = np.full_like(double, heat)
            result += represent(source, space, points, quadrature, 0 * ones, ones, _nothing)
        return result

    def _surface_gradient(self, patch: int, *parameters: ArrayLike) -> Array:
        """Gradient of the temperature on one patch: along it, and -q/k along the normal."""
        surface = self.space.boundary.patches[patch].surface
        control = np.moveaxis(self.temperature.patch_coefficients(patch), 0, -1)
        points = surface_points(surface, *parameters)
        slopes = replace(surface, points=control).derivatives(1, *parameters)
        first = sorted((key for key in slopes if sum(key) == 1), reverse=True)
        along = np.stack([slopes[key].ravel() for key in first])
        metric = np.einsum("acn,bcn->nab", points.tangents, points.tangents)
        dual = np.linalg.solve(metric, along.T[..., None])[..., 0]
        normal = -self.flux.on_patch(patch, *parameters) / self.problem.conductivity
        return np.einsum("acn,na->cn", points.tangents, dual) + normal * points.normal

    def heat_rate(self, name: str) -> float:
        """Heat per time that enters the body through the faces of a name."""
        patches = patches_named(self.space.boundary, name)
        return sum(float(self.flux.integral(i)[0]) for i in patches)

    def net_heat(self) -> float:
        """Heat that enters, with what sources give; it vanishes for the exact solution."""
        entering = sum(self.heat_rate(name) for name in self.space.boundary.names)
        if self.problem.source is None:
            return entering
        return entering + total_source(self.problem.source, self.space.boundary)


def _nothing(patch: int, *parameters: ArrayLike) -> Array:
    return np.zeros(1)
