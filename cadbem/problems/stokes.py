"""Stokes flow through channels and around bodies: the problem, and its solution."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from cadbem.boundary import Boundary
from cadbem.checks import finite, whole
from cadbem.errors import ConditionError
from cadbem.operators.compressed.layers import CompressedLayers
from cadbem.problems.adapting import MOST_POINTS, adapted, rules_for
from cadbem.problems.conditions import Background, Condition, NoSlip
from cadbem.problems.equations import StokesEquations
from cadbem.problems.estimates import Analysis, by_difference, warn_if_doubtful
from cadbem.problems.functionals import WALL_SHEAR, Goal
from cadbem.problems.slenderness import warn_if_slender
from cadbem.problems.solution import StokesSolution
from cadbem.problems.stokes_accuracy import analyse
from cadbem.problems.straightness import warn_if_not_straight
from cadbem.problems.summary import problem_overview
from cadbem.quadrature import Rules
from cadbem.space import Field
from cadbem.spline.basis import Array

SHARED = ("space", "surfaces", "regions", "openings", "layers", "inner_pressure", "constraints")
CHECKED = "openings_checked"  # what a problem keeps once it has warned of its openings


@dataclass(frozen=True, eq=False)
class StokesProblem(StokesEquations):
    """Slow viscous flow in a ``boundary`` of degree-elevated, refined patches.

    ``viscosity`` in pressure × time, in whatever consistent units; ``conditions`` one a name of
    the boundary.  If no closed surface holds the fluid it is unbounded: a ``background`` flow may
    then be given, which the flow tends to far away.  Where all velocities around the fluid are
    given, so that its pressure is open, f·n has the mean 0 on its container.  ``storage`` of the
    matrix, ``Dense()`` or ``Compressed(tolerance)``; by default what suits the number of points.
    ``open``: surfaces that are nearly closed are meant to be thin plates with fluid on both sides.

    Raises ``ConditionError`` for a boundary that is nearly closed unless it may be ``open``,
    for a face without a condition, a condition without a face, data that drive no flow, given
    velocities whose inflow and outflow differ, a background within walls, unbounded fluid in a
    plane (which has no solution for a body under a force: Stokes' paradox), a viscosity that is
    not positive; ``UnitsError`` for a quantity that is no viscosity, or that was made for
    another unit of length than the boundary's.
    """

    def __repr__(self) -> str:
        return problem_overview(self).text()

    def _repr_html_(self) -> str:
        return problem_overview(self).html()

    def solve(
        self,
        accuracy: float | None = None,
        *,
        goal: Goal | Callable[[StokesSolution], float] | None = None,
        most_points: int = MOST_POINTS,
    ) -> StokesSolution:
        """Velocity and traction on the boundary, from which all other fields follow.

        With an ``accuracy``, such as 1e-3, elements are chosen and refined by the program: it
        starts from the patches as they are and goes on until the estimated errors are below
        ``accuracy`` times the quantity's size.  Quantities are the flow rates and mean pressures
        of openings, the forces on bodies, and the velocity in the mean square; or those of a
        ``goal``: "openings" for flow rates and mean pressures alone, "wall shear" for the largest
        one, points (dim, M) for the velocity there, or a function of the solution that gives a
        number, which is judged by its change from round to round.  Beyond ``most_points`` it ends
        with an ``AccuracyWarning``.  Without an ``accuracy`` the patches are the elements.

        Solves c u + (1/μ) S f - D u = 2c u∞ at the collocation points, n into the fluid, with
        c = 4π, or 2π in a plane.
        """
        whole("most_points", most_points)
        self._check_openings()
        if accuracy is not None:
            return self._adapted(accuracy, goal, most_points)
        begin = time.process_time()
        solution = self.flow()
        solution = replace(solution, seconds=time.process_time() - begin)
        if isinstance(self.layers, CompressedLayers):
            warn_if_slender(self.boundary)
        else:
            warn_if_doubtful(solution.accuracy)
        return solution

    def _check_openings(self) -> None:
        """Warn of openings that are not straight, once for all data."""
        if CHECKED in vars(self):
            return
        vars(self)[CHECKED] = True
        bodies = {i for s in self.surfaces if s.is_body for i in s.patches}
        walls = [i for i, k in enumerate(self.kinds) if isinstance(k, NoSlip) and i not in bodies]
        warn_if_not_straight(self.boundary, list(self.openings.values()), walls)

    def on(self, boundary: Boundary, quadrature: Rules | None = None) -> StokesProblem:
        """The same problem on other elements of the same faces, maybe with another quadrature."""
        finer = replace(self, boundary=boundary, quadrature=quadrature or self.quadrature)
        # the same rims, whatever the elements
        vars(finer).update({"openings": self.openings, CHECKED: True})
        return finer

    def flow(self) -> StokesSolution:
        """What ``solve`` gives on the patches as they are, without looking at how good it is."""
        known = self.known()
        background = self.background.velocity_at(self.space.collocation.position)
        within = -self.background.pressure_at(self.inner_points)
        others = len(self.constraints.fields) - len(within)
        solution = self._solution(known, background, np.concatenate([within, np.zeros(others)]))
        return replace(solution, background=self.background)

    def _adapted(
        self,
        accuracy: float,
        goal: Goal | Callable[[StokesSolution], float] | None,
        most_points: int,
    ) -> StokesSolution:
        """The solution on refined elements."""
        values: list[float] = []

        def solve(boundary: Boundary) -> tuple[StokesSolution, Analysis]:
            finer = self.on(boundary, rules_for(self.quadrature, accuracy))
            solution = finer.flow()
            fields = solution.velocity, solution.traction
            if not callable(goal):
                return solution, analyse(finer, *fields, self.background, goal)
            analysis = analyse(finer, *fields, self.background)
            values.append(float(finite("what goal returns", goal(solution))))
            return solution, by_difference(analysis, values)

        begin = time.process_time()
        pointwise = isinstance(goal, str) and goal == WALL_SHEAR
        solution, analysis = adapted(self.boundary, solve, accuracy, most_points, pointwise)
        solution = replace(solution, seconds=time.process_time() - begin)
        vars(solution)["accuracy"] = analysis.accuracy
        return solution

    def with_data(self, conditions: Mapping[str, Condition]) -> StokesProblem:
        """The same problem with other data in some ``conditions`` of the same kinds.

        The matrix depends on kinds alone: it is assembled and factorised once for all of them.
        Raises ``ConditionError`` where a condition is of another kind.
        """
        for name, condition in conditions.items():
            old = self.conditions.get(name)
            if type(condition) is not type(old):
                raise ConditionError(
                    f"'{name}' has {old!r} and cannot take {condition!r} with the same matrix; "
                    "make a new StokesProblem"
                )
        self._check_openings()
        other = replace(self, conditions={**self.conditions, **conditions})
        vars(other).update({part: getattr(self, part) for part in SHARED}, **{CHECKED: True})
        vars(other)["system"] = self.system.with_data(other.splits)
        return other

    def reflection(self, induced: Array) -> StokesSolution:
        """The flow that the boundary reflects of a flow that bodies induce, with all given data
        zero.

        ``induced`` (dim, T) is the induced velocity at the collocation points, as in unbounded
        fluid.  The whole flow is the sum of ``solve()``, of this, and of the induced flow;
        its velocity on the boundary, which conserves mass, is that of both solutions.
        """
        zero = np.zeros((self.boundary.dimension, self.space.count))
        return self._solution((zero, zero), induced, 0.0)

    def _solution(
        self, known: tuple[Array, Array], background: Array, values: Array | float
    ) -> StokesSolution:
        """The flow with known data, a background velocity (dim, T) at collocation points, and
        given ``values`` (k,) of the constraints."""
        velocity, traction, iterations = self.fields(known, background, values)
        fields = Field(self.space, velocity), Field(self.space, traction)
        return StokesSolution(self, *fields, Background(), iterations)
