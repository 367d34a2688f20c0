"""Single and double layer of a closed spline at its own collocation points.

All nodes are fixed in the parameters (``quadrature/closed.py``), so what depends on parameters
alone is computed once: a step evaluates splines and sums.  Fields that the nodes near a target
need are interpolated by splines on the grid, which is finer than the collocation points.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numba import njit

from cadbem.closed_points import ClosedGrid, ClosedPoints
from cadbem.kernels.kernel import Index
from cadbem.kernels.stokes_sums import StokesSums, stokes_sums
from cadbem.quadrature.closed import (
    ClosedRule,
    NearNodes,
    PolarRule,
    SelfRule,
    SingularitySubtraction,
    closed_rule,
)
from cadbem.spline.basis import Array
from cadbem.spline.closed import ClosedBasis, ClosedSpline, window


@njit(cache=True, nogil=True, fastmath=True)
def _gather(spline, row_first, row_values, column_first, column_values, weights,
            grid, grid_rows, grid_columns, corrections, shifts, out):  # fmt: skip
    """Weighted fields at the nodes near each target of a row: out (fields, T (K + K')).

    ``spline`` (rows, columns, fields) are coefficients with enough rows and columns repeated
    around them, ``grid`` (rows, columns, fields) values at the grid's nodes.
    """
    fields = spline.shape[2]
    near, extra = len(weights), len(corrections)
    period = grid.shape[1]
    degree = column_values.shape[0] - 1
    width = (degree + 1) * fields
    flat = spline.reshape(spline.shape[0], -1)
    band = np.empty(width)
    for t in range(len(shifts)):
        base = t * (near + extra)
        for k in range(near):
            start = ((column_first[k] + shifts[t]) % period) * fields
            band[:] = 0.0
            for a in range(row_values.shape[0]):
                row = flat[row_first[k] + a, start : start + width]
                factor = row_values[a, k]
                for m in range(width):
                    band[m] += factor * row[m]
            for f in range(fields):
                total = 0.0
                for b in range(degree + 1):
                    total += column_values[b, k] * band[b * fields + f]
                out[f, base + k] = total * weights[k]
        for k in range(extra):
            column = (grid_columns[k] + shifts[t]) % period
            for f in range(fields):
                out[f, base + near + k] = grid[grid_rows[k], column, f] * corrections[k]


@dataclass(frozen=True, eq=False)
class _NearTable:
    """Splines' values at the polar nodes of one row of targets, and the grid nodes to mend."""

    row_first: Index
    row_values: Array
    column_first: Index
    column_values: Array
    weights: Array
    grid_rows: Index
    grid_columns: Index
    corrections: Array

    @property
    def count(self) -> int:
        """Nodes a target."""
        return len(self.weights) + len(self.corrections)


@dataclass(frozen=True, eq=False)
class ClosedOperator:
    """What the layers of every spline on one basis share: grids, nodes and tables."""

    basis: ClosedBasis
    rule: SelfRule = PolarRule()

    @cached_property
    def nodes(self) -> ClosedRule:
        """The quadrature rule on the unit circle or sphere."""
        return closed_rule(self.rule, self.basis.shape)

    @cached_property
    def grid(self) -> ClosedGrid:
        """The grid of quadrature nodes."""
        return ClosedGrid(self.basis, self.nodes.axes)

    @cached_property
    def collocation(self) -> ClosedGrid:
        """The grid of collocation points, which are the targets."""
        return ClosedGrid(self.basis, self.basis.axes())

    @cached_property
    def fine(self) -> ClosedBasis:
        """Splines whose collocation points are the quadrature nodes."""
        return ClosedBasis(self.basis.degree, tuple(len(axis) for axis in self.nodes.axes))

    @cached_property
    def shifts(self) -> Index:
        """How many grid columns each target lies behind the first one of its row."""
        factor = self.fine.shape[-1] // self.basis.shape[-1]
        return factor * np.arange(self.basis.shape[-1], dtype=np.int64)

    @cached_property
    def tables(self) -> list[_NearTable]:
        """One table for each row of targets."""
        return [self._table(near) for near in self.nodes.near]

    def _table(self, near: NearNodes) -> _NearTable:
        degree, count = self.basis.degree, len(near.weights)
        first, values = window(degree, self.fine.shape[-1], 2 * np.pi, near.parameters[-1])
        rows, row_values = np.zeros(count, dtype=np.int64), np.ones((1, count))
        if self.basis.dimension == 3:
            rows, row_values = window(degree, self.fine.shape[0], np.pi, near.parameters[0])
            rows = rows + degree  # the padded array begins that many rows earlier
        tail = (near.weights, near.rows, near.columns, near.corrections)
        return _NearTable(rows, row_values, first, values, *tail)

    def padded(self, values: Array) -> Array:
        """Spline coefficients (rows, columns, fields) through values at the grid's nodes, with
        ``degree`` rows repeated around the poles and as many columns past the last."""
        basis = self.fine
        full = basis.doubled(basis.interpolate(values.reshape(-1, *basis.shape)))
        if basis.dimension == 2:
            full = full[:, None]
            rows = np.zeros(1, dtype=int)
        else:
            rows = np.arange(-basis.degree, basis.shape[0] + basis.degree) % full.shape[1]
        columns = np.arange(basis.shape[-1] + basis.degree) % basis.shape[-1]
        return np.ascontiguousarray(np.moveaxis(full[:, rows[:, None], columns], 0, -1))

    def on_nodes(self, values: Array) -> Array:
        """Values (fields, nodes) as an array (rows, columns, fields)."""
        shaped = values.reshape(len(values), -1, self.fine.shape[-1])
        return np.ascontiguousarray(np.moveaxis(shaped, 0, -1))

    def near(self, values: Array, weighted: bool) -> list[Array]:
        """Fields (fields, nodes) at the near nodes of all targets, row by row of targets.

        ``weighted`` multiplies them by the nodes' weights.
        """
        spline, grid = self.padded(values), self.on_nodes(values)

        def row(table: _NearTable) -> Array:
            out = np.empty((len(values), len(self.shifts) * table.count))
            weights, corrections = table.weights, table.corrections
            if not weighted:
                weights, corrections = np.ones_like(weights), np.ones_like(corrections)
            _gather(
                spline, table.row_first, table.row_values, table.column_first,
                table.column_values, weights, grid, table.grid_rows, table.grid_columns,
                corrections, self.shifts, out,
            )  # fmt: skip
            return out

        return in_threads(row, self.tables)


def in_threads(task, items: list) -> list:
    """Results of a task for each item, on all cores."""
    if len(items) < 2:
        return [task(item) for item in items]
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        return list(pool.map(task, items))


@dataclass(frozen=True, eq=False)
class ClosedLayers:
    """Single and double layer of one closed spline at its collocation points, n outwards."""

    operator: ClosedOperator
    spline: ClosedSpline

    @cached_property
    def points(self) -> ClosedPoints:
        """Quadrature points."""
        return self.operator.grid.points(self.spline)

    @cached_property
    def targets(self) -> ClosedPoints:
        """Collocation points."""
        return self.operator.collocation.points(self.spline)

    @cached_property
    def area(self) -> Array:
        """Area vectors n J (dim, nodes) per unit of the unit circle or sphere."""
        return self.points.normal * self.points.jacobian

    @property
    def weights(self) -> Array:
        """Weights (nodes,) that integrate over the curve or surface."""
        return self.operator.nodes.weights * self.points.jacobian

    @cached_property
    def _sums(self) -> StokesSums:
        return stokes_sums(self.spline.dimension)

    @cached_property
    def _near_position(self) -> list[Array]:
        return self.operator.near(self.points.position, weighted=False)

    @cached_property
    def _near_area(self) -> list[Array]:
        return self.operator.near(self.area, weighted=True)

    def single(self, density: Array, level: Array) -> Array:
        """∫ G q dS (dim, N) at the collocation points, for q (dim, nodes) at the nodes.

        As ∫ G n dS = 0, a multiple of n may be taken from q.  With singularity subtraction it
        is ``level`` (N,), the normal part of q at the targets; else q's mean normal part.
        """
        if isinstance(self.operator.rule, SingularitySubtraction):
            whole = self._single(density * self.points.jacobian)
            return whole - level * self._single(self.area)
        mean = (density * self.area).sum(axis=0) @ self.operator.nodes.weights
        mean /= self.weights.sum()
        return self._single((density - mean * self.points.normal) * self.points.jacobian)

    def _single(self, vector: Array) -> Array:
        source = vector * self.operator.nodes.weights
        near = [[part] for part in self.operator.near(vector, weighted=True)]
        return self._total(self._sums.single, [], [source], near)

    def double(self, coefficients: Array) -> Array:
        """∫ u·T·n dS (dim, N), principal values, for u with coefficients (dim, *shape).

        The integral of u - u(x0), and -free_term u(x0).
        """
        nodes = self.operator.grid.values(coefficients)
        own = self.operator.collocation.values(coefficients)
        weighted = self.area * self.operator.nodes.weights
        near_density = self.operator.near(nodes, weighted=False)
        near = [list(pair) for pair in zip(self._near_area, near_density, strict=True)]
        return self._total(self._sums.double, [own], [weighted, nodes], near) - (
            self._sums.free_term * own
        )

    def _total(
        self,
        function: Callable[..., None],
        at_targets: list[Array],
        at_nodes: list[Array],
        near: list[list[Array]],
    ) -> Array:
        """A sum over the grid's nodes and the nodes near each target: (dim, N)."""
        columns = len(self.operator.shifts)
        every = np.full(columns, self.points.position.shape[1])

        def row(j: int) -> Array:
            part = slice(j * columns, (j + 1) * columns)
            own = [np.ascontiguousarray(a[:, part]) for a in (self.targets.position, *at_targets)]
            out = np.zeros_like(own[0])
            function(*own, 0 * every, every, self.points.position, *at_nodes, out)
            if near:
                position = self._near_position[j]
                ends = np.arange(columns + 1) * (position.shape[1] // columns)
                function(*own, ends[:-1], ends[1:], position, *near[j], out)
            return out

        rows = self.targets.position.shape[1] // columns
        return np.concatenate(in_threads(row, list(range(rows))), axis=1)
