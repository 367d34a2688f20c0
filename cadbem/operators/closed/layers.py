"""Single and double layer of a closed spline at its own collocation points.

All nodes are fixed in the parameters (``quadrature/closed.py``), so what depends on parameters
alone is computed once: a step evaluates splines and sums.  Fields that the nodes near a target
need are interpolated by splines on the grid, which is finer than the collocation points.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np

from cadbem.closed_points import ClosedGrid, ClosedPoints, collocation_grid
from cadbem.kernels.kernel import Sums
from cadbem.kernels.stokes_sums import stokes_sums
from cadbem.operators.closed.gather import NearTable
from cadbem.operators.parallel import in_shares
from cadbem.quadrature.closed import (
    ClosedRule,
    NearNodes,
    PolarRule,
    SelfRule,
    SingularitySubtraction,
    closed_rule,
)
from cadbem.spline.basis import Array
from cadbem.spline.closed import ClosedBasis, ClosedSpline
from cadbem.spline.uniform import window

THREADS_FROM = 400  # points from which threads are worth starting


@dataclass(frozen=True, eq=False)
class ClosedOperator:
    """The data that all splines on one basis share: grids, nodes and tables."""

    basis: ClosedBasis
    rule: SelfRule = PolarRule()

    @cached_property
    def nodes(self) -> ClosedRule:
        """The quadrature rule on the unit circle or sphere."""
        return closed_rule(self.rule, self.basis.shape)

    @cached_property
    def weights(self) -> Array:
        """Weights (nodes,) of the grid for the unit circle or sphere."""
        return self.nodes.weights.ravel()

    @cached_property
    def grid(self) -> ClosedGrid:
        """The grid of quadrature nodes."""
        return ClosedGrid(self.basis, self.nodes.axes)

    @property
    def collocation(self) -> ClosedGrid:
        """The grid of collocation points, which are the targets."""
        return collocation_grid(self.basis)

    @cached_property
    def fine(self) -> ClosedBasis:
        """Splines whose collocation points are the quadrature nodes."""
        return ClosedBasis(self.basis.degree, tuple(len(axis) for axis in self.nodes.axes))

    @property
    def factor(self) -> int:
        """Grid columns from one target of a row to the next."""
        return self.fine.shape[-1] // self.basis.shape[-1]

    @cached_property
    def tables(self) -> list[NearTable]:
        """One table for each row of targets."""
        if not self.nodes.spacings:
            return []
        firsts = self.basis.parameters()[:, :: self.basis.shape[-1]]
        return [self.table(self.nodes.near(first)) for first in firsts.T]

    def table(self, near: NearNodes) -> NearTable:
        """Splines' values at nodes near a target."""
        degree, count = self.basis.degree, len(near.weights)
        first, values = window(degree, self.fine.shape[-1], 2 * np.pi, near.parameters[-1])
        rows, row_values = np.zeros(count, dtype=np.int64), np.ones((1, count))
        if self.basis.dimension == 3:
            rows, row_values = window(degree, self.fine.shape[0], np.pi, near.parameters[0])
            rows = rows + degree  # the padded array begins that many rows earlier
        first = first % self.fine.shape[-1]
        tail = (near.weights, near.rows, near.columns, near.corrections)
        return NearTable(rows, row_values, first, values, *tail)

    def padded(self, values: Array) -> Array:
        """Spline coefficients through values at the grid's nodes, for ``gather``."""
        return self.residues(self.coefficients(values))

    def coefficients(self, values: Array) -> Array:
        """Spline coefficients (fields, rows, columns) through values (fields, nodes) at the grid's
        nodes, with ``degree`` rows repeated around the poles."""
        basis = self.fine
        full = basis.doubled(basis.interpolate(values.reshape(-1, *basis.shape)))
        if basis.dimension == 2:
            return full[:, None]
        rows = np.arange(-basis.degree, basis.shape[0] + basis.degree) % full.shape[1]
        return full[:, rows]

    def unknowns(self, values: Array) -> Array:
        """These coefficients and the values themselves, (fields, ·)."""
        coefficients = self.coefficients(values).reshape(len(values), -1)
        return np.concatenate([coefficients, values], axis=1)

    def on_rows(self, values: Array) -> Array:
        """Values (fields, nodes) at the grid's nodes, for ``gather``."""
        return self.residues(values.reshape(len(values), -1, self.fine.shape[-1]))

    def residues(self, values: Array) -> Array:
        """Arrays (fields, rows, columns) as (rows, m, ·): see ``gather``."""
        m, columns = self.factor, self.basis.shape[-1]
        split = values.reshape(*values.shape[:2], columns, m)
        places = np.arange(2 * columns + self.basis.degree + 1) % columns
        ordered = split[:, :, places].transpose(1, 3, 2, 0)
        return np.ascontiguousarray(ordered).reshape(*ordered.shape[:2], -1)

    def near(self, values: Array, weighted: bool) -> list[Array]:
        """Fields (fields, K, T) of fields (fields, nodes) at the nodes near the T targets of each
        row; ``weighted`` multiplies them by the nodes' weights."""
        if not self.tables:
            return []
        spline = self.padded(values)
        grid = self.on_rows(values)

        def row(table: NearTable) -> Array:
            return table.fields(spline, grid, len(values), self.basis.shape[-1], weighted)

        return self.by_rows(row, self.tables)

    def by_rows(self, task: Callable, items: Sequence) -> list:
        """Results of a task for each row of targets, on all cores if there are enough rows."""
        if self.basis.count < THREADS_FROM:
            return [task(item) for item in items]
        return in_shares(task, items)


