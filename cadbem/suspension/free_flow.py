"""Droplets in unbounded fluid."""

from __future__ import annotations

from dataclasses import dataclass

from cadbem.errors import ConditionError
from cadbem.operators.closed import ClosedLayers
from cadbem.spline.basis import Array
from cadbem.suspension.droplet import Droplet
from cadbem.suspension.flows import BackgroundFlow
from cadbem.suspension.together import Induced, Response, respond_together


@dataclass(frozen=True, eq=False)
class FreeFlow:
    """Unbounded fluid of a ``viscosity`` that flows like ``background`` far away.

    ``deflated`` False leaves the droplets' equations as they stand, for comparison.
    """

    background: BackgroundFlow
    viscosity: float = 1.0
    deflated: bool = True

    def __post_init__(self) -> None:
        if not self.viscosity > 0:
            raise ConditionError(f"viscosity {self.viscosity}: give a positive number")

    def velocity(self, points: Array, induced: Induced) -> Array:
        """Velocity (dim, M) at points (dim, M) without any droplet."""
        return self.background.velocity(points)

    def reflected(self, points: Array, induced: Induced) -> float:
        """Nothing: there are no walls."""
        return 0.0

    def respond(self, droplet: Droplet, layers: ClosedLayers) -> Response:
        """The velocity of one droplet's interface."""
        return respond_together(self, [droplet], [layers])[0]
