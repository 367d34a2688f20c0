"""Droplets: a closed spline, a viscosity ratio and an interface law."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from cadbem.errors import ShapeError
from cadbem.spline.closed import ClosedSpline
from cadbem.suspension.interface import InterfaceLaw


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
        if not (self.viscosity_ratio > 0 and np.isfinite(self.viscosity_ratio)):
            raise ShapeError(
                f"viscosity_ratio {self.viscosity_ratio}: give inner over outer viscosity, above 0"
            )
        if not np.isfinite(self.shape.coefficients).all():
            raise ShapeError("the droplet's shape has coefficients that are not finite numbers")

    def moved(self, shape: ClosedSpline) -> Droplet:
        """The same droplet with another shape."""
        return replace(self, shape=shape)
