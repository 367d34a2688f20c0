"""What can be asked of a solved Stokes flow."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from cadbem.kernels.kernel import Kernel
from cadbem.kernels.stokes_3d import STOKES_3D, STOKES_PRESSURE_3D
from cadbem.problems.mixed import patches_named, represent
from cadbem.quadrature import Quadrature
from cadbem.space import Field, Space
from cadbem.spline.basis import Array

if TYPE_CHECKING:
    from cadbem.problems.stokes import StokesProblem

EIGHT_PI = 8 * np.pi


@dataclass(frozen=True, eq=False)
class StokesSolution:
    """``velocity`` and ``traction`` f = σ·n (n into the fluid) on the boundary as fields."""

    problem: StokesProblem
    velocity: Field
    traction: Field

    @property
    def space(self) -> Space:
        """Unknowns and collocation points."""
        return self.velocity.space

    def velocity_at(self, points: ArrayLike, quadrature: Quadrature | None = None) -> Array:
        """Velocity (3, M) at points (3, M) in the fluid or on its boundary.

        u = u∞ - (1/8πμ) ∫ G f dS + (1/8π) ∫ (T·n) u dS in the fluid; zero outside.  The
        ``quadrature`` is the problem's if none is given.
        """
        factor = -1 / (EIGHT_PI * self.problem.viscosity), 1 / EIGHT_PI
        far_away = self.problem.background.velocity_at
        return self._at(STOKES_3D, points, quadrature, factor, self.velocity.on_patch, far_away)

    def pressure_at(self, points: ArrayLike, quadrature: Quadrature | None = None) -> Array:
        """Pressure (M,) at points (3, M) in the fluid or on its boundary.

        p = p∞ + (1/8π) ∫ g·f dS + (μ/8π) ∫ h·u dS in the fluid (see ``stokes_3d``).
        """
        factor = 1 / EIGHT_PI, self.problem.viscosity / EIGHT_PI
        kernel, on_patch = STOKES_PRESSURE_3D, self._pressure_row
        far_away = self.problem.background.pressure_at
        return self._at(kernel, points, quadrature, factor, on_patch, far_away)[0]

    def _at(
        self,
        kernel: Kernel,
        points: ArrayLike,
        quadrature: Quadrature | None,
        factor: tuple[float, float],
        on_patch: Callable[..., Array],
        far_away: Callable[[Array], Array],
    ) -> Array:
        single = factor[0] * self.traction.coefficients
        double = factor[1] * self.velocity.coefficients
        quadrature = quadrature or self.problem.quadrature
        return represent(
            kernel, self.space, points, quadrature, single, double, on_patch, far_away
        )

    def _pressure_row(self, patch: int, u: ArrayLike, v: ArrayLike) -> Array:
        return self.surface_pressure(patch, u, v)[None]

    def surface_pressure(self, patch: int, u: ArrayLike, v: ArrayLike) -> Array:
        """Pressure on one patch: p = -f·n - 2μ div_s u, as the flow has no divergence."""
        normal, divergence = self.velocity.surface_divergence(patch, u, v)
        normal_traction = (self.traction.on_patch(patch, u, v) * normal).sum(axis=0)
        return -normal_traction - 2 * self.problem.viscosity * divergence

    def wall_shear(self, patch: int, u: ArrayLike, v: ArrayLike) -> Array:
        """Tangential part (3, ·) of the traction on one patch."""
        normal, _ = self.velocity.surface_divergence(patch, u, v)
        traction = self.traction.on_patch(patch, u, v)
        return traction - (traction * normal).sum(axis=0) * normal

    def _flux(self, patch: int) -> float:
        values, points, weights = self.velocity.quadrature(patch)
        return float((values * points.normal).sum(axis=0) @ weights)

    def flow_rate(self, name: str) -> float:
        """Volume per time that enters the fluid through the faces of a name."""
        return sum(self._flux(i) for i in patches_named(self.space.boundary, name))

    def net_flux(self) -> float:
        """∮ u·n dS, which vanishes for the exact flow; relative to what enters."""
        fluxes = [self.flow_rate(name) for name in self.space.boundary.names]
        return sum(fluxes) / sum(f for f in fluxes if f > 0)

    def force(self, name: str) -> Array:
        """Force (3,) of the fluid on the faces of a name, ∫ f dS."""
        patches = patches_named(self.space.boundary, name)
        return np.sum([self.traction.integral(i) for i in patches], axis=0)

    def torque(self, name: str, centre: ArrayLike) -> Array:
        """Torque (3,) of the fluid on the faces of a name about a point (3,), ∫ (x - c) × f dS."""
        total = np.zeros(3)
        for i in patches_named(self.space.boundary, name):
            values, points, weights = self.traction.quadrature(i)
            arms = points.position - np.reshape(centre, (3, 1))
            total += np.cross(arms, values, axis=0) @ weights
        return total

    def net_force(self) -> float:
        """|∮ f dS|, which vanishes for the exact flow; relative to ∮ |f| dS."""
        indices = range(len(self.space.boundary.patches))
        parts = [self.traction.quadrature(i) for i in indices]
        total = np.sum([values @ weights for values, _, weights in parts], axis=0)
        size = sum(np.linalg.norm(values, axis=0) @ weights for values, _, weights in parts)
        return float(np.linalg.norm(total) / size)

    def mean_pressure(self, name: str) -> float:
        """Mean of the pressure over the faces of a name."""
        integral = area = 0.0
        for i in patches_named(self.space.boundary, name):
            parameters, _, weights = self.velocity.nodes(i)
            integral += float(self.surface_pressure(i, *parameters) @ weights)
            area += float(weights.sum())
        return integral / area
