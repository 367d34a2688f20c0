"""The protocols of bodies, which droplets and rigid particles fulfil.

A ``Body`` is a value with coordinates; a step in time gives a body with other coordinates.  A
``Placed`` body is one with its geometry evaluated at one moment.  It has an equation of its own for
an unknown w (dim, K),

    A w = b + L[u∞],

where u∞ is the incident velocity at its N target points: that of the flow without bodies, of the
other bodies and of walls.  The velocity that it induces itself is that of layers with densities
that are fixed (``fixed_densities``) and densities that depend on w.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Protocol, Self

from cadbem.operators.far.equivalent import Sources
from cadbem.quadrature.closed import SelfRule
from cadbem.spline.basis import Array
from cadbem.suspension.interface.laws import Jump
from cadbem.suspension.interface.mesh import RelaxMesh
from cadbem.suspension.interface.motion import Motion
from cadbem.suspension.interface.volume import CorrectVolume

ContactPressure = Callable[[Array], Array]  # contact pressure (M,) at points (dim, M)
Densities = tuple[Array | None, Array | None]  # of a single and a double layer
NOTHING: Densities = (None, None)


class NearField(Protocol):
    """Evaluates the velocity that a body induces at fixed points, also at those close to it."""

    def velocity(self, densities: Densities) -> Array:
        """Velocity (dim, M) of its layers, (S[q] + D[u]) / 2h, at the points."""


class Equation(Protocol):
    """The equation of a body at one moment: see the top of this file."""

    @property
    def couples(self) -> bool:
        """Whether the induced velocity depends on w."""

    @property
    def fixed_densities(self) -> Densities:
        """Densities of the layers that do not depend on the incident velocity."""

    @property
    def right_side(self) -> Array:
        """b (dim, K)."""

    def incident_term(self, incident: Array) -> Array:
        """L[u∞] (dim, K) for an incident velocity u∞ (dim, N) at the targets."""

    def apply(self, unknown: Array) -> Array:
        """A w (dim, K)."""

    def densities(self, unknown: Array) -> Densities:
        """Densities of the layers that depend on w."""

    def response(self, unknown: Array, iterations: int) -> Any:
        """The solution for this body: its velocity, and the densities of all its layers."""


class Placed(Protocol):
    """A body with its geometry evaluated."""

    @property
    def targets(self) -> Array:
        """Points (dim, N) at which its equation needs the incident velocity."""

    @property
    def samples(self) -> Array:
        """Points (dim, M) all over the surface, closer together than the targets."""

    @property
    def sample_normals(self) -> Array:
        """Outward unit normals (dim, M) at the samples."""

    def near_field(self, points: Array) -> NearField:
        """Evaluates the body's layers at points (dim, M) off its surface."""

    def sources(self, densities: Densities) -> Sources:
        """Nodes, all within the samples' extent, whose sum is S[q] + D[u] far away."""

    def equation(
        self,
        viscosity: float,
        deflated: bool,
        contact_pressure: ContactPressure | None = None,
        jump: Jump | None = None,
    ) -> Equation:
        """Its equation, with a ``contact_pressure`` from outside, and with a given ``jump`` if the
        interface law leaves that open."""

    @property
    def spacing(self) -> float:
        """Mean distance of its points."""

    @property
    def uncertainty(self) -> float:
        """By how much the surface may be out of place, as far as its points tell: a length."""

    def distance(self, points: Array) -> Array:
        """Distance (M,) of points (dim, M) from the surface, negative inside."""

    def inner_velocity(self, response: Any, points: Array, outer: Array) -> Array:
        """Velocity (dim, M) at points inside, where the outer representation gives ``outer``."""

    def rate(self, response: Any, motion: Motion) -> Array:
        """Rate of its coordinates."""

    def fastest(self, viscosity: float) -> float:
        """Rate at which its fastest waves decay."""


class Body(Protocol):
    """A droplet or a rigid particle."""

    @property
    def dimension(self) -> int:
        """2 or 3."""

    @property
    def size(self) -> float:
        """A length (float): the cube root of its volume, in 2D the square root of its area."""

    @property
    def centre(self) -> Array:
        """Centre of volume (dim,)."""

    @property
    def coordinates(self) -> Array:
        """All numbers that change in time, as a flat array."""

    def at(self, coordinates: Array) -> Self:
        """The body with other coordinates."""

    def shift(self, change: Array) -> Array:
        """Mean displacement (dim,) in a change of coordinates."""

    def error(self, change: Array) -> float:
        """Largest displacement in a change of coordinates, relative to the size."""

    def repaired(self, start: Self, volume: CorrectVolume | None, mesh: RelaxMesh | None) -> Self:
        """The body with the volume that it had at the start, and with its points relaxed."""

    def drift(self, start: Self) -> float:
        """Relative error of the volume."""

    def unresolved(self) -> str:
        """Why its points do not resolve the shape any more, or an empty text."""

    def placed(self, rule: SelfRule) -> Placed:
        """Its geometry.  Raises ShapeError if the surface is not finite, or is folded."""
