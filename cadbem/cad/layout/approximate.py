"""Splines that approximate a map of the unit square within a tolerance."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

import numpy as np

from cadbem.spline.basis import Array, basis_matrix, greville
from cadbem.spline.nurbs import Nurbs

# degree and number of spans, by the number of coefficients that they need
LEVELS = ((1, 1), (2, 1), (3, 1), (4, 1), (5, 1), (6, 1), (6, 2), (6, 3), (6, 4))
CHECKS = 4  # points between interpolation points at which the deviation is measured
HALVINGS = 5

Map = Callable[[Array, Array], Array]  # (n,), (n,) -> (3, n)
Box = tuple[float, float, float, float]  # ends in ξ, ends in η


def approximated(
    surface: Map, tolerance: float, box: Box = (0, 1, 0, 1)
) -> list[tuple[Nurbs, float]]:
    """Polynomial spline patches over a rectangle of the map, each with its largest deviation from
    it, measured at points of equal parameters.

    One patch, if one of at most four spans is within the tolerance; else the rectangle is halved
    where its lines are not, at most `HALVINGS` times: deviations may then exceed the tolerance.
    """
    return _approximated(surface, tolerance, box, HALVINGS)


def _approximated(
    surface: Map, tolerance: float, box: Box, halvings: int
) -> list[tuple[Nurbs, float]]:
    left, right, low, high = box

    def part(xi: Array, eta: Array) -> Array:
        return surface(left + (right - left) * xi, low + (high - low) * eta)

    level = [_level(part, direction, 0.5 * tolerance) for direction in (0, 1)]
    while max(level) < len(LEVELS) or halvings == 0:
        first, second = (LEVELS[min(k, len(LEVELS) - 1)] for k in level)
        patch = _interpolated(part, first, second)
        deviation = _deviation(part, patch)
        if deviation <= tolerance or halvings == 0:
            return [(patch, deviation)]
        level = [k + 1 for k in level]
    halves = _halved(box, 0 if level[0] >= level[1] else 1)
    return [
        piece for half in halves for piece in _approximated(surface, tolerance, half, halvings - 1)
    ]


def _halved(box: Box, direction: int) -> tuple[Box, Box]:
    left, right, low, high = box
    if direction == 0:
        middle = 0.5 * (left + right)
        return (left, middle, low, high), (middle, right, low, high)
    middle = 0.5 * (low + high)
    return (left, right, low, middle), (left, right, middle, high)


def _level(surface: Map, direction: int, tolerance: float) -> int:
    """First level at which five lines along a direction are within the tolerance; the number of
    levels if none is."""
    across = np.linspace(0, 1, 5)
    for level, (degree, spans) in enumerate(LEVELS):
        nodes, inverse = _nodes(degree, spans)
        checks = _checks(nodes)
        values = _grid(surface, direction, np.concatenate([nodes, checks]), across)
        control = np.einsum("ij,djk->dik", inverse, values[:, : len(nodes)])
        there = np.einsum("ij,djk->dik", _matrix(degree, spans, checks), control)
        if np.abs(there - values[:, len(nodes) :]).max() <= tolerance:
            return level
    return len(LEVELS)


def _interpolated(surface: Map, first: tuple[int, int], second: tuple[int, int]) -> Nurbs:
    (u, from_u), (v, from_v) = _nodes(*first), _nodes(*second)
    values = _grid(surface, 0, u, v)
    points = np.einsum("ik,jl,dkl->ijd", from_u, from_v, values)
    knots = _knots(*first), _knots(*second)
    return Nurbs((first[0], second[0]), knots, points, np.ones(points.shape[:2]))


def _deviation(surface: Map, patch: Nurbs) -> float:
    u, v = (
        _checks(_nodes(degree, len(knots) - 2 * degree - 1)[0])
        for degree, knots in zip(patch.degrees, patch.knots, strict=True)
    )
    gap = patch.evaluate(*np.meshgrid(u, v, indexing="ij")) - _grid(surface, 0, u, v)
    return float(np.linalg.norm(gap, axis=0).max())


def _grid(surface: Map, direction: int, along: Array, across: Array) -> Array:
    """Values (3, n, m) at n places along a direction and m across it."""
    first, second = np.meshgrid(along, across, indexing="ij")
    pair = (first, second) if direction == 0 else (second, first)
    return surface(pair[0].ravel(), pair[1].ravel()).reshape(3, len(along), len(across))


def _checks(nodes: Array) -> Array:
    """Both ends, and points between the nodes."""
    shares = (np.arange(CHECKS) + 0.5) / CHECKS
    inner = (nodes[:-1, None] + np.diff(nodes)[:, None] * shares).ravel()
    return np.concatenate([[0.0], inner, [1.0]])


def _knots(degree: int, spans: int) -> Array:
    ends = np.zeros(degree), np.ones(degree)
    return np.concatenate([ends[0], np.linspace(0, 1, spans + 1), ends[1]])


@cache
def _nodes(degree: int, spans: int) -> tuple[Array, Array]:
    """Interpolation points, and the inverse of the spline's values there: Chebyshev-Lobatto
    points for one span, averages of knots for several."""
    nodes: Array = greville(degree, _knots(degree, spans))
    if spans == 1:
        nodes = 0.5 - 0.5 * np.cos(np.pi * np.arange(degree + 1) / degree)
    inverse = np.asarray(np.linalg.inv(_matrix(degree, spans, nodes)), dtype=np.float64)
    return nodes, inverse


def _matrix(degree: int, spans: int, at: Array) -> Array:
    """Values (len(at), n) of the basis functions."""
    return basis_matrix(degree, _knots(degree, spans), at)