@lru_cache(maxsize=16)
def closed_operator(basis: ClosedBasis, rule: SelfRule) -> ClosedOperator:
    """The operator of a basis and a rule, kept with its tables."""
    return ClosedOperator(basis, rule)


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
        return self.operator.weights * self.points.jacobian

    @cached_property
    def _sums(self) -> Sums:
        return stokes_sums(self.spline.dimension)

    @cached_property
    def _near_position(self) -> list[Array]:
        return self.operator.near(self.points.position, weighted=False)

    @cached_property
    def _near_area(self) -> list[Array]:
        return self.operator.near(self.area, weighted=True)

    @cached_property
    def tables(self) -> tuple[Array, Array]:
        """Positions and area vectors as splines and as values, for ``gather``."""
        values = np.concatenate([self.points.position, self.area])
        return self.operator.padded(values), self.operator.on_rows(values)

    @property
    def free_term(self) -> float:
        """h: half of what ∫ T·n gives inside, 4π or 2π."""
        return self._sums.free_term

    def single(self, density: Array, level: Array) -> Array:
        """∫ G q dS (dim, N) at the collocation points, for q (dim, nodes) at the nodes.

        As ∫ G n dS = 0, a multiple of n may be taken from q.  With singularity subtraction it
        is ``level`` (N,), the normal part of q at the targets; else q's mean normal part.
        """
        if isinstance(self.operator.rule, SingularitySubtraction):
            whole = self._single(density * self.points.jacobian)
            return whole - level * self._single(self.area)
        mean = (density * self.area).sum(axis=0) @ self.operator.weights
        mean /= self.weights.sum()
        return self._single((density - mean * self.points.normal) * self.points.jacobian)

    def _single(self, vector: Array) -> Array:
        source = vector * self.operator.weights
        near = [[part] for part in self.operator.near(vector, weighted=True)]
        return self._total(self._sums.single, self._sums.single_near, [], [source], near)

    def double(self, coefficients: Array) -> Array:
        """∫ u·T·n dS (dim, N), principal values, for u with coefficients (dim, *shape).

        The integral of u - u(x0), and -free_term u(x0).
        """
        nodes = self.operator.grid.values(coefficients)
        own = self.operator.collocation.values(coefficients)
        weighted = self.area * self.operator.weights
        near_density = self.operator.near(nodes, weighted=False)
        near = [list(pair) for pair in zip(self._near_area, near_density, strict=True)]
        functions = self._sums.double, self._sums.double_near
        return self._total(*functions, [own], [weighted, nodes], near) - self._sums.free_term * own

    def _total(
        self,
        far_sum: Callable[..., None],
        near_sum: Callable[..., None],
        at_targets: list[Array],
        at_nodes: list[Array],
        near: list[list[Array]],
    ) -> Array:
        """A sum over the grid's nodes and the nodes near each target: (dim, N)."""
        columns = self.operator.basis.shape[-1]
        sources = [np.ascontiguousarray(a) for a in (self.points.position, *at_nodes)]

        def row(j: int) -> Array:
            part = slice(j * columns, (j + 1) * columns)
            own = [np.ascontiguousarray(a[:, part]) for a in (self.targets.position, *at_targets)]
            out = np.zeros_like(own[0])
            far_sum(*own, *sources, out)
            if near:
                near_sum(*own, self._near_position[j], *near[j], out)
            return out

        rows = range(self.targets.position.shape[1] // columns)
        return np.concatenate(self.operator.by_rows(row, rows), axis=1)
