"""Spheres, ellipsoids, circles and ellipses as closed splines."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike

from cadbem.checks import one_of, positive, positive_array, vector, whole
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
    axes = positive_array("semi_axes", semi_axes, None)
    one_of("the number of semi_axes", len(axes), (2, 3))
    one_of("pole", pole, (0, 1, 2))
    whole("points", points)
    whole("degree", degree)
    middle = vector("centre", 0.0 if centre is None else centre, len(axes))
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
    check("radius", radius, "length")
    positive("radius", radius)
    return spline_ellipsoid((radius,) * 3, centre, points, degree, pole)


def spline_ellipse(
    semi_axes: ArrayLike, centre: ArrayLike = (0.0, 0.0), points: int = 64, degree: int = 4
) -> ClosedSpline:
    """An ellipse along the coordinate axes."""
    positive_array("semi_axes", semi_axes, 2)
    return spline_ellipsoid(semi_axes, centre, points, degree)


def spline_circle(
    radius: float = 1.0, centre: ArrayLike = (0.0, 0.0), points: int = 64, degree: int = 4
) -> ClosedSpline:
    """A circle of ``points`` collocation points."""
    check("radius", radius, "length")
    positive("radius", radius)
    return spline_ellipse((radius, radius), centre, points, degree)
