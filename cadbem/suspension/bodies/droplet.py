"""Droplets: a closed spline, a viscosity ratio and an interface law."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from cadbem.checks import instance, offers, positive
from cadbem.closed_points import ClosedPoints, collocation_grid
from cadbem.errors import ConditionError, ShapeError
from cadbem.operators.closed.field import OffSurface, even_sources
from cadbem.operators.closed.layers import ClosedLayers, closed_operator
from cadbem.operators.closed.nearest import signed_distance
from cadbem.operators.far.equivalent import Sources
from cadbem.quadrature.closed import SelfRule
from cadbem.spline.basis import Array
from cadbem.spline.closed import ClosedSpline
from cadbem.suspension.bodies.body import NOTHING, ContactPressure, Densities
from cadbem.suspension.bodies.overview import droplet_text
from cadbem.suspension.interface.equation import InterfaceEquation
from cadbem.suspension.interface.laws import InterfaceLaw, Jump
from cadbem.suspension.interface.mesh import RelaxMesh, stretches, unresolved
from cadbem.suspension.interface.motion import Motion
from cadbem.suspension.interface.resolution import Resolution, resolution, shape_uncertainty
from cadbem.suspension.interface.volume import CorrectVolume, centre, volume

RATE_MARGIN = 1.15  # of the fastest relaxation: splines make short waves a little stiffer


@dataclass(frozen=True, eq=False)
class Droplet:
    """A drop of fluid bounded by ``shape``.

    ``viscosity_ratio`` λ = inner over outer viscosity.  Raises ShapeError for a ratio that is
    not positive and for a shape that is not finite.
    """

    shape: ClosedSpline
    interface: InterfaceLaw
    viscosity_ratio: float = 1.0

    def __post_init__(self) -> None:
        positive("viscosity_ratio (inner over outer)", self.viscosity_ratio)
        instance("shape", self.shape, ClosedSpline, "a closed spline, as from spline_sphere")
        offers("interface", self.interface, ("close",), "SurfaceTension(...)")
        found, wanted = self.shape.coefficients.shape, (self.dimension, *self.shape.basis.shape)
        if found != wanted:
            raise ShapeError(f"the shape's coefficients have shape {found}; give {wanted}")
        if not np.isfinite(self.shape.coefficients).all():
            raise ShapeError("the droplet's shape has coefficients that are not finite numbers")

    __repr__ = droplet_text

    @property
    def dimension(self) -> int:
        """2 or 3."""
        return self.shape.dimension

    @cached_property
    def volume(self) -> float:
        """Volume, or area in 2D."""
        return volume(self.shape)

    @property
    def size(self) -> float:
        """V^(1/3), or the root of the area in 2D."""
        return abs(self.volume) ** (1 / self.dimension)

    @property
    def centre(self) -> Array:
        """Centre of volume (dim,)."""
        return centre(self.shape)

    @property
    def coordinates(self) -> Array:
        """The shape's coefficients, flat."""
        return self.shape.coefficients.ravel()

    def at(self, coordinates: Array) -> Droplet:
        """The droplet with other coefficients."""
        coefficients = coordinates.reshape(self.shape.coefficients.shape)
        return self.moved(replace(self.shape, coefficients=coefficients))

    def moved(self, shape: ClosedSpline) -> Droplet:
        """The same droplet with another shape."""
        return replace(self, shape=shape)

    def shift(self, change: Array) -> Array:
        """Mean displacement (dim,) in a change of coefficients."""
        return change.reshape(self.dimension, -1).mean(axis=1)

    def error(self, change: Array) -> float:
        """Largest displacement in a change of coefficients, relative to the size."""
        steps = change.reshape(self.shape.coefficients.shape)
        return float(np.linalg.norm(steps, axis=0).max()) / self.size

    def repaired(
        self, start: Droplet, volume: CorrectVolume | None, mesh: RelaxMesh | None
    ) -> Droplet:
        """The droplet with the volume that it had at the start, and with its points relaxed."""
        shape = self.shape if volume is None else volume.apply(self.shape, start.volume)
        if mesh is not None:
            shape = mesh.relaxed(shape, self.viscosity_ratio)
        return self.moved(shape)

    def drift(self, start: Droplet) -> float:
        """Relative error of the volume."""
        return self.volume / start.volume - 1

    def unresolved(self) -> str:
        """Why its points do not resolve the shape any more, or an empty text."""
        return unresolved(collocation_grid(self.shape.basis).points(self.shape))

    def placed(self, rule: SelfRule) -> PlacedDroplet:
        """Its layers, integrated as finely as the stretch of the shape requires.

        Raises ShapeError for a shape that is not finite, or folded.
        """
        low, high = stretches(collocation_grid(self.shape.basis).points(self.shape))
        if not np.isfinite(high).all() or not (low > 0).all():
            raise ShapeError("a droplet's shape has points that are not finite, or coincide")
        operator = closed_operator(self.shape.basis, rule.suited(float((high / low).max())))
        return PlacedDroplet(self, ClosedLayers(operator, self.shape))


