"""The fluid that bodies are in, as they feel it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from cadbem.spline.basis import Array
from cadbem.suspension.surroundings.flows import BackgroundFlow


class Incident(Protocol):
    """The flow at fixed points, without what bodies make there directly.

    ``induced`` (dim, W) is what bodies make at the walls' points.
    """

    def velocity(self, induced: Array | None) -> Array:
        """Velocity (dim, M): the flow without bodies, and what walls add to that of bodies."""

    def reflected(self, induced: Array) -> Array:
        """What walls add alone."""


@dataclass(frozen=True, eq=False)
class Nearest:
    """The boundary as seen from M points: ``distance`` (M,), negative outside the fluid and inf
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
        """Relative error of what walls add, beyond round-off and that of their points."""

    @property
    def walls(self) -> Array | None:
        """Points (dim, W) at which walls must know what bodies make, if there are walls."""

    def at(self, points: Array) -> Incident:
        """The flow at points (dim, M)."""

    def nearest(self, points: Array, reach: float) -> Nearest:
        """The boundary near points (dim, M), as far as a ``reach``."""
