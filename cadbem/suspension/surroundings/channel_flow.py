"""The flow in a channel with bodies: the empty channel, and the velocity reflected by its walls."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from cadbem.kernels.stokes import stokes_kernels
from cadbem.operators.interactions import Targets
from cadbem.operators.potentials import Potentials
from cadbem.problems.conditions import Inflow, Pressure, Traction
from cadbem.problems.enclosure import Enclosure
from cadbem.problems.solution import StokesSolution
from cadbem.problems.stokes import StokesProblem
from cadbem.quadrature import Quadrature, Rules
from cadbem.spline.basis import Array
from cadbem.suspension.surroundings.surroundings import Nearest


@dataclass(frozen=True, eq=False)
class ChannelFlow:
    """The fluid in a channel; the ``problem``'s matrix is assembled and factorised once.

    ``quadrature`` serves the walls' field at the bodies; ``deflated`` False leaves the droplets'
    equations as they stand, for comparison.
    """

    problem: StokesProblem
    quadrature: Rules = field(default_factory=lambda: Quadrature(1e-5))
    deflated: bool = True

    @property
    def viscosity(self) -> float:
        """Viscosity of the fluid outside the droplets."""
        return self.problem.viscosity

    @property
    def background(self) -> None:
        """None, as the fluid is bounded."""
        return None

    @cached_property
    def empty(self) -> StokesSolution:
        """The flow without bodies."""
        return self.problem.solve()

    @property
    def accuracy(self) -> float:
        """Relative error of the channel's linear system."""
        return self.problem.layers.tolerance

    @property
    def walls(self) -> Array:
        """The collocation points (dim, W) of the channel."""
        return self.problem.space.collocation.position

    def at(self, points: Array) -> _AtPoints:
        """The flow at points (dim, M) off the walls."""
        kernel, _ = stokes_kernels(len(points))
        targets = Targets.free(np.ascontiguousarray(points))
        potentials = Potentials(kernel, self.problem.space, targets, self.quadrature)
        return _AtPoints(self, potentials)

    @cached_property
    def _enclosure(self) -> Enclosure:
        return Enclosure(self.problem.boundary)

    def nearest(self, points: Array, reach: float) -> Nearest:
        """The boundary near points (dim, M) of one body, as far as a ``reach``.

        A thin plate has fluid on both sides; there, the side of most of the points is inside.
        """
        found = self._enclosure.clearance(points, reach)
        patches, thin = self.problem.boundary.patches, self._enclosure.two_sided
        distance = found.distance.copy()
        for patch in np.unique(found.patch[thin[found.patch]]):
            here = np.nonzero(found.patch == patch)[0]
            sides = found.normal[:, here]
            distance[here[sides.sum(axis=1) @ sides < 0]] *= -1
        names = [patches[i].name if i >= 0 else "" for i in found.patch]
        kinds = [self.problem.conditions.get(n) for n in names]
        opening = [isinstance(kind, Inflow | Pressure | Traction) for kind in kinds]
        return Nearest(distance, names, np.array(opening))

    def solution(self, induced: Array) -> StokesSolution:
        """The flow with bodies that induce the velocity ``induced`` (dim, W) at the walls, without
        the field of the bodies themselves."""
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
