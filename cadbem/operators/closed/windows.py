"""Window corrections of the sums over an even grid, for targets near a surface: sparse matrices.

The fields at a window's nodes are linear in a density's spline coefficients and in its values at
the grid's nodes, and so is the value of a layer at the target.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from cadbem.compiled import compiled
from cadbem.kernels.kernel import Index, Layout
from cadbem.kernels.stokes import stokes_kernels
from cadbem.operators.closed.gather import NearTable
from cadbem.operators.closed.layers import ClosedLayers
from cadbem.operators.closed.nearest import Feet, nearest_feet
from cadbem.quadrature.closed import NearNodes
from cadbem.spline.basis import Array

TOGETHER = 64  # targets whose nodes are worked out at once


@dataclass(frozen=True, eq=False)
class Windows:
    """The windows of ``points`` (dim, W) near a surface, for both layers."""

    layers: ClosedLayers
    points: Array

    def apply(self, single: Array | None, double: Array | None) -> Array:
        """The window corrections (dim, W), for densities q J and u (dim, nodes) at the grid's
        nodes, or none."""
        kernel, _ = stokes_kernels(len(self.points))
        out = np.zeros(self.points.shape)
        for layout, density in ((kernel.single, single), (kernel.double, double)):
            if density is not None and out.size:
                unknowns = self.layers.operator.unknowns(density)
                for part in self._parts:
                    part.add_to(layout, unknowns, out)
        return out

    @cached_property
    def _parts(self) -> list[_Rows]:
        """The matrix, some targets at a time."""
        feet = nearest_feet(self.layers.spline, self.points)
        chunks = range(0, self.points.shape[1], TOGETHER)
        return [self._rows(feet, slice(k, k + TOGETHER)) for k in chunks]

    def _rows(self, feet: Feet, part: slice) -> _Rows:
        operator, points = self.layers.operator, self.points[:, part]
        stretch = np.linalg.norm(feet.normal[:, part], axis=0) ** (1 / (len(points) - 1))
        gap = np.linalg.norm(points - feet.position[:, part], axis=0)
        angles = np.maximum(gap / stretch, 1e-12)
        nodes = [
            operator.nodes.near(*pair)
            for pair in zip(feet.parameters[:, part].T, angles, strict=True)
        ]
        table = operator.table(_joined(nodes))
        inner = _starts([len(n.weights) for n in nodes])
        outer = _starts([len(n.corrections) for n in nodes])
        entries = self._entries(points, table, inner, outer)
        columns, count = operator.fine.shape[-1], operator.fine.count
        padded = count + (len(points) - 2) * 2 * operator.basis.degree * columns
        grid = padded + table.grid_rows * columns + table.grid_columns
        counts, indices, values = _spread(
            table.row_first, table.row_values, table.column_first, table.column_values, columns,
            inner, grid, outer, entries, padded + count,
        )  # fmt: skip
        return _Rows(part.start, np.concatenate([[0], np.cumsum(counts)]), indices, values)

    def _entries(self, points: Array, table: NearTable, inner: Index, outer: Index) -> Array:
        """The kernel's entries (entries, K + K') at all nodes, with their weights."""
        dim, kernel = len(points), stokes_kernels(len(points))[0]
        fields = table.fields(*self.layers.tables, 2 * dim, targets=1, weighted=False)[..., 0]
        targets, found = np.ascontiguousarray(points), []
        for part, starts in zip(np.split(fields, [inner[-1]], axis=1), (inner, outer), strict=True):
            position, area = np.ascontiguousarray(part).reshape(2, dim, -1)
            found.append(kernel.rows_of(targets, starts, position, area))
        return np.concatenate(found, axis=1) * np.concatenate([table.weights, table.corrections])


@dataclass(frozen=True, eq=False)
class _Rows:
    """Rows of a sparse matrix for each entry of the kernel: row t, of the target ``first`` + t, has
    ``values`` (entries, ·) from starts[t] to starts[t + 1] - 1 at ``indices`` of the unknowns."""

    first: int
    starts: Index
    indices: Index
    values: Array

    def add_to(self, layout: Layout, unknowns: Array, out: Array) -> None:
        """Add what unknowns (dim, ·) make to ``out`` (dim, W)."""
        part = out[:, self.first : self.first + len(self.starts) - 1]
        _multiply(self.starts, self.indices, self.values, np.array(layout), unknowns, part)


def _joined(nodes: list[NearNodes]) -> NearNodes:
    """The nodes of many windows in a row."""
    names = ("parameters", "weights", "rows", "columns", "corrections")
    return NearNodes(*(np.concatenate([getattr(n, a) for n in nodes], axis=-1) for a in names))


def _starts(counts: list[int]) -> Index:
    return np.concatenate([[0], np.cumsum(counts)]).astype(np.int64)


@compiled
def _spread(rows, row_values, columns, column_values, width, inner, grid, outer, entries, size):
    """Entries at nodes to rows of a sparse matrix: each row's length, indices and values.

    The unknowns are splines' coefficients (·, width), then values at the grid's nodes.
    """
    kinds, targets, nodes = entries.shape[0], len(inner) - 1, inner[-1]
    dense, used = np.zeros((size, kinds)), np.zeros(size, dtype=np.bool_)
    counts = np.zeros(targets, dtype=np.int64)
    indices = np.empty(targets * size, dtype=np.int64)
    values = np.empty((kinds, targets * size))
    total = 0
    for t in range(targets):
        for k in range(inner[t], inner[t + 1]):
            for a in range(len(row_values)):
                for b in range(len(column_values)):
                    at = (rows[k] + a) * width + (columns[k] + b) % width
                    factor = row_values[a, k] * column_values[b, k]
                    used[at] = True
                    for e in range(kinds):
                        dense[at, e] += factor * entries[e, k]
        for k in range(outer[t], outer[t + 1]):
            used[grid[k]] = True
            for e in range(kinds):
                dense[grid[k], e] += entries[e, nodes + k]
        for at in range(size):
            if used[at]:
                indices[total] = at
                for e in range(kinds):
                    values[e, total], dense[at, e] = dense[at, e], 0.0
                used[at] = False
                counts[t] += 1
                total += 1
    return counts, indices[:total].copy(), values[:, :total].copy()


@compiled(fastmath=True)
def _multiply(starts, indices, values, layout, unknowns, out):
    for t in range(out.shape[1]):
        for i in range(layout.shape[0]):
            total = 0.0
            for j in range(layout.shape[1]):
                row, vector = values[layout[i, j]], unknowns[j]
                for k in range(starts[t], starts[t + 1]):
                    total += row[k] * vector[indices[k]]
            out[i, t] += total
