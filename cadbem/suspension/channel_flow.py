"""Droplets in a channel: its walls answer to what droplets do."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

from cadbem.problems.solution import StokesSolution
from cadbem.problems.stokes import StokesProblem
from cadbem.spline.basis import Array
from cadbem.suspension.together import Induced


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
        """The flow without droplets."""
        return self.problem.solve()

    def velocity(self, points: Array, induced: Induced) -> Array:
        """Velocity (dim, M) at points (dim, M) of the empty channel, and what its boundary adds to
        the one that droplets make."""
        return (self.empty + self._reflection(induced)).velocity_at(points)

    def reflected(self, points: Array, induced: Induced) -> Array:
        """What the boundary adds alone."""
        return self._reflection(induced).velocity_at(points)

    def _reflection(self, induced: Induced) -> StokesSolution:
        return self.problem.reflection(induced(self.problem.space.collocation.position))
