"""NURBS of any number of parameters (curves and surfaces) as values that do not change."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import reduce
from itertools import product

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cadbem.errors import InputError
from cadbem.overviews import nurbs_text
from cadbem.spline.basis import (
    Array,
    basis_functions,
    basis_matrices,
    function_count,
    multiplicities,
    refinement_matrix,
)

GRID = 64  # points from which it is worth while to look whether they form a grid
NEEDLESS = 1e-12  # change of control points, as a share of their size, that is none


@dataclass(frozen=True, eq=False)
class Nurbs:
    """A rational B-spline: one parameter makes a curve, two make a surface.

    ``degrees`` and open ``knots`` one a parameter; Cartesian control ``points``
    (n_1[, n_2], dim) in the model's unit of length; positive ``weights`` (n_1[, n_2]).
    Raises ``InputError`` when the shapes do not fit together.
    """

    degrees: tuple[int, ...]
    knots: tuple[Array, ...]
    points: Array
    weights: Array

    def __post_init__(self) -> None:
        counts = tuple(map(function_count, self.degrees, self.knots))
        if self.points.shape[:-1] != counts or self.weights.shape != counts:
            raise InputError(
                f"knots and degrees ask for {counts} control points; "
                f"points have shape {self.points.shape}, weights {self.weights.shape}"
            )
        if not (self.weights > 0).all() or not np.isfinite(self.weights).all():
            raise InputError("weights must be positive")

    __repr__ = nurbs_text

    @classmethod
    def from_homogeneous(
        cls, degrees: tuple[int, ...], knots: tuple[Array, ...], homogeneous: Array
    ) -> Nurbs:
        """Build from control points (n_1[, n_2], dim + 1) = (w x, w)."""
        weights = homogeneous[..., -1]
        return cls(degrees, knots, homogeneous[..., :-1] / weights[..., None], weights)

    @property
    def homogeneous(self) -> Array:
        """Control points (w x, w): shape (n_1[, n_2], dim + 1)."""
        weights = self.weights[..., None]
        return np.concatenate([self.points * weights, weights], axis=-1)

    @property
    def dimension(self) -> int:
        """Dimension of the space that the spline lies in."""
        return self.points.shape[-1]

    @property
    def domain(self) -> tuple[tuple[float, float], ...]:
        """First and last knot in each parameter."""
        return tuple((float(k[0]), float(k[-1])) for k in self.knots)

    def breaks(self, direction: int) -> Array:
        """Distinct knots in one parameter."""
        return multiplicities(self.knots[direction])[0]

    def evaluate(self, *parameters: ArrayLike) -> Array:
        """Points at the broadcast parameters: shape (dim, *shape)."""
        return self.derivatives(0, *parameters)[(0,) * len(self.degrees)]

    def derivatives(self, order: int, *parameters: ArrayLike) -> dict[tuple[int, ...], Array]:
        """All partial derivatives up to a total ``order`` of at most 2.

        Keys count derivatives by parameter, (1, 0) is the first one in u; values have shape
        (dim, *broadcast shape).  Quotient rule on homogeneous derivatives (NURBS Book, 4.5).
        """
        if order > 2:
            raise InputError("derivatives are available to order 2")
        grids = np.broadcast_arrays(*[np.asarray(p, dtype=float) for p in parameters])
        homogeneous = self._homogeneous_derivatives(order, grids)
        result: dict[tuple[int, ...], Array] = {}
        for key in sorted(homogeneous, key=sum):
            value = homogeneous[key][:-1].copy()
            for lower in product(*[range(k + 1) for k in key]):
                rest = tuple(k - j for k, j in zip(key, lower, strict=True))
                if any(lower):
                    value -= _binomial(key, lower) * homogeneous[lower][-1] * result[rest]
            result[key] = value / homogeneous[(0,) * len(key)][-1]
        return result

    def _homogeneous_derivatives(
        self, order: int, grids: Sequence[Array]
    ) -> dict[tuple[int, ...], Array]:
        shape = grids[0].shape
        if len(grids) == 2 and grids[0].size >= GRID:
            lines = [np.unique(g.ravel(), return_inverse=True) for g in grids]
            if len(lines[0][0]) * len(lines[1][0]) <= 2 * grids[0].size:
                return self._on_lines(order, lines, shape)
        tables = [
            basis_functions(p, k, g, order)
            for p, k, g in zip(self.degrees, self.knots, grids, strict=True)
        ]
        control = self.homogeneous
        keys = [k for k in product(range(order + 1), repeat=len(tables)) if sum(k) <= order]
        sums = {key: np.zeros((control.shape[-1], grids[0].size)) for key in keys}
        for offsets in product(*[range(p + 1) for p in self.degrees]):
            index = tuple(first + o for (first, _), o in zip(tables, offsets, strict=True))
            points = control[index].T
            for key in keys:
                factors = [t[1][k, o] for t, k, o in zip(tables, key, offsets, strict=True)]
                sums[key] += reduce(np.multiply, factors) * points
        return {key: value.reshape(-1, *shape) for key, value in sums.items()}

    def _on_lines(
        self, order: int, lines: list[tuple[Array, NDArray[np.intp]]], shape: tuple[int, ...]
    ) -> dict[tuple[int, ...], Array]:
        """The same where points lie on few parameter lines: matrix products instead of sums."""
        tables = [
            basis_matrices(p, k, values, order)
            for p, k, (values, _) in zip(self.degrees, self.knots, lines, strict=True)
        ]
        control = self.homogeneous
        found: dict[tuple[int, ...], Array] = {}
        for i, j in product(range(order + 1), repeat=2):
            if i + j <= order:
                grid = tables[1][j] @ np.tensordot(tables[0][i], control, axes=1)  # (u, v, dim + 1)
                places = grid[lines[0][1].ravel(), lines[1][1].ravel()]
                found[i, j] = places.T.reshape(-1, *shape)
        return found

    def rebased(self, degrees: Sequence[int], knots: Sequence[Array]) -> Nurbs:
        """The same shape on richer knot vectors (see ``refinement_matrix``)."""
        if tuple(degrees) == self.degrees and all(map(np.array_equal, knots, self.knots)):
            return self
        control = self.homogeneous
        for axis, (p, k) in enumerate(zip(degrees, knots, strict=True)):
            matrix = refinement_matrix(self.degrees[axis], self.knots[axis], p, k)
            control = np.moveaxis(np.tensordot(matrix, control, axes=(1, axis)), 0, axis)
        return Nurbs.from_homogeneous(tuple(degrees), tuple(knots), control)

    def inserted(self, knots: Sequence[ArrayLike]) -> Nurbs:
        """Knots inserted, a sequence for each parameter; the shape stays."""
        richer = [
            np.sort(np.concatenate([k, np.asarray(new, dtype=float).ravel()]))
            for k, new in zip(self.knots, knots, strict=True)
        ]
        return self.rebased(self.degrees, richer)

    def elevated(self, degrees: Sequence[int]) -> Nurbs:
        """Degrees raised to at least ``degrees``; the shape and its continuity stay."""
        target = [max(p, q) for p, q in zip(self.degrees, degrees, strict=True)]
        knots = []
        for p, q, k in zip(self.degrees, target, self.knots, strict=True):
            values, counts = multiplicities(k)
            knots.append(np.repeat(values, counts + q - p))
        return self.rebased(target, knots)

    def without_knots(self) -> Nurbs:
        """The same shape without inner knots, in each direction where it does not need them."""
        control, knots = self.homogeneous, list(self.knots)
        for axis, (p, k) in enumerate(zip(self.degrees, self.knots, strict=True)):
            ends = np.repeat([k[0], k[-1]], p + 1)
            matrix = refinement_matrix(p, ends, p, k)
            flat = np.moveaxis(control, axis, 0).reshape(len(matrix), -1)
            fewer = np.linalg.lstsq(matrix, flat, rcond=None)[0]
            if abs(matrix @ fewer - flat).max() <= NEEDLESS * abs(flat).max():
                shape = np.moveaxis(control, axis, 0).shape[1:]
                knots[axis] = ends
                control = np.moveaxis(np.asarray(fewer).reshape(-1, *shape), 0, axis)
        return Nurbs.from_homogeneous(self.degrees, tuple(knots), control)

    def restricted(self, *bounds: tuple[float, float]) -> Nurbs:
        """The part over a segment or rectangle of parameters, which keep their meaning."""
        return self._cut(bounds)._between_cuts(bounds)

    def _cut(self, places: Sequence[Iterable[float]]) -> Nurbs:
        """With knots so often at places in each direction that the shape falls apart there."""
        parts = zip(self.knots, self.degrees, places, strict=True)
        return self.inserted([_missing(k, p, at) for k, p, at in parts])

    def _between_cuts(self, bounds: Sequence[tuple[float, float]]) -> Nurbs:
        slices, knots = [], []
        for p, k, (low, high) in zip(self.degrees, self.knots, bounds, strict=True):
            start = int(np.searchsorted(k, low, side="right")) - p - 1
            stop = int(np.searchsorted(k, high, side="left"))
            slices.append(slice(max(start, 0), stop))
            inner = k[(k > low) & (k < high)]
            knots.append(np.concatenate([[low] * (p + 1), inner, [high] * (p + 1)]))
        part = tuple(slices)
        return Nurbs(self.degrees, tuple(knots), self.points[part], self.weights[part])

    def bezier_pieces(self) -> list[Nurbs]:
        """One single-span piece for each element, the last parameter running fastest."""
        breaks = [self.breaks(direction) for direction in range(len(self.degrees))]
        cut = self._cut(breaks)
        spans = [zip(ends[:-1], ends[1:], strict=True) for ends in breaks]
        return [cut._between_cuts(box) for box in product(*spans)]

    def swapped(self) -> Nurbs:
        """A surface with its parameters exchanged: the normal changes side."""
        return Nurbs(
            self.degrees[::-1], self.knots[::-1], self.points.swapaxes(0, 1), self.weights.T
        )

    def edges(self) -> list[Nurbs]:
        """The four edges of a surface, clockwise seen from where its normal points; of a curve its
        ends, as curves of degree 0."""
        x, w = self.points, self.weights
        if len(self.degrees) == 1:
            knots = (np.array([0.0, 1.0]),)
            return [Nurbs((0,), knots, x[i : i + 1], w[i : i + 1]) for i in (0, len(x) - 1)]
        (p, q), (u, v) = self.degrees, self.knots
        return [
            Nurbs((p,), (u,), x[:, 0], w[:, 0]).reversed(),
            Nurbs((q,), (v,), x[-1], w[-1]).reversed(),
            Nurbs((p,), (u,), x[:, -1], w[:, -1]),
            Nurbs((q,), (v,), x[0], w[0]),
        ]

    def reversed(self, direction: int = 0) -> Nurbs:
        """One parameter run backwards over the same domain."""
        k = self.knots[direction]
        knots = list(self.knots)
        knots[direction] = (k[0] + k[-1] - k)[::-1]
        return Nurbs(
            self.degrees,
            tuple(knots),
            np.flip(self.points, direction),
            np.flip(self.weights, direction),
        )

    def transformed(self, matrix: ArrayLike, shift: ArrayLike = 0.0) -> Nurbs:
        """Affine image x -> matrix @ x + shift."""
        return replace(self, points=self.points @ np.asarray(matrix).T + np.asarray(shift))


def _binomial(key: tuple[int, ...], lower: tuple[int, ...]) -> int:
    # with total order at most 2 the only coefficient that is not 1 is "2 over 1"
    return 2 if any(k == 2 and j == 1 for k, j in zip(key, lower, strict=True)) else 1


def _missing(knots: Array, degree: int, places: Iterable[float]) -> list[float]:
    """The knots to insert so that each of the given ones has the multiplicity ``degree``."""
    wanted: list[float] = []
    for place in places:
        wanted += [place] * max(0, degree - int((knots == place).sum()))
    return wanted
