"""B-spline bases in one parameter: knot vectors, functions, derivatives, change of basis.

A knot vector of degree p is open (clamped): its first and last knots stand p + 1 times, and
n = len(knots) - p - 1 functions live on it.  Sources: Piegl and Tiller, *The NURBS Book*
(recursions); Ramshaw, *Blossoms are polar forms* (knot insertion and degree elevation).
"""

from __future__ import annotations

from collections.abc import Sequence
from math import comb

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]


def open_knots(
    degree: int, breaks: Sequence[float] | Array, continuity: int | None = None
) -> Array:
    """Open knot vector through increasing ``breaks``, C^continuity inside (default degree - 1)."""
    inner = degree - (degree - 1 if continuity is None else continuity)
    breaks = np.asarray(breaks, dtype=float)
    multiplicities = np.full(len(breaks), inner)
    multiplicities[[0, -1]] = degree + 1
    return np.repeat(breaks, multiplicities)


def function_count(degree: int, knots: Array) -> int:
    """Number of B-splines on the knot vector."""
    return len(knots) - degree - 1


def multiplicities(knots: Array) -> tuple[Array, NDArray[np.int64]]:
    """Distinct knots, which rise, and how often each stands."""
    first = np.flatnonzero(np.append(True, knots[1:] != knots[:-1]))
    return knots[first], np.diff(np.append(first, len(knots)))


def greville(degree: int, knots: Array) -> Array:
    """Greville abscissae, the means of ``degree`` consecutive inner knots: shape (n,)."""
    count = function_count(degree, knots)
    return np.array([knots[i + 1 : i + degree + 1].mean() for i in range(count)])


def find_spans(degree: int, knots: Array, u: ArrayLike) -> NDArray[np.int64]:
    """Index s of the non-empty span with knots[s] <= u < knots[s + 1]; the last one is closed."""
    last = function_count(degree, knots)
    spans = np.searchsorted(knots, u, side="right") - 1
    top = int(np.searchsorted(knots, knots[last], side="left")) - 1
    return np.clip(spans, degree, top)


def basis_functions(
    degree: int, knots: Array, u: ArrayLike, order: int = 0
) -> tuple[NDArray[np.int64], Array]:
    """The degree + 1 B-splines that do not vanish at each u, and their derivatives.

    Returns ``first`` (m,), the index of the first such function, and ``values``
    (order + 1, degree + 1, m), the derivatives of order 0 ... order (NURBS Book, eq. 2.5, 2.7).
    """
    u = np.asarray(u, dtype=float).ravel()
    spans = find_spans(degree, knots, u)
    values = np.zeros((order + 1, degree + 1, len(u)))
    for k in range(min(order, degree) + 1):
        functions = _values(degree - k, knots, spans, u)
        for q in range(degree - k + 1, degree + 1):
            functions = _differentiate(q, knots, spans, functions)
        values[k] = functions
    return spans - degree, values


def basis_matrices(degree: int, knots: Array, u: ArrayLike, order: int = 0) -> Array:
    """Every function and its derivatives at every u: shape (order + 1, m, n)."""
    first, values = basis_functions(degree, knots, u, order)
    matrices = np.zeros((order + 1, len(first), function_count(degree, knots)))
    rows = np.arange(len(first))
    for offset in range(degree + 1):
        matrices[:, rows, first + offset] = values[:, offset]
    return matrices


def _values(degree: int, knots: Array, spans: NDArray[np.int64], u: Array) -> Array:
    functions = np.ones((1, len(u)))
    for q in range(1, degree + 1):
        raised = np.zeros((q + 1, len(u)))
        for j in range(q):
            left, right = knots[spans - q + 1 + j], knots[spans + 1 + j]
            ratio = functions[j] / (right - left)
            raised[j] += (right - u) * ratio
            raised[j + 1] += (u - left) * ratio
        functions = raised
    return functions


