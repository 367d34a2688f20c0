"""The solution of a Stokes flow, and the fields, forces and flow rates that follow from it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from cadbem.checks import vector, whole
from cadbem.kernels.kernel import Kernel
from cadbem.kernels.stokes import stokes_kernels
from cadbem.operators.potentials import Potentials
from cadbem.points import moment
from cadbem.problems.conditions import Background
from cadbem.problems.equations import StokesEquations
from cadbem.problems.estimates import Accuracy
from cadbem.problems.mixed import patches_named, represent
from cadbem.problems.stokes_accuracy import analyse
from cadbem.problems.summary import flow_summary
from cadbem.quadrature import Rules
from cadbem.space import Field, Space
from cadbem.spline.basis import Array


@dataclass(frozen=True, eq=False)
class StokesSolution:
    """``velocity`` and ``traction`` f = σ·n (n into the fluid) on the boundary as fields, added to
    a ``background`` flow; the ``iterations`` of the solver, 0 for a direct one, and CPU
    ``seconds``."""

    problem: StokesEquations
    velocity: Field
    traction: Field
    background: Background
    iterations: int = 0
    seconds: float = 0.0

    def __repr__(self) -> str:
        return flow_summary(self).text()

    def _repr_html_(self) -> str:
        return flow_summary(self).html()

    def __add__(self, other: StokesSolution) -> StokesSolution:
        """This flow and another one's boundary fields, on this one's background."""
        velocity = Field(self.space, self.velocity.coefficients + other.velocity.coefficients)
        traction = Field(self.space, self.traction.coefficients + other.traction.coefficients)
        iterations = self.iterations + other.iterations
        return replace(self, velocity=velocity, traction=traction, iterations=iterations)

    @property
    def space(self) -> Space:
        """Unknowns and collocation points."""
        return self.velocity.space

    @cached_property
    def accuracy(self) -> Accuracy:
        """How wrong flow rates, mean pressures, forces and the velocity may be: see ``Accuracy``.

        For compressed matrices adjoints come from a few more flows, and estimates are rougher.
        """
        return analyse(self.problem, self.velocity, self.traction, self.background).accuracy

    def velocity_at(self, points: ArrayLike, quadrature: Rules | None = None) -> Array:
        """Velocity (dim, M) at points (dim, M) in the fluid or on its boundary.

        u = u∞ - (1/cμ) ∫ G f dS + (1/c) ∫ (T·n) u dS in the fluid, c = 8π (4π in a plane);
        zero outside.  The ``quadrature`` is the problem's if none is given.
        """
        kernel, _ = stokes_kernels(self.space.boundary.dimension)
        far_away, factor = self.background.velocity_at, self._velocity_factors
        return self._at(kernel, points, quadrature, factor, self.velocity.on_patch, far_away)

    @property
    def _velocity_factors(self) -> tuple[float, float]:
        inside = 2 * stokes_kernels(self.space.boundary.dimension)[0].free_term
        return -1 / (inside * self.problem.viscosity), 1 / inside

    def velocity_by(self, potentials: Potentials) -> Array:
        """Velocity (dim, M) at the targets, off the boundary, of ``potentials`` of the velocity's
        kernel, which other solutions of the same problem can share."""
        far_away = self.background.velocity_at(potentials.targets.position)
        return far_away + potentials.apply(*self._densities(self._velocity_factors))

    def _densities(self, factor: tuple[float, float]) -> tuple[Array, Array]:
        """Coefficients (dim, F) of the single and the double layer."""
        double = np.where(self.problem.thin, 0.0, self.velocity.coefficients)
        return factor[0] * self.traction.coefficients, factor[1] * double

    def pressure_at(self, points: ArrayLike, quadrature: Rules | None = None) -> Array:
        """Pressure (M,) at points (dim, M) in the fluid or on its boundary.

        p = p∞ + (1/c) ∫ g·f dS + (μ/c) ∫ h·u dS in the fluid (see ``stokes_3d``).
        """
        velocity, kernel = stokes_kernels(self.space.boundary.dimension)
        inside, on_patch = 2 * velocity.free_term, self._pressure_row
        factor = 1 / inside, self.problem.viscosity / inside
        far_away = self.background.pressure_at
        return self._at(kernel, points, quadrature, factor, on_patch, far_away)[0]

    def _at(
        self,
        kernel: Kernel,
        points: ArrayLike,
        quadrature: Rules | None,
        factor: tuple[float, float],
        on_patch: Callable[..., Array],
        far_away: Callable[[Array], Array],
    ) -> Array:
        single, double = self._densities(factor)
        quadrature = quadrature or self.problem.quadrature
        return represent(kernel, self.space, points, quadrature, single, double, on_patch, far_away)

    def _pressure_row(self, patch: int, *parameters: ArrayLike) -> Array:
        return self.surface_pressure(patch, *parameters)[None]

    def surface_pressure(self, patch: int, *parameters: ArrayLike) -> Array:
        """Pressure on one patch: p = -f·n - 2μ div_s u, as the flow has no divergence."""
        whole("patch", patch, 0, len(self.space.boundary.patches) - 1)
        normal, divergence = self.velocity.surface_divergence(patch, *parameters)
        normal_traction = (self.traction.on_patch(patch, *parameters) * normal).sum(axis=0)
        return -normal_traction - 2 * self.problem.viscosity * divergence

    def _flux(self, patch: int) -> float:
        values, points, weights = self.velocity.quadrature(patch)
        return float((values * points.normal).sum(axis=0) @ weights)

    def flow_rate(self, name: str) -> float:
        """Volume per time that enters the fluid through the faces of a name."""
        return sum(self._flux(i) for i in patches_named(self.space.boundary, name))

    def net_flux(self) -> float:
        """∮ u·n dS, which vanishes for the exact flow; relative to what enters, ∮ |u·n| dS / 2."""
        net = through = 0.0
        for patch in range(len(self.space.boundary.patches)):
            values, points, weights = self.velocity.quadrature(patch)
            normal = (values * points.normal).sum(axis=0)
            net += float(normal @ weights)
            through += float(abs(normal) @ weights)
        return 2 * net / through if through else 0.0

    def force(self, name: str) -> Array:
        """Force (dim,) of the fluid on the faces of a name, ∫ f dS."""
        patches = patches_named(self.space.boundary, name)
        return np.sum([self.traction.integral(i) for i in patches], axis=0)

    def torque(self, name: str, centre: ArrayLike) -> Array:
        """Torque of the fluid on the faces of a name about a point (dim,), ∫ (x - c) × f dS.

        Shape (3,), or (1,) in a plane, counter-clockwise.
        """
        parts = []
        middle = vector("centre", centre, self.space.boundary.dimension)[:, None]
        for i in patches_named(self.space.boundary, name):
            values, points, weights = self.traction.quadrature(i)
            arms = points.position - middle
            parts.append(moment(arms, values) @ weights)
        return np.sum(parts, axis=0)

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
