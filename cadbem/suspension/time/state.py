"""Bodies at one moment of a run."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from cadbem.boundary import Boundary
from cadbem.checks import shaped
from cadbem.operators.closed.layers import ClosedLayers
from cadbem.problems.estimates import Accuracy
from cadbem.problems.solution import StokesSolution
from cadbem.spline.basis import Array
from cadbem.spline.closed import ClosedSpline
from cadbem.suspension.bodies.body import Body, Placed
from cadbem.suspension.bodies.droplet import Droplet, PlacedDroplet, Response
from cadbem.suspension.bodies.particle import RigidParticle
from cadbem.suspension.interface.resolution import Resolution
from cadbem.suspension.multibody.contact import Gap, narrowest
from cadbem.suspension.multibody.environment import Environment
from cadbem.suspension.multibody.fields import velocity_at
from cadbem.suspension.multibody.measures import Measures, centre_velocity, measure
from cadbem.suspension.multibody.multibody import MultibodySystem
from cadbem.suspension.surroundings.channel_flow import ChannelFlow
from cadbem.suspension.surroundings.surroundings import Surroundings
from cadbem.suspension.time.accuracy import state_accuracy
from cadbem.suspension.time.overview import state_overview


@dataclass(frozen=True, eq=False)
class State:
    """The ``bodies`` at a ``time``, their ``numbers`` from 1 on, and how they got there: accepted
    ``steps`` and ``evaluations`` of the velocities so far, the ``length`` of the last step, its
    estimated ``error``, a displacement relative to the bodies' sizes, and ``drift``, the largest
    relative error of a volume that it made, before correction.

    ``left`` says of each body that has left the channel, by its number, when and where it left;
    ``guess`` has the unknowns of the bodies' equations at the time before, or nothing.
    ``stopped`` is empty, or says why a run ended early.
    """

    environment: Environment
    time: float
    bodies: tuple[Body, ...]
    numbers: tuple[int, ...] = (1,)
    steps: int = 0
    evaluations: int = 0
    length: float = 0.0
    error: float = 0.0
    drift: float = 0.0
    stopped: str = ""
    left: dict[int, str] = field(default_factory=dict)
    guess: tuple[Array, ...] = ()

    def __repr__(self) -> str:
        return state_overview(self).text()

    def _repr_html_(self) -> str:
        return state_overview(self).html()

    @property
    def flow(self) -> Surroundings:
        """The surroundings of the bodies."""
        return self.environment.flow

    @property
    def droplets(self) -> tuple[Droplet, ...]:
        """The bodies that are droplets."""
        return tuple(b for b in self.bodies if isinstance(b, Droplet))

    @property
    def droplet(self) -> Droplet:
        """The first droplet, of most runs the only one."""
        return self.droplets[0]

    @property
    def shapes(self) -> dict[int, ClosedSpline | Boundary]:
        """The surface of each body, by its number."""
        pairs = zip(self.numbers, self.bodies, strict=True)
        return {
            n: b.boundary if isinstance(b, RigidParticle) else b.shape  # type: ignore[attr-defined]
            for n, b in pairs
        }

    @cached_property
    def placed(self) -> list[Placed]:
        """Each body with its geometry evaluated."""
        return [b.placed(self.environment.rule) for b in self.bodies]

    @property
    def layers(self) -> list[ClosedLayers]:
        """Each droplet's layers."""
        return [p.layers for p in self.placed if isinstance(p, PlacedDroplet)]

    @cached_property
    def responses(self) -> list[Any]:
        """The ``Response`` of each droplet, the ``ParticleResponse`` of each particle."""
        return self.environment.responses(self.placed, self.guess)

    @property
    def response(self) -> Any:
        """The response of the first body."""
        return self.responses[0]

    @cached_property
    def gaps(self) -> list[Gap]:
        """The narrowest gap of each body, if it is narrow."""
        return narrowest(self.flow, self.placed, self.numbers, everywhere=False)

    @property
    def resolutions(self) -> dict[int, Resolution]:
        """How well each droplet's points resolve its shape and velocity, by its number."""
        parts = zip(self.numbers, self.placed, self.responses, strict=True)
        return {
            n: p.resolution(r.velocity, self.flow.viscosity)
            for n, p, r in parts
            if isinstance(p, PlacedDroplet)
        }

    @cached_property
    def accuracy(self) -> Accuracy:
        """How wrong the state may be, by quantity and body."""
        return state_accuracy(self)

    @property
    def velocities(self) -> list[Array]:
        """Velocity (dim,) of the centre of each body."""
        return [
            centre_velocity(b.shape, r.velocity) if isinstance(b, Droplet) else r.velocity
            for b, r in zip(self.bodies, self.responses, strict=True)
        ]

    def gap(self, number: int) -> float:
        """Length of the narrowest gap of the body of a number, inf where it is wide."""
        return next((gap.length for gap in self.gaps if gap.body == number), np.inf)

    def velocity_at(self, points: ArrayLike) -> Array:
        """Velocity (dim, M) at points (dim, M) inside and outside the bodies, in the fluid."""
        far, dimension = self.environment.far, self.bodies[0].dimension
        position = shaped("points", points, dimension, None)
        return velocity_at(self.flow, self.placed, self.responses, position, far)

    @cached_property
    def walls(self) -> StokesSolution:
        """Velocity and traction on a channel's boundary, with the bodies in it."""
        flow = self.flow
        assert isinstance(flow, ChannelFlow), "unbounded fluid has no walls"
        system = MultibodySystem(flow, tuple(self.placed), far=self.environment.far)
        return flow.solution(system.velocity_at_walls([r.densities for r in self.responses]))

    @cached_property
    def measures(self) -> list[Measures]:
        """Deformation, inclination, volume, energies, mesh quality and more, of each droplet."""
        flow = self.flow
        return [
            measure(b.shape, r.velocity, r.jump, flow.background, flow.viscosity, b.viscosity_ratio)
            for b, r in zip(self.bodies, self.responses, strict=True)
            if isinstance(b, Droplet) and isinstance(r, Response)
        ]
