"""Background flows: the velocity of the fluid far away from all bodies.

Each offers the velocity u (dim, N), its gradient (dim, dim, N) with [i, j] = ∂u_i / ∂x_j and the
pressure p (N,) per unit of the outer fluid's viscosity μ, so that its stress is
σ = μ (-p I + ∇u + ∇uᵀ).  In 3D a shear flow has its gradient along z, in 2D along y.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

from cadbem.checks import finite, one_of, positive, shaped, vector
from cadbem.errors import ConditionError
from cadbem.spline.basis import Array

STEP = 6e-6  # of central differences: cube root of the rounding error
ROUNDING = 1e-12  # of divergences, relative to the coefficients


class BackgroundFlow(Protocol):
    """A Stokes flow without singularities."""

    def velocity(self, points: Array) -> Array:
        """Velocity (dim, N) at points (dim, N)."""

    def gradient(self, points: Array) -> Array:
        """∂u_i / ∂x_j (dim, dim, N) at points (dim, N)."""

    def pressure(self, points: Array) -> Array:
        """Pressure over viscosity (N,) at points (dim, N)."""


@dataclass(frozen=True, eq=False)
class PolynomialFlow:
    """u_i = drift_i + rates_ij y_j + bends_ijk y_j y_k with y = x - about.

    Arrays (dim,), (dim, dim), (dim, dim, dim) and (dim,); ``bends`` is symmetric in j and k.
    Stokes' equation fixes the pressure, ∂p / ∂x_i = Δu_i = 2 bends_ijj; it is 0 at ``about``.
    Raises ConditionError for arrays of other shapes, or when the velocity has a divergence.
    """

    drift: Array
    rates: Array
    bends: Array
    about: Array

    def __post_init__(self) -> None:
        dim = len(self.rates)
        shapes = {"drift": 1, "rates": 2, "bends": 3, "about": 1}
        for name, order in shapes.items():
            array = getattr(self, name)
            if array.shape != (dim,) * order or not np.isfinite(array).all():
                raise ConditionError(
                    f"the background flow's {name} must be {(dim,) * order} finite numbers, not "
                    f"{array.tolist()}"
                )
        if not np.array_equal(self.bends, self.bends.swapaxes(1, 2)):
            raise ConditionError("the background flow's bends must be symmetric in j and k")
        self._check_divergence()

    def _check_divergence(self) -> None:
        sources = {"rates": np.trace(self.rates), "bends": np.einsum("iik->k", self.bends)}
        for name, source in sources.items():
            if np.abs(source).max() > ROUNDING * np.abs(getattr(self, name)).max():
                raise ConditionError(
                    f"the background flow's {name} give it the divergence {source.tolist()}: make "
                    "the trace zero, the fluid is incompressible"
                )

    def velocity(self, points: Array) -> Array:
        """Velocity (dim, N) at points (dim, N)."""
        arm = points - self.about[:, None]
        bent = np.einsum("ijk,jn,kn->in", self.bends, arm, arm)
        return self.drift[:, None] + self.rates @ arm + bent

    def gradient(self, points: Array) -> Array:
        """∂u_i / ∂x_j (dim, dim, N) at points (dim, N)."""
        arm = points - self.about[:, None]
        return self.rates[:, :, None] + 2 * np.einsum("ijk,kn->ijn", self.bends, arm)

    def pressure(self, points: Array) -> Array:
        """Pressure over viscosity (N,) at points (dim, N)."""
        return 2 * np.einsum("ijj->i", self.bends) @ (points - self.about[:, None])


def linear_flow(rates: ArrayLike, about: ArrayLike = 0.0, drift: ArrayLike = 0.0) -> PolynomialFlow:
    """u = drift + rates (x - about); rates (dim, dim) without trace."""
    matrix = shaped("rates", rates, None, None)
    dim = one_of("the number of rows of rates", len(matrix), (2, 3))
    shaped("rates", rates, dim, dim)
    start, middle = vector("drift", drift, dim), vector("about", about, dim)
    return PolynomialFlow(start, matrix, np.zeros((dim,) * 3), middle)


def at_rest(dimension: int = 3) -> PolynomialFlow:
    """No flow."""
    one_of("dimension", dimension, (2, 3))
    return linear_flow(np.zeros((dimension, dimension)))


def shear(rate: float = 1.0, dimension: int = 3) -> PolynomialFlow:
    """u_x = rate z in space, rate y in a plane."""
    one_of("dimension", dimension, (2, 3))
    finite("rate", rate)
    rates = np.zeros((dimension, dimension))
    rates[0, -1] = rate
    return linear_flow(rates)


def plane_extension(rate: float = 1.0, dimension: int = 3) -> PolynomialFlow:
    """Stretched along x, squeezed along the last coordinate, each at ``rate``."""
    one_of("dimension", dimension, (2, 3))
    finite("rate", rate)
    rates = np.zeros((dimension, dimension))
    rates[0, 0], rates[-1, -1] = rate, -rate
    return linear_flow(rates)


def uniaxial_extension(rate: float = 1.0) -> PolynomialFlow:
    """Stretched along x at ``rate``, squeezed from all sides at half of it (Eq. 4.8, V / R)."""
    finite("rate", rate)
    return linear_flow(rate * np.diag([1.0, -0.5, -0.5]))


def plane_poiseuille(peak: float, half_width: float, dimension: int = 3) -> PolynomialFlow:
    """u_x = peak (1 - s² / half_width²), s = z in space and y in a plane."""
    one_of("dimension", dimension, (2, 3))
    finite("peak", peak)
    positive("half_width", half_width)
    return _poiseuille(peak, half_width, np.eye(dimension)[-1])


def pipe_poiseuille(peak: float, radius: float) -> PolynomialFlow:
    """u_x = peak (1 - (y² + z²) / radius²)."""
    finite("peak", peak)
    positive("radius", radius)
    return _poiseuille(peak, radius, np.array([0.0, 1.0, 1.0]))


def _poiseuille(peak: float, width: float, across: Array) -> PolynomialFlow:
    dim = len(across)
    drift, bends = np.zeros(dim), np.zeros((dim,) * 3)
    drift[0], bends[0] = peak, np.diag(-peak / width**2 * across)
    return PolynomialFlow(drift, np.zeros((dim, dim)), bends, np.zeros(dim))


@dataclass(frozen=True)
class UserFlow:
    """A flow given as a ``function`` of points (dim, N) -> (dim, N).

    It must satisfy Stokes' equations with pressure 0; nothing checks that.  Gradients are central
    differences.  Raises ConditionError when the function returns anything but as many finite
    vectors as it was given points.
    """

    function: Callable[[Array], Array]

    def velocity(self, points: Array) -> Array:
        """Velocity (dim, N) at points (dim, N)."""
        values = np.asarray(self.function(points))
        if values.shape != points.shape:
            raise ConditionError(
                f"the background flow returned an array {values.shape} for points {points.shape}: "
                "it must return a velocity (dim, N) for points (dim, N)"
            )
        wrong = ~np.isfinite(values).all(axis=0)
        if wrong.any():
            place = ", ".join(f"{x:.3g}" for x in points[:, int(wrong.argmax())])
            raise ConditionError(f"the background flow is not a finite number at ({place})")
        return values

    def gradient(self, points: Array) -> Array:
        """∂u_i / ∂x_j (dim, dim, N) at points (dim, N), to about ten digits."""
        step = STEP * (float(np.ptp(points, axis=1).max()) or 1.0)
        sides = step * np.eye(len(points))[:, :, None]
        columns = [self.velocity(points + s) - self.velocity(points - s) for s in sides]
        return np.stack(columns, axis=1) / (2 * step)

    def pressure(self, points: Array) -> Array:
        """Zero (N,)."""
        return np.zeros(points.shape[1])
