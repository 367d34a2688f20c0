"""Bodies in unbounded fluid."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cadbem.checks import offers, positive
from cadbem.spline.basis import Array
from cadbem.suspension.surroundings.flows import BackgroundFlow
from cadbem.suspension.surroundings.surroundings import Nearest
from cadbem.units import check


@dataclass(frozen=True, eq=False)
class FreeFlow:
    """Unbounded fluid of a ``viscosity`` that flows like ``background`` far away.

    ``deflated`` False leaves the droplets' equations as they stand, for comparison.
    """

    background: BackgroundFlow
    viscosity: float = 1.0
    deflated: bool = True

    def __post_init__(self) -> None:
        known = ("velocity", "gradient", "pressure")
        offers("background", self.background, known, "a background flow, such as shear()")
        check("viscosity", self.viscosity, "viscosity")
        positive("viscosity", self.viscosity)

    @property
    def accuracy(self) -> float:
        """Zero: the background flow is exact."""
        return 0.0

    @property
    def walls(self) -> None:
        """None, as there are no walls."""
        return None

    def at(self, points: Array) -> _Undisturbed:
        """The flow at points (dim, M)."""
        return _Undisturbed(self.background, points)

    def nearest(self, points: Array, reach: float) -> Nearest:
        """Distances inf, as there is no boundary."""
        count = points.shape[1]
        return Nearest(np.full(count, np.inf), [""] * count, np.zeros(count, dtype=bool))


@dataclass(frozen=True, eq=False)
class _Undisturbed:
    """See ``Incident``."""

    background: BackgroundFlow
    points: Array

    def velocity(self, induced: Array | None) -> Array:
        return self.background.velocity(self.points)

    def reflected(self, induced: Array) -> Array:
        return np.zeros(self.points.shape)
