"""Bodies in a channel: its walls answer to what they do."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from cadbem.kernels.stokes import stokes_kernels
from cadbem.operators.interactions import Targets
from cadbem.operators.nearest import NearestSearch
from cadbem.operators.potentials import Potentials
from cadbem.problems.conditions import Inflow, Pressure, Traction
from cadbem.problems.solution import StokesSolution
from cadbem.problems.stokes import StokesProblem
from cadbem.spline.basis import Array
from cadbem.suspension.surroundings import Nearest


@dataclass(frozen=True, eq=False)
class ChannelFlow:
    """The fluid in a channel; the ``problem``'s matrix is assembled and factorised once.

    ``deflated`` False leaves the droplets' equations as they stand, for comparison.
    """

    problem: StokesProblem
    deflated: bool = True

    @property
    def viscosity(self) -> float:
        """Viscosity of the fluid outside the droplets."""
        return self.problem.viscosity

    @property
    def background(self) -> None:
        """None: the fluid is bounded."""
        return None

    @cached_property
    def empty(self) -> StokesSolution:
        """The flow without bodies."""
        return self.problem.solve()

    @property
    def walls(self) -> Array:
        """The collocation points (dim, W) of the channel."""
        return self.problem.space.collocation.position

    def at(self, points: Array) -> _AtPoints:
        """The flow at points (dim, M) off the walls."""
        kernel, _ = stokes_kernels(len(points))
        targets = Targets.free(np.ascontiguousarray(points))
        space, quadrature = self.problem.space, self.problem.quadrature
        return _AtPoints(self, Potentials(kernel, space, targets, quadrature))

    @cached_property
    def _search(self) -> NearestSearch:
        return NearestSearch(self.problem.boundary)

    def nearest(self, points: Array, reach: float) -> Nearest:
        """The boundary near points (dim, M), as far as a ``reach``.

        A thin plate has fluid on both sides: the side on which most of the points are counts as
        inside.
        """
        found = self._search.find(points, reach)
        outside = (found.patch >= 0) & ~found.before
        thin = self._thin[found.patch] & (found.patch >= 0)
        for patch in np.unique(found.patch[thin]):
            here = found.patch == patch
            outside[here] ^= 2 * np.count_nonzero(outside[here]) > np.count_nonzero(here)
        patches = self.problem.boundary.patches
        conditions = self.problem.conditions
        names = [patches[i].name if i >= 0 else "" for i in found.patch]
        opening = [isinstance(conditions.get(n), Inflow | Pressure | Traction) for n in names]
        distance = np.where(outside, -found.distance, found.distance)
        return Nearest(distance, names, np.array(opening))

    @cached_property
    def _thin(self) -> NDArray[np.bool_]:
        """Which patches are thin plates."""
        thin = self.problem.thin
        firsts = self.problem.space.offsets[:-1]
        return thin[list(firsts)]

    def solution(self, induced: Array) -> StokesSolution:
        """The flow with bodies that make ``induced`` (dim, W) at the walls, without the field
        of the bodies themselves."""
        return self.empty + self.problem.reflection(induced)


@dataclass(frozen=True, eq=False)
class _AtPoints:
    """See ``Incident``."""

    flow: ChannelFlow
    potentials: Potentials

    def velocity(self, induced: Array | None) -> Array:
        flow = self.flow
        solution = flow.empty if induced is None else flow.solution(induced)
        return solution.velocity_by(self.potentials)

    def reflected(self, induced: Array) -> Array:
        return self.flow.problem.reflection(induced).velocity_by(self.potentials)