def _differentiate(degree: int, knots: Array, spans: NDArray[np.int64], lower: Array) -> Array:
    raised = np.zeros((degree + 1, lower.shape[1]))
    for j in range(degree):
        ratio = degree * lower[j] / (knots[spans + 1 + j] - knots[spans - degree + 1 + j])
        raised[j] -= ratio
        raised[j + 1] += ratio
    return raised


def basis_matrix(degree: int, knots: Array, u: ArrayLike, order: int = 0) -> Array:
    """Derivative of the given order of every function at every u: shape (m, n)."""
    return basis_matrices(degree, knots, u, order)[order]


def bernstein(degree: int, t: ArrayLike) -> Array:
    """Bernstein polynomials on [0, 1]: shape (degree + 1, m)."""
    t = np.asarray(t, dtype=float).ravel()
    return np.array([comb(degree, j) * t**j * (1 - t) ** (degree - j) for j in range(degree + 1)])


def refinement_matrix(degree: int, knots: Array, new_degree: int, new_knots: Array) -> Array:
    """Matrix M (n_new, n) with which coefficients c on ``knots`` become M @ c on ``new_knots``.

    The new space must contain the old one: every old knot stands in ``new_knots`` at least as
    often, plus new_degree - degree times.  A coefficient of a spline is the blossom of any of
    its pieces inside the function's support, at the function's inner knots; raising the degree
    by one averages the blossoms that leave one argument out.
    """
    matrix = np.eye(function_count(degree, knots))
    while degree < new_degree:
        values, counts = multiplicities(knots)
        raised = np.repeat(values, counts + 1)
        matrix = _blossom_step(degree, knots, degree + 1, raised) @ matrix
        degree, knots = degree + 1, raised
    if len(new_knots) == len(knots) and np.array_equal(new_knots, knots):
        return matrix
    return _blossom_step(degree, knots, degree, np.asarray(new_knots, dtype=float)) @ matrix


def _blossom_step(degree: int, knots: Array, new_degree: int, new_knots: Array) -> Array:
    count = function_count(new_degree, new_knots)
    inner = np.array([new_knots[i + 1 : i + new_degree + 1] for i in range(count)])
    spans = _nearest_spans(degree, knots, new_degree, new_knots)
    if new_degree == degree:
        return _blossoms(degree, knots, spans, inner)
    left_out = [np.delete(inner, j, axis=1) for j in range(new_degree)]
    blossoms = [_blossoms(degree, knots, spans, arguments) for arguments in left_out]
    return np.mean(blossoms, axis=0)


def _nearest_spans(
    degree: int, knots: Array, new_degree: int, new_knots: Array
) -> NDArray[np.int64]:
    """For each new function, the old span that needs the least extrapolation."""
    count = function_count(new_degree, new_knots)
    middles = np.empty(count)
    for i in range(count):
        support = new_knots[i : i + new_degree + 2]
        centres, lengths = 0.5 * (support[1:] + support[:-1]), np.diff(support)
        centres, lengths = centres[lengths > 0], lengths[lengths > 0]
        reach = np.abs(support[1:-1, None] - centres).max(axis=0)
        middles[i] = centres[np.argmin(reach / lengths)]
    return find_spans(degree, knots, middles)


def _blossoms(degree: int, knots: Array, spans: NDArray[np.int64], arguments: Array) -> Array:
    """Rows of the blossoms at ``arguments`` (m, degree) of the pieces on ``spans`` (m,)."""
    rows = np.arange(len(spans))
    local = np.tile(np.eye(degree + 1), (len(spans), 1, 1))  # local[m, j] : de Boor point j
    for r in range(1, degree + 1):
        argument = arguments[:, r - 1]
        for j in range(degree, r - 1, -1):
            left, right = knots[spans - degree + j], knots[spans + 1 + j - r]
            share = ((argument - left) / (right - left))[:, None]
            local[:, j] = (1 - share) * local[:, j - 1] + share * local[:, j]
    matrix = np.zeros((len(spans), function_count(degree, knots)))
    for j in range(degree + 1):
        matrix[rows, spans - degree + j] = local[:, degree, j]
    return matrix
