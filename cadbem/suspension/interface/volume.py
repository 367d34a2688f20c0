"""The volume of closed splines (their area in 2D), exactly, and its correction (Eq. 3.13, 4.5).

V = (1/dim) ∫ x · (x_θ × x_φ) is a polynomial of the coefficients, which Gauss rules integrate
without error.  Its gradient with respect to a coefficient is ∫ N_i (x_θ × x_φ).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from cadbem.checks import within
from cadbem.closed_points import ClosedGrid
from cadbem.errors import ShapeError
from cadbem.points import area_vector
from cadbem.quadrature.gauss import gauss_on_breaks, tensor_rule
from cadbem.spline.basis import Array
from cadbem.spline.closed import ClosedBasis, ClosedSpline

ITERATIONS = 50


@lru_cache(maxsize=16)
def exact_grid(basis: ClosedBasis) -> tuple[ClosedGrid, Array]:
    """Grid and weights (N,) per unit of parameters, exact for products of three splines."""
    order = (3 * basis.degree + 1) // 2
    rules = [gauss_on_breaks(order, breaks) for breaks in basis.breaks()]
    return ClosedGrid(basis, [nodes for nodes, _ in rules]), tensor_rule(rules)[1]


def _area_vectors(spline: ClosedSpline) -> tuple[ClosedGrid, Array, Array]:
    """Grid, positions (dim, N), and area vectors with the weights in them (dim, N)."""
    grid, weights = exact_grid(spline.basis)
    area = area_vector(*grid.first(spline.coefficients))
    return grid, grid.values(spline.coefficients), area * weights


def volume(spline: ClosedSpline) -> float:
    """Enclosed volume, or area in 2D; taken about the surface's own middle, for accuracy."""
    _, position, area = _area_vectors(spline)
    arm = position - position.mean(axis=1)[:, None]
    return float((arm * area).sum()) / spline.dimension


def centre(spline: ClosedSpline) -> Array:
    """Centre of the enclosed volume (dim,): ∫ x dV = ∫ (x·x) n dS / 2."""
    _, position, area = _area_vectors(spline)
    middle = position.mean(axis=1)
    arm = position - middle[:, None]
    inside = float((arm * area).sum()) / spline.dimension
    return middle + 0.5 * ((arm**2).sum(axis=0) * area).sum(axis=1) / inside


def volume_gradient(spline: ClosedSpline) -> Array:
    """Derivatives (dim, *shape) of the volume with respect to the coefficients, taken along
    surfaces that stay smooth at the poles."""
    grid, _, area = _area_vectors(spline)
    return spline.basis.smoothed(grid.transposed(area))


def nearest_with_volume(spline: ClosedSpline, target: float) -> ClosedSpline:
    """The coefficients nearest to a spline's that enclose the volume ``target``: Newton's method.

    Raises ShapeError when no nearby surface has the volume.
    """
    start, result, amount = spline.coefficients, spline, 0.0
    for _ in range(ITERATIONS):
        gradient = volume_gradient(result)
        slope = float((gradient * gradient).sum())
        # Newton's step for m, then the gradient where it ends
        change = (target - volume(result)) / slope
        amount += change
        result = replace(spline, coefficients=start + amount * gradient)
        if abs(volume(result) / target - 1) < 2e-15 or abs(change) < 1e-17 * abs(amount):
            return result
        if not np.isfinite(result.coefficients).all():
            break
    # coordinates far from the origin are rounded more coarsely than the droplet's size asks for
    size = float(np.abs(start).max()) / target ** (1 / spline.dimension)
    if abs(volume(result) / target - 1) < 1e-12 * max(1.0, size):
        return result
    raise ShapeError(
        f"no shape near the droplet's has the volume {target:.6g} instead of "
        f"{volume(spline):.6g}: take smaller time steps or more points"
    )


def nearest_by_sqp(spline: ClosedSpline, target: float) -> ClosedSpline:
    """The thesis's way to the same: sequential quadratic programming; slow, for comparison.

    Works on the coefficients that are free when the surface is smooth at the poles.
    """
    from scipy.optimize import minimize

    start = spline.coefficients

    def moved(x: Array) -> ClosedSpline:
        step = spline.basis.smoothed(x.reshape(start.shape))
        return replace(spline, coefficients=start + step)

    result = minimize(
        lambda x: (float(x @ x), 2 * x), np.zeros(start.size), jac=True, method="SLSQP",
        constraints={
            "type": "eq",
            "fun": lambda x: volume(moved(x)) - target,
            "jac": lambda x: volume_gradient(moved(x)).ravel(),
        },
        options={"ftol": 1e-16, "maxiter": ITERATIONS},
    )  # fmt: skip
    return moved(result.x)


@dataclass(frozen=True)
class CorrectVolume:
    """Keep the volume: the nearest coefficients, Σ |X_i - P_i|² smallest, with the right volume.

    It acts when the volume is wrong by more than the share ``trigger``; the thesis has 1e-3.
    The default corrects after every step, to machine precision.  ``nearest`` finds the
    coefficients: one constraint makes X = P + m dV/dX(X) with a single unknown m; the thesis's
    ``nearest_by_sqp`` does the same slowly.
    """

    trigger: float = 0.0
    nearest: Callable[[ClosedSpline, float], ClosedSpline] = nearest_with_volume

    def __post_init__(self) -> None:
        within("CorrectVolume's trigger", self.trigger, 0.0, 1.0)

    def apply(self, spline: ClosedSpline, target: float) -> ClosedSpline:
        """The corrected spline, or the same one.

        Raises ShapeError when no nearby surface has the volume.
        """
        if abs(volume(spline) / target - 1) <= self.trigger:
            return spline
        return self.nearest(spline, target)
