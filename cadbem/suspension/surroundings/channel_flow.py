"""The flow in a channel with bodies: the empty channel, and the velocity reflected by its walls."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from cadbem.elements.pieces import Elements, Pieces
from cadbem.kernels.stokes import stokes_kernels
from cadbem.operators.compressed.storage import Dense
from cadbem.operators.interactions import Targets
from cadbem.operators.potentials import Potentials
from cadbem.problems.conditions import OPEN
from cadbem.problems.enclosure import Enclosure
from cadbem.problems.solution import StokesSolution
from cadbem.problems.stokes import StokesProblem
from cadbem.quadrature import Quadrature, Rules
from cadbem.spline.basis import Array
from cadbem.suspension.surroundings.surroundings import Nearest

# points up to which the whole matrix is kept: it is solved with at each step, and among large and
# small elements iterations converge slowly
MOST_DENSE = 6000


@dataclass(frozen=True, eq=False)
class ChannelFlow:
    """The fluid in a channel; the ``problem``'s matrix is assembled and factorised once.

    ``quadrature`` serves the walls' field at the bodies; ``deflated`` False leaves the droplets'
    equations as they stand, for comparison.  ``pieces`` are the elements of the boundary's patches
    that are solved on, where bodies ask for finer ones: None for the patches as they are.
    """

    problem: StokesProblem
    quadrature: Rules = field(default_factory=lambda: Quadrature(1e-5))
    deflated: bool = True
    pieces: Pieces | None = None

    def with_pieces(self, pieces: Pieces | None) -> ChannelFlow:
        """The same flow, solved on other elements."""
        other = replace(self, pieces=pieces)
        vars(other).update(_enclosure=self._enclosure, drawn=self.drawn)
        return other

    def with_accuracy(self, accuracy: float) -> ChannelFlow:
        """The flow on elements that make it as accurate without bodies."""
        empty = self.problem.solve(accuracy)
        assert isinstance(empty.problem, StokesProblem)
        other = replace(self, problem=empty.problem)
        vars(other)["empty"] = empty
        return other

    def forget(self) -> None:
        """Drop what is large and can be worked out again: the matrix of elements near bodies."""
        if self.pieces is not None:
            for name in ("solved", "empty"):
                vars(self).pop(name, None)

    @cached_property
    def solved(self) -> StokesProblem:
        """The problem on the elements that are solved on."""
        if self.pieces is None:
            return self.problem
        boundary, problem = self.pieces.of(self.problem.boundary), self.problem
        count = sum(p.surface.weights.size for p in boundary.patches)
        if problem.storage is None and count <= MOST_DENSE:
            problem = replace(problem, storage=Dense())
        return problem.on(boundary)

    @property
    def viscosity(self) -> float:
        """Viscosity of the fluid outside the droplets."""
        return self.problem.viscosity

    @property
    def background(self) -> None:
        """None, as the fluid is bounded."""
        return None

    @cached_property
    def drawn(self) -> Elements:
        """The elements of the problem's boundary."""
        return Elements.of(self.problem.boundary)

    @cached_property
    def elements(self) -> Elements:
        """The elements that are solved on."""
        return self.drawn if self.pieces is None else Elements.of(self.solved.boundary)

    @cached_property
    def empty(self) -> StokesSolution:
        """The flow without bodies."""
        return self.problem.solve() if self.pieces is None else self.solved.flow()

    @property
    def accuracy(self) -> float:
        """Relative error of the channel's linear system."""
        return self.solved.layers.tolerance

    @property
    def walls(self) -> Array:
        """The collocation points (dim, W) of the channel."""
        return self.solved.space.collocation.position

    def at(self, points: Array) -> _AtPoints:
        """The flow at points (dim, M) off the walls."""
        kernel, _ = stokes_kernels(len(points))
        targets = Targets.free(np.ascontiguousarray(points))
        potentials = Potentials(kernel, self.solved.space, targets, self.quadrature)
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
        opening = [isinstance(kind, OPEN) for kind in kinds]
        return Nearest(distance, names, np.array(opening))

    def solution(self, induced: Array) -> StokesSolution:
        """The flow with bodies that induce the velocity ``induced`` (dim, W) at the walls, without
        the field of the bodies themselves."""
        return self.empty + self.solved.reflection(induced)


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
        return self.flow.solved.reflection(induced).velocity_by(self.potentials)
