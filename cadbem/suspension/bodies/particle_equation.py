"""The equation of a rigid particle, its solution, and the velocity that it induces."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from cadbem.operators.potentials import Potentials
from cadbem.space import Field
from cadbem.spline.basis import Array
from cadbem.suspension.bodies.body import NOTHING, Densities
from cadbem.suspension.rigid.pose import rigid_motions
from cadbem.suspension.rigid.resistance import Resistance


@dataclass(frozen=True, eq=False)
class ParticleResponse:
    """The ``velocity`` (dim,) of a particle's ``centre`` and its ``angular_velocity`` (3,), or (1,)
    in a plane; the ``traction`` on it in its own axes, a field; the ``densities`` of its
    layers, the equations' ``unknown``, and the number of ``iterations`` that they took."""

    centre: Array
    velocity: Array
    angular_velocity: Array
    traction: Field
    densities: Densities
    unknown: Array
    iterations: int

    def velocity_at(self, points: Array) -> Array:
        """The rigid motion at points (dim, M)."""
        motion = np.concatenate([self.velocity, self.angular_velocity])
        return np.einsum("m,mcn->cn", motion, rigid_motions(points - self.centre[:, None]))


@dataclass(frozen=True, eq=False)
class ParticleNearField:
    """The velocity that a particle induces at points off its surface."""

    potentials: Potentials
    turn: Array

    def velocity(self, densities: Densities) -> Array:
        """S[q] / 2h (dim, M)."""
        single, _ = densities
        if single is None or not self.potentials.targets.count:
            return np.zeros(self.potentials.targets.position.shape)
        inside = 2 * self.potentials.kernel.free_term
        return self.turn @ self.potentials.apply(single, np.zeros_like(single)) / inside


@dataclass(frozen=True, eq=False)
class ParticleEquation:
    """See ``Equation`` in ``body``.

    w (dim, F + 2) is f / μ, coefficients in the body's axes, followed by U and Ω there;
    ``load_rate`` is the external force and torque, over μ, in one array.
    """

    resistance: Resistance
    centre: Array
    turn: Array
    load_rate: Array
    viscosity: float
    couples: bool = True
    fixed_densities: Densities = NOTHING

    def _unknown(self, velocity: Array, load: Array) -> Array:
        traction, motion = self.resistance.solve(velocity, load)
        columns = np.zeros((2, len(velocity)))
        columns.ravel()[: len(motion)] = motion
        return np.concatenate([traction, columns.T], axis=1)

    @cached_property
    def right_side(self) -> Array:
        own = self.resistance
        return self._unknown(np.zeros((own.dimension, own.space.count)), self.load_rate)

    def incident_term(self, incident: Array) -> Array:
        return self._unknown(self.turn.T @ incident, np.zeros_like(self.load_rate))

    def apply(self, unknown: Array) -> Array:
        return unknown

    def densities(self, unknown: Array) -> Densities:
        return np.ascontiguousarray(-unknown[:, :-2]), None

    def response(self, unknown: Array, iterations: int) -> ParticleResponse:
        motion = unknown[:, -2:].T.ravel()[: len(self.load_rate)]
        velocity, spin = np.split(motion, [self.resistance.dimension])
        traction = Field(self.resistance.space, self.viscosity * unknown[:, :-2])
        return ParticleResponse(
            centre=self.centre,
            velocity=self.turn @ velocity,
            angular_velocity=self.turn @ spin if len(spin) == 3 else spin,
            traction=traction,
            densities=self.densities(unknown),
            unknown=unknown,
            iterations=iterations,
        )
