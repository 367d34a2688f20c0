"""The protocols of surroundings, which unbounded fluid and channels fulfil."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from cadbem.spline.basis import Array
from cadbem.suspension.surroundings.flows import BackgroundFlow


class Incident(Protocol):
    """The flow at fixed points, without the velocity that bodies induce there directly.

    ``induced`` (dim, W) is the velocity that bodies induce at the walls' points.
    """

    def velocity(self, induced: Array | None) -> Array:
        """Velocity (dim, M): the flow without bodies plus the velocity that walls reflect."""

    def reflected(self, induced: Array) -> Array:
        """The reflected velocity (dim, M) alone."""


@dataclass(frozen=True, eq=False)
class Nearest:
    """The boundary near M points: ``distance`` (M,), negative outside the fluid and inf
    where there is none near; the ``names`` of the nearest faces, and whether they are an
    ``opening`` (M,)."""

    distance: Array
    names: list[str]
    opening: NDArray[np.bool_]


class Surroundings(Protocol):
    """Unbounded fluid, or a channel."""

    @property
    def viscosity(self) -> float:
        """Viscosity of the fluid outside droplets."""

    @property
    def background(self) -> BackgroundFlow | None:
        """The flow far away, if the fluid is unbounded."""

    @property
    def deflated(self) -> bool:
        """Whether to deflate the equations of droplets."""

    @property
    def accuracy(self) -> float:
        """Relative error of the reflected velocity, beyond round-off and that of the
        discretisation."""

    @property
    def walls(self) -> Array | None:
        """Points (dim, W) of walls at which the induced velocity is needed, if there are walls."""

    def at(self, points: Array) -> Incident:
        """The flow at points (dim, M)."""

    def nearest(self, points: Array, reach: float) -> Nearest:
        """The boundary near points (dim, M), as far as a ``reach``."""
