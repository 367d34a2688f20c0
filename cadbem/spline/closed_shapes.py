"""Spheres, ellipsoids, circles and ellipses as closed splines."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike

from cadbem.spline.basis import Array
from cadbem.spline.closed import ClosedBasis, ClosedSpline, closed_spline
from cadbem.units import check


@lru_cache(maxsize=32)
def round_basis(dimension: int, points: int, degree: int) -> ClosedBasis:
    """A basis of about ``points`` points; on a sphere twice as many around as between poles.

    Kept, as are its tables, which many droplets share."""
    if dimension == 2:
        return ClosedBasis(degree, (points,))
    rows = round(np.sqrt(points / 2))
    return ClosedBasis(degree, (rows, 2 * rows))


def spline_ellipsoid(
    semi_axes: ArrayLike,
    centre: ArrayLike | None = None,
    points: int = 200,
    degree: int = 4,
    pole: int = 2,
) -> ClosedSpline:
    """An ellipsoid along the coordinate axes with its poles on the axis ``pole`` (0, 1 or 2).

    Raises ``UnitsError`` for quantities that are not lengths.
    """
    check("radius or semi-axis", semi_axes, "length")
    check("centre", centre, "length")
    axes = np.asarray(semi_axes, dtype=float)
    middle = np.zeros(len(axes)) if centre is None else np.asarray(centre, dtype=float)
    turn = 2 - pole if len(axes) == 3 else 0

    def shape(unit: Array) -> Array:
        return middle[:, None] + axes[:, None] * np.roll(unit, -turn, axis=0)

    return closed_spline(round_basis(len(axes), points, degree), shape)


def spline_sphere(
    radius: float = 1.0,
    centre: ArrayLike = (0.0, 0.0, 0.0),
    points: int = 200,
    degree: int = 4,
    pole: int = 2,
) -> ClosedSpline:
    """A sphere of about ``points`` collocation points."""
    return spline_ellipsoid((radius,) * 3, centre, points, degree, pole)


def spline_ellipse(
    semi_axes: ArrayLike, centre: ArrayLike = (0.0, 0.0), points: int = 64, degree: int = 4
) -> ClosedSpline:
    """An ellipse along the coordinate axes."""
    return spline_ellipsoid(semi_axes, centre, points, degree)


def spline_circle(
    radius: float = 1.0, centre: ArrayLike = (0.0, 0.0), points: int = 64, degree: int = 4
) -> ClosedSpline:
    """A circle of ``points`` collocation points."""
    return spline_ellipse((radius, radius), centre, points, degree)