@dataclass(frozen=True, eq=False)
class PlacedDroplet:
    """A droplet and the ``layers`` of its shape."""

    body: Droplet
    layers: ClosedLayers

    @property
    def targets(self) -> Array:
        """The collocation points (dim, N)."""
        return self.layers.targets.position

    @property
    def samples(self) -> Array:
        """The quadrature points (dim, M)."""
        return self.layers.points.position

    @property
    def sample_normals(self) -> Array:
        """Outward unit normals (dim, M) at the samples."""
        return self.layers.points.normal

    @property
    def jump(self) -> Jump | None:
        """The traction's jump, unless the law has an unknown of its own."""
        law = self.body.interface
        return law.jump_of(self.layers) if hasattr(law, "jump_of") else None

    def sources(self, densities: Densities) -> Sources:
        """Nodes whose sum is S[q] + D[u] far away."""
        return even_sources(self.layers, *densities)

    def near_field(self, points: Array) -> DropletNearField:
        """Evaluates the droplet's layers at points (dim, M) off its surface."""
        return DropletNearField(OffSurface(self.layers, np.ascontiguousarray(points, dtype=float)))

    def equation(
        self,
        viscosity: float,
        deflated: bool,
        contact_pressure: ContactPressure | None = None,
        jump: Jump | None = None,
    ) -> _Equation:
        """Its equation, with its own jump or a given one, and with a contact pressure."""
        jump = self.jump if jump is None else jump
        if jump is None:
            raise ConditionError(
                f"{type(self.body.interface).__name__} has an unknown of its own, which can be "
                "solved for one body only; give the others SurfaceTension or Bending"
            )
        interface = InterfaceEquation(self.layers, self.body.viscosity_ratio, deflated)
        return _Equation(interface, jump, contact_pressure, viscosity)

    @property
    def spacing(self) -> float:
        """Mean distance of the collocation points."""
        area, count = float(self.layers.weights.sum()), self.layers.operator.basis.count
        return (area / count) ** (1 / (self.body.dimension - 1))

    @cached_property
    def uncertainty(self) -> float:
        """By how much the surface may be displaced, as far as the decay of its waves tells."""
        return float(shape_uncertainty(self.body.shape).max())

    def resolution(self, velocity: Array, viscosity: float) -> Resolution:
        """How well the points resolve the shape, and a velocity with coefficients (dim, *shape)."""
        return resolution(self.layers, velocity, self.fastest(viscosity))

    def distance(self, points: Array) -> Array:
        """Distance (M,) of points (dim, M) from the surface, negative inside."""
        return signed_distance(self.body.shape, points)

    def inner_velocity(self, response: Response, points: Array, outer: Array) -> Array:
        """Velocity (dim, M) at points inside, where the outer representation gives ``outer``."""
        return outer / self.body.viscosity_ratio

    def rate(self, response: Response, motion: Motion) -> Array:
        """Rate of the coefficients, flat."""
        return motion(self.layers, response.velocity).ravel()

    def fastest(self, viscosity: float) -> float:
        """Rate at which the shortest waves that the points carry relax, at most.

        A wave of number k on a flat interface decays at stiffness(k) / (2 μ (1 + λ) k).
        """
        body = self.body
        low, high = stretches(self.layers.targets)
        across = 1 / low if body.dimension == 2 else np.hypot(1 / low, 1 / high)
        wave_number = body.shape.basis.shape[-1] / 2 * float(across.max())
        viscosities = viscosity * (1 + body.viscosity_ratio)
        return RATE_MARGIN * body.interface.stiffness(wave_number) / (2 * viscosities * wave_number)


@dataclass(frozen=True, eq=False)
class Response:
    """An interface's ``velocity``, coefficients (dim, *shape), the ``jump`` that goes with it, the
    ``densities`` of all layers of the droplet outside it (values at the nodes, coefficients), the
    equations' ``unknown``, and the number of ``iterations`` that they took."""

    velocity: Array
    jump: Jump
    densities: Densities
    unknown: Array
    iterations: int


@dataclass(frozen=True, eq=False)
class DropletNearField:
    """The velocity that a droplet induces at points off its surface."""

    field: OffSurface

    def velocity(self, densities: Densities) -> Array:
        """(S[q] + D[u]) / 2h (dim, M)."""
        if densities is NOTHING or not self.field.points.size:
            return np.zeros(self.field.points.shape)
        return self.field.apply(*densities) / (2 * self.field.layers.free_term)


@dataclass(frozen=True, eq=False)
class _Equation:
    """See ``Equation`` in ``body``."""

    interface: InterfaceEquation
    jump: Jump
    contact_pressure: ContactPressure | None
    viscosity: float

    def _density(self, points: ClosedPoints) -> Array:
        """-Δf / μ (dim, K), with the contact pressure in the jump: a force F on the interface is a
        jump of -F."""
        jump = self.jump(points)
        if self.contact_pressure is not None:
            jump = jump + self.contact_pressure(points.position) * points.normal
        return jump / -self.viscosity

    @property
    def couples(self) -> bool:
        return self.interface.beta != 0.0

    @cached_property
    def fixed_densities(self) -> Densities:
        return self._density(self.interface.layers.points), None

    @cached_property
    def right_side(self) -> Array:
        single, _ = self.fixed_densities
        assert single is not None
        return self.interface.right_of_layer(single, self._density(self.interface.layers.targets))

    def incident_term(self, incident: Array) -> Array:
        return self.interface.right(incident)

    def apply(self, unknown: Array) -> Array:
        return self.interface.apply(unknown)

    def densities(self, unknown: Array) -> Densities:
        return (None, self.interface.density(unknown)) if self.couples else NOTHING

    def response(self, unknown: Array, iterations: int) -> Response:
        velocity = self.interface.velocity(unknown)
        # with the rigid part, which induces nothing outside but counts inside
        double = (1 - self.interface.viscosity_ratio) * velocity if self.couples else None
        return Response(velocity, self.jump, (self.fixed_densities[0], double), unknown, iterations)
