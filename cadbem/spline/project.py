"""Closest point of a curve or surface to a point in space."""

from __future__ import annotations

from itertools import product

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import least_squares

from cadbem.spline.basis import Array
from cadbem.spline.nurbs import Nurbs


def closest_point(spline: Nurbs, point: ArrayLike) -> tuple[Array, float]:
    """Parameters (p,) of the point of ``spline`` closest to ``point`` (dim,), and the distance.

    Starts from the best of a grid in each Bézier piece, then minimises with bounds.
    """
    target = np.asarray(point, dtype=float)
    samples = [_samples(spline, d) for d in range(len(spline.degrees))]
    grid = np.meshgrid(*samples, indexing="ij")
    distances = np.linalg.norm(
        spline.evaluate(*grid) - target.reshape(-1, *[1] * len(grid)), axis=0
    )
    best = np.unravel_index(int(np.argmin(distances)), distances.shape)
    start = np.array([s[i] for s, i in zip(samples, best, strict=True)])
    low, high = np.transpose(spline.domain)
    fit = least_squares(
        lambda p: spline.evaluate(*p).ravel() - target,
        start,
        jac=lambda p: _jacobian(spline, p),
        bounds=(low, high),
        xtol=1e-15,
        ftol=1e-15,
        gtol=1e-15,
    )
    candidates = [fit.x, *map(np.array, product(*spline.domain)), start]
    gaps = [float(np.linalg.norm(spline.evaluate(*c).ravel() - target)) for c in candidates]
    return candidates[int(np.argmin(gaps))], min(gaps)


def _samples(spline: Nurbs, direction: int) -> Array:
    breaks = spline.breaks(direction)
    inner = np.linspace(0, 1, 2 * spline.degrees[direction] + 3)[:-1]
    points = breaks[:-1, None] + np.diff(breaks)[:, None] * inner
    return np.append(points.ravel(), breaks[-1])


def _jacobian(spline: Nurbs, parameters: Array) -> Array:
    derivatives = spline.derivatives(1, *parameters)
    keys = sorted((k for k in derivatives if sum(k) == 1), reverse=True)
    return np.stack([derivatives[k].ravel() for k in keys], axis=1)
