"""Rigid particles of any closed shape."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from cadbem.boundary import Boundary
from cadbem.checks import instance, shaped, turning, vector
from cadbem.elements.pieces import Pieces
from cadbem.operators.far.equivalent import Sources
from cadbem.operators.interactions import Targets
from cadbem.operators.potentials import Potentials
from cadbem.quadrature import Quadrature, Rules
from cadbem.quadrature.closed import SelfRule
from cadbem.spline.basis import Array
from cadbem.suspension.bodies.body import ContactPressure, Densities
from cadbem.suspension.bodies.overview import particle_text
from cadbem.suspension.bodies.particle_equation import (
    ParticleEquation,
    ParticleNearField,
    ParticleResponse,
)
from cadbem.suspension.interface.laws import Jump
from cadbem.suspension.interface.mesh import RelaxMesh
from cadbem.suspension.interface.motion import Motion
from cadbem.suspension.interface.volume import CorrectVolume
from cadbem.suspension.rigid.pose import Pose, rigid_motions, unturned
from cadbem.suspension.rigid.resistance import Resistance, resistance

Vector = float | Sequence[float] | Array

RIGID = 0.06  # spacings: so gaps below 0.2 spacings are uncertain by 0.3 gaps


@dataclass(frozen=True, eq=False)
class RigidParticle:
    """A rigid body with a closed ``shape`` of degree-elevated, refined patches.

    The shape may be given at any place; the centre of its volume is moved to ``position`` (dim,),
    and stays where it is by default.  ``force`` (dim,) and ``torque`` (3,), or a number in a plane,
    are external ones on the centre, such as buoyancy; zero by default.  Particles that share one
    shape share its matrix.  ``pieces`` are the elements of the shape that are solved on, where
    something near asks for finer ones: None for the patches as they are.  Raises ShapeError for a
    shape that is not closed.
    """

    shape: Boundary
    position: ArrayLike | None = None
    force: Vector = 0.0
    torque: Vector = 0.0
    quadrature: Rules = field(default_factory=lambda: Quadrature(1e-6))
    turn: Array | None = None
    pieces: Pieces | None = None

    def __post_init__(self) -> None:
        instance("shape", self.shape, Boundary, "a Boundary of the particle's surface")
        dimension = self.dimension
        if self.position is not None:
            shaped("position", self.position, dimension)
        vector("force", self.force, dimension)
        turning("torque", self.torque, dimension)
        resistance(self.shape, self.quadrature)

    __repr__ = particle_text

    @property
    def dimension(self) -> int:
        """2 or 3."""
        return self.shape.dimension

    @property
    def drawn(self) -> Resistance:
        """The matrix of the shape as it was given, shared by all that have it."""
        return resistance(self.shape, self.quadrature)

    def with_pieces(self, pieces: Pieces | None) -> RigidParticle:
        """The same particle, solved on other elements."""
        return replace(self, pieces=pieces)

    @cached_property
    def resistance(self) -> Resistance:
        """The matrix of the elements that are solved on."""
        if self.pieces is None:
            return self.drawn
        return Resistance(self.pieces.of(self.shape), self.quadrature)

    @cached_property
    def pose(self) -> Pose:
        """Where the particle is."""
        centre = self.drawn.centre if self.position is None else self.position
        start = unturned(np.asarray(centre, dtype=float))
        return start if self.turn is None else replace(start, turn=self.turn)

    @property
    def size(self) -> float:
        """V^(1/3), or the root of the area in 2D."""
        return self.resistance.volume ** (1 / self.dimension)

    @property
    def coordinates(self) -> Array:
        """Position and turn, flat."""
        return self.pose.coordinates

    def at(self, coordinates: Array) -> RigidParticle:
        """The particle elsewhere."""
        pose = Pose.of(coordinates, self.dimension)
        other = replace(self, position=pose.position, turn=pose.turn)
        vars(other)["resistance"] = self.resistance
        return other

    @property
    def centre(self) -> Array:
        """Centre of volume (dim,)."""
        return self.pose.position

    def shift(self, change: Array) -> Array:
        """Displacement (dim,) of the centre in a change of coordinates."""
        return change[: self.dimension]

    def error(self, change: Array) -> float:
        """Largest displacement in a change of coordinates, relative to the size."""
        shift, turn = np.split(change, [self.dimension])
        # a quaternion turns by twice its own angle
        angle = float(np.linalg.norm(turn)) * (self.dimension - 1)
        return max(float(np.linalg.norm(shift)) / self.size, angle)

    def repaired(
        self, start: RigidParticle, volume: CorrectVolume | None, mesh: RelaxMesh | None
    ) -> RigidParticle:
        """The same: rigid bodies keep their shape."""
        return self

    def drift(self, start: RigidParticle) -> float:
        """Zero: the volume does not change."""
        return 0.0

    def unresolved(self) -> str:
        """An empty text: the shape does not change."""
        return ""

    @cached_property
    def boundary(self) -> Boundary:
        """The elements of the shape where it is now."""
        turn = self.pose.matrix
        shift = self.pose.position - turn @ self.resistance.centre
        return self.resistance.boundary.transformed(turn, shift)

    def placed(self, rule: SelfRule) -> PlacedParticle:
        """Its geometry, which is always valid."""
        return PlacedParticle(self)


@dataclass(frozen=True, eq=False)
class PlacedParticle:
    """A rigid particle with its geometry evaluated.

    Its layers are evaluated in its own axes, where its nodes never change.
    """

    body: RigidParticle

    @cached_property
    def _turn(self) -> Array:
        return self.body.pose.matrix

    def _own(self, points: Array) -> Array:
        """Points (dim, M) in the body's axes."""
        arm = points - self.body.pose.position[:, None]
        return self._turn.T @ arm + self.body.resistance.centre[:, None]

    @cached_property
    def targets(self) -> Array:
        """The collocation points (dim, N)."""
        return self.world(self.body.resistance.space.collocation.position)

    def world(self, points: Array) -> Array:
        """Points (dim, M) of the body's axes."""
        arm = points - self.body.resistance.centre[:, None]
        return self._turn @ arm + self.body.pose.position[:, None]

    @cached_property
    def samples(self) -> Array:
        """Points (dim, M) of a Gauss rule on the surface."""
        return self.world(self.body.resistance.surface[0].position)

    @property
    def sample_normals(self) -> Array:
        """Outward unit normals (dim, M) at the samples."""
        return self._turn @ self.body.resistance.surface[0].normal

    def sources(self, densities: Densities) -> Sources:
        """Nodes whose sum is S[q] far away."""
        position, weighted = self.body.resistance.nodes
        single, _ = densities
        if single is not None:
            single = self._turn @ single @ weighted
        return Sources(self.world(position), single)

    def near_field(self, points: Array) -> ParticleNearField:
        """Evaluates the particle's layer at points (dim, M) off its surface."""
        own = self.body.resistance
        targets = Targets.free(np.ascontiguousarray(self._own(points)))
        return ParticleNearField(
            Potentials(own.kernel, own.space, targets, own.quadrature), self._turn
        )

    def equation(
        self,
        viscosity: float,
        deflated: bool,
        contact_pressure: ContactPressure | None = None,
        jump: Jump | None = None,
    ) -> ParticleEquation:
        """Its equation, with a contact pressure."""
        own, pose = self.body.resistance, self.body.pose
        load = self._load(contact_pressure) / viscosity
        return ParticleEquation(own, pose.position, self._turn, load, viscosity)

    def _load(self, contact_pressure: ContactPressure | None) -> Array:
        """External force and torque, in the body's axes, in one array."""
        force, torque = self.body.force, self.body.torque
        if self.body.dimension == 3:
            torque = self._turn.T @ np.broadcast_to(torque, 3)
        force = self._turn.T @ np.broadcast_to(force, self.body.dimension)
        load = np.append(force, torque)
        if contact_pressure is None:
            return load
        own = self.body.resistance
        points, weights = own.surface
        pressure = contact_pressure(self.world(points.position))
        modes = rigid_motions(points.position - own.centre[:, None])
        return load - np.einsum("mcn,cn,n->m", modes, points.normal, pressure * weights)

    @property
    def spacing(self) -> float:
        """Mean distance of the collocation points."""
        return self.body.resistance.spacing

    @property
    def uncertainty(self) -> float:
        """A share of the spacing: the surface is exact, the traction on it is not."""
        return RIGID * self.spacing

    def distance(self, points: Array) -> Array:
        """Distance (M,) of points (dim, M) from the surface, negative inside."""
        near = self.body.resistance.nearest.find(self._own(points))
        return np.where(near.before, near.distance, -near.distance)

    def inner_velocity(self, response: ParticleResponse, points: Array, outer: Array) -> Array:
        """Velocity (dim, M) at points inside."""
        return response.velocity_at(points)

    def rate(self, response: ParticleResponse, motion: Motion) -> Array:
        """Rate of position and turn, flat."""
        return self.body.pose.rate(response.velocity, response.angular_velocity)

    def fastest(self, viscosity: float) -> float:
        """Zero: no waves decay on a rigid body."""
        return 0.0
