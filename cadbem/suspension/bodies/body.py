"""What droplets and rigid particles have in common.

A ``Body`` is a value that moves: it has coordinates, and steps in time make others of it.  A
``Placed`` body is one with its geometry worked out at one moment; it takes part in the flow by an
equation of its own for an unknown w (dim, K),

    A w = b + L[u∞],

where u∞ is the velocity at its N target points that all else makes.  What it makes itself is that
of layers with a fixed density, its ``load``, and one that depends on w.
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

Push = Callable[[Array], Array]  # pressure (M,) from without at points (dim, M)
Densities = tuple[Array | None, Array | None]  # coefficients of a single and a double layer
NOTHING: Densities = (None, None)


class Seen(Protocol):
    """What a body makes at fixed points."""

    def velocity(self, densities: Densities) -> Array:
        """Velocity (dim, M) of its layers, (S[q] + D[u]) / 2h, at the points."""


class Equation(Protocol):
    """A body's part in the flow at one moment: see the top of this file."""

    @property
    def couples(self) -> bool:
        """Whether what the body makes depends on w."""

    @property
    def load(self) -> Densities:
        """What the body makes whatever it feels."""

    @property
    def start(self) -> Array:
        """b (dim, K)."""

    def answer(self, felt: Array) -> Array:
        """L[u∞] (dim, K) for a velocity (dim, N) at the targets."""

    def apply(self, unknown: Array) -> Array:
        """A w (dim, K)."""

    def densities(self, unknown: Array) -> Densities:
        """What the body makes because of w."""

    def response(self, unknown: Array, iterations: int) -> Any:
        """What became of the body: its velocity, and the densities of all that it makes."""


class Placed(Protocol):
    """A body with its geometry worked out."""

    @property
    def targets(self) -> Array:
        """Points (dim, N) at which it must know the velocity."""

    @property
    def samples(self) -> Array:
        """Points (dim, M) all over the surface, closer together than the targets."""

    def seen_from(self, points: Array) -> Seen:
        """The body as seen from points (dim, M) off it."""

    def sources(self, densities: Densities) -> Sources:
        """Nodes, all within the samples' extent, that make S[q] + D[u] far away."""

    def equation(
        self, viscosity: float, deflated: bool, push: Push | None = None, jump: Jump | None = None
    ) -> Equation:
        """Its part in the flow; with a pressure ``push`` from without, and with a given ``jump``
        if its law leaves that open."""

    @property
    def spacing(self) -> float:
        """Mean distance of its points."""

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
        """A length: the root of its volume."""

    @property
    def centre(self) -> Array:
        """Centre of volume (dim,)."""

    @property
    def coordinates(self) -> Array:
        """All that changes in time, flat."""

    def at(self, coordinates: Array) -> Self:
        """The body with other coordinates."""

    def shift(self, change: Array) -> Array:
        """Mean displacement (dim,) in a change of coordinates."""

    def error(self, change: Array) -> float:
        """Largest displacement in a change of coordinates, relative to the size."""

    def repaired(self, start: Self, volume: CorrectVolume | None, mesh: RelaxMesh | None) -> Self:
        """With the volume that it had at the start, and its points relaxed."""

    def drift(self, start: Self) -> float:
        """Relative error of the volume."""

    def unresolved(self) -> str:
        """Why its shape cannot be trusted any more, or nothing."""

    def placed(self, rule: SelfRule) -> Placed:
        """Its geometry.  Raises ShapeError if that is unsound."""
