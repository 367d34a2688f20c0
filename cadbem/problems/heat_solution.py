"""What can be asked of a solved heat conduction problem."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from cadbem.problems.heat_source import total_source
from cadbem.problems.mixed import patches_named, represent
from cadbem.space import Field, Space
from cadbem.spline.basis import Array

if TYPE_CHECKING:
    from cadbem.problems.heat import HeatProblem


@dataclass(frozen=True, eq=False)
class HeatSolution:
    """``temperature`` and ``flux``, heat into the body per area, as scalar fields (1, ·)."""

    problem: HeatProblem
    temperature: Field
    flux: Field

    @property
    def space(self) -> Space:
        """Unknowns and collocation points."""
        return self.temperature.space

    def temperature_at(self, points: ArrayLike) -> Array:
        """Temperature (M,) at points (dim, M) in the body or on its boundary.

        φ = (1/c) [(1/k) S q + D φ + (1/k) ∫ b G dV] inside, c = 4π (3D) or 2π (2D).
        """
        problem, space, quadrature = self.problem, self.space, self.problem.quadrature
        solid_angle = 2 * problem.kernel.free_term
        heat = 1 / (solid_angle * problem.conductivity)
        single = heat * self.flux.coefficients
        double = self.temperature.coefficients / solid_angle
        result = represent(
            problem.kernel, space, points, quadrature, single, double, self.temperature.on_patch
        )
        if problem.source_kernel is not None:
            ones = np.full((1, space.count), heat)
            result += represent(
                problem.source_kernel, space, points, quadrature, 0 * ones, ones, _nothing
            )
        return result[0]

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
    return np.zeros_like(np.asarray(parameters[0], dtype=float))[None]
