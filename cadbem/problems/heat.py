"""Steady heat conduction: the problem, its linear system, Newton's method for radiation."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from scipy.sparse import block_diag

from cadbem.boundary import Boundary
from cadbem.checks import whole
from cadbem.errors import ConditionError
from cadbem.operators.layers import collocation_targets
from cadbem.operators.potentials import Potentials
from cadbem.problems.adapting import MOST_POINTS, adapted, rules_for
from cadbem.problems.estimates import Analysis, by_difference
from cadbem.problems.functionals import Goal
from cadbem.problems.heat_accuracy import analyse_heat
from cadbem.problems.heat_conditions import (
    SurfaceExchange,
    split_heat,
)
from cadbem.problems.heat_equations import HeatEquations
from cadbem.problems.heat_solution import HeatSolution
from cadbem.problems.mixed import MixedSystem
from cadbem.problems.summary import problem_overview
from cadbem.quadrature.options import Quadrature
from cadbem.space import Field
from cadbem.spline.basis import Array

UPDATE = 1e-13  # Newton stops when the update is so small against what it is a difference of
MOST_STEPS = 100
BELOW_ZERO = 1e-3  # share of the largest value that may be lost to discretisation


@dataclass(frozen=True, eq=False)
class HeatProblem(HeatEquations):
    """k ∇²φ + b = 0 in a ``boundary`` of curves or surfaces whose normals point into the body.

    ``conductivity`` k > 0; ``conditions`` one a name of the boundary; ``source`` b, heat per
    volume and time, a number or a function of positions (dim, N) -> (N,), which is also evaluated
    outside a body that is not convex.  ``storage`` as in ``StokesProblem``.  Raises
    ``ConditionError`` for a face without a condition, a condition without a face, a temperature
    that is left open, and, when solved, for a source that varies too fast, or radiation that finds
    no balance above absolute zero.
    """

    def __repr__(self) -> str:
        return problem_overview(self).text()

    def _repr_html_(self) -> str:
        return problem_overview(self).html()

    def solve(
        self,
        accuracy: float | None = None,
        *,
        goal: Goal | Callable[[HeatSolution], float] | None = None,
        most_points: int = MOST_POINTS,
    ) -> HeatSolution:
        """Temperature and heat flux on the boundary, from which all other fields follow.

        With an ``accuracy``, such as 1e-3, elements are chosen and refined until the estimated
        errors of heat rates and of the temperature in the mean square are below that share of
        their size; or those of a ``goal``: "heat rates" for them alone, points (dim, M) for the
        temperature there, or a function of the solution that gives a number.  See
        ``StokesProblem.solve``.  Without an ``accuracy`` the patches are the elements.

        Solves c φ = (1/k) S q + D φ + (1/k) ∫ b G dV at the collocation points, c its
        ``free_term``, q = -k ∂φ/∂n with n into the body.
        """
        whole("most_points", most_points)
        if accuracy is None:
            return self._solved()
        values: list[float] = []

        def solve(boundary: Boundary) -> tuple[HeatSolution, Analysis]:
            rules = rules_for(self.quadrature, accuracy)
            assert isinstance(rules, Quadrature)
            finer = replace(self, boundary=boundary, quadrature=rules)
            solution = finer._solved()
            fields = solution.temperature, solution.flux
            if not callable(goal):
                return solution, analyse_heat(finer, solution.system, *fields, goal)
            values.append(float(goal(solution)))
            return solution, by_difference(analyse_heat(finer, solution.system, *fields), values)

        solution, analysis = adapted(self.boundary, solve, accuracy, most_points)
        vars(solution)["accuracy"] = analysis.accuracy
        return solution

    def _solved(self) -> HeatSolution:
        """The solution on the patches as they are."""
        slope = self.conductivity / self.size
        splits = [split_heat(self.conditions[p.name], slope) for p in self.boundary.patches]
        system = MixedSystem(self.layers, 1 / self.conductivity, splits)
        temperature, flux = system.known()
        unknowns = system.unknowns(temperature, flux, self._source_term()).unknowns
        radiating = self._radiating()
        if radiating:
            part = np.concatenate([np.arange(*self._range(i)) for i in radiating])
            response = system.flux_responses(radiating)[0]
            flux[0, part] = self._balance(radiating, unknowns[0, part], response[part], slope)
            unknowns = unknowns + response @ flux[0, part]
        temperature, flux = system.complete(temperature, flux, unknowns)
        return HeatSolution(
            self, system, Field(self.space, temperature), Field(self.space, flux)
        )

    def _source_term(self) -> Array | float:
        if self.source_kernels is None:
            return 0.0
        kernel, targets = self.source_kernels.value, collocation_targets(self.space)
        ones = np.full((1, self.space.count), 1 / self.conductivity)
        return Potentials(kernel, self.space, targets, self.quadrature).apply(0 * ones, ones)

    def _radiating(self) -> list[int]:
        """Patches whose condition is not linear."""
        conditions = [self.conditions[p.name] for p in self.boundary.patches]
        return [
            i for i, c in enumerate(conditions) if isinstance(c, SurfaceExchange) and c.radiation
        ]

    def _range(self, patch: int) -> tuple[int, int]:
        return self.space.offsets[patch], self.space.offsets[patch + 1]

    def _balance(self, patches: list[int], base: Array, response: Array, slope: float) -> Array:
        """Newton's method on the condensed system: coefficients g with q = -slope φ + g.

        The temperature's coefficients on the radiating patches alone are c = base + response g,
        linear in g; with N the functions at the collocation points, N g = slope N c - f(N c).
        Raises ``ConditionError`` when it does not converge to absolute temperatures.
        """
        basis = block_diag([self.space.collocation_matrix(i) for i in patches]).toarray()
        start = max(abs(basis @ base).max(), self._hottest_ambient(patches))
        control = np.full(len(base), start)
        for _ in range(MOST_STEPS):
            loss, derivative = self._losses(patches, basis @ control)
            answer = slope * control - np.linalg.solve(basis, loss)
            gap = control - base - response @ answer
            inner = np.linalg.solve(basis, derivative[:, None] * basis)
            jacobian = np.eye(len(base)) - response @ (slope * np.eye(len(base)) - inner)
            update = np.linalg.solve(jacobian, gap)
            change, size = abs(basis @ update).max(), abs(basis @ control).max()
            # rises are limited: far above the answer, φ⁴ lets Newton fall by 1/4 a step only
            control = control - update * min(1.0, 3 * size / change if change > 0 else 1.0)
            scale = np.linalg.norm(basis @ control) + np.linalg.norm(basis @ base)
            if np.linalg.norm(basis @ update) <= UPDATE * scale:
                values = self._absolute(basis @ control)
                return slope * control - np.linalg.solve(basis, self._losses(patches, values)[0])
        raise ConditionError(
            f"the radiation is not balanced after {MOST_STEPS} Newton steps; "
            "check that temperatures are absolute and the units of SurfaceExchange"
        )

    def _absolute(self, values: Array) -> Array:
        if values.min() < -BELOW_ZERO * abs(values).max():
            raise ConditionError(
                f"radiating faces reach {values.min():.4g}, below absolute zero: more heat is "
                "taken out than they receive; check the sign of HeatFlux (positive: into the body)"
            )
        return values

    def _exchange(self, patch: int) -> SurfaceExchange:
        condition = self.conditions[self.boundary.patches[patch].name]
        assert isinstance(condition, SurfaceExchange)
        return condition

    def _hottest_ambient(self, patches: list[int]) -> float:
        return max(self._exchange(i).ambient for i in patches)

    def _losses(self, patches: list[int], values: Array) -> tuple[Array, Array]:
        """Loss and its derivative at the collocation points of patches, one after the other."""
        ends = np.cumsum([np.diff(self._range(i))[0] for i in patches])
        pairs = [
            (self._exchange(i).loss(v), self._exchange(i).loss_slope(v))
            for i, v in zip(patches, np.split(values, ends[:-1]), strict=True)
        ]
        return np.concatenate([p[0] for p in pairs]), np.concatenate([p[1] for p in pairs])
