"""Uniform B-splines on a closed axis."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from cadbem.spline.basis import Array, basis_functions


def window(degree: int, count: int, length: float, t: ArrayLike, order: int = 0):
    """The degree + 1 uniform B-splines around each t on an axis of ``count`` spans.

    Function i is centred at (i + 1/2) length / count.  Returns the first function (m,), not
    wrapped into 0 ... count - 1, and the derivatives of the given order (degree + 1, m).
    """
    step = length / count
    place = np.asarray(t, dtype=float).ravel() / step - 0.5 + 0.5 * (degree + 1)
    span = np.floor(place)
    knots = np.arange(-degree, degree + 2, dtype=float)
    _, values = basis_functions(degree, knots, place - span, order)
    return span.astype(np.int64) - degree, values[order] / step**order


def periodic_matrix(degree: int, count: int, length: float, t: ArrayLike, order: int = 0) -> Array:
    """Derivative of every periodic B-spline of an axis at every t: (m, count)."""
    first, values = window(degree, count, length, t, order)
    matrix = np.zeros((len(first), count))
    for j, value in enumerate(values):
        np.add.at(matrix, (np.arange(len(first)), (first + j) % count), value)
    return matrix
