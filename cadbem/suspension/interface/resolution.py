"""How well the points of a closed interface resolve it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cadbem.operators.closed.layers import ClosedLayers
from cadbem.spline.basis import Array
from cadbem.spline.closed import ClosedSpline
from cadbem.spline.closed_layout import spline_residuals

PEAK = 3.0  # largest error of a spline over its root mean square, about


@dataclass(frozen=True, eq=False)
class Resolution:
    """What the points of an interface miss.

    ``shape`` and ``motion`` (p,) are lengths, for each direction of the parameters: by how much the
    surface's splines are wrong, and how far it moves by what the splines of its velocity miss,
    before such short waves relax.  ``flux`` is the net flux through the interface, which is zero
    in truth, as a share of its area times its root mean square velocity.
    """

    shape: Array
    motion: Array
    flux: float

    @property
    def lengths(self) -> Array:
        """By how much the surface may be displaced (p,), for each direction of the parameters."""
        return np.maximum(self.shape, self.motion)

    @property
    def uncertainty(self) -> float:
        """By how much the surface may be displaced."""
        return float(self.lengths.max())


def shape_uncertainty(spline: ClosedSpline) -> Array:
    """By how much a closed spline may miss the shape that it stands for (p,), a length for each
    direction of the parameters."""
    return PEAK * spline_residuals(spline.basis, spline.coefficients)


def resolution(layers: ClosedLayers, rate: Array, fastest: float) -> Resolution:
    """The resolution of an interface whose coefficients change with a ``rate`` (dim, *shape) and
    whose shortest waves relax at the rate ``fastest``."""
    motion = PEAK * spline_residuals(layers.operator.basis, rate) / fastest
    velocity, weights = layers.operator.grid.values(rate), layers.weights
    flux = abs(float((velocity * layers.area).sum(axis=0) @ layers.operator.weights))
    area = float(weights.sum())
    speed = float(np.sqrt((velocity**2).sum(axis=0) @ weights / area))
    return Resolution(shape_uncertainty(layers.spline), motion, flux / max(area * speed, 1e-300))
