"""Fields at the nodes near targets, from splines and from values on a grid."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cadbem.compiled import compiled
from cadbem.kernels.kernel import Index
from cadbem.spline.basis import Array


@compiled(fastmath=True)
def gather(spline, first_row, row_values, first_column, column_values, weights,
            grid, grid_rows, grid_columns, corrections, out):  # fmt: skip
    """Weighted fields at the nodes near each of T targets in a row: out (fields, K + K', T).

    ``spline`` (rows, m, ·) are coefficients and ``grid`` (rows, m, ·) values at the grid's nodes;
    those of column c begin at [c % m, c // m × fields], and columns repeat often enough.  The
    target t lies m t columns behind the first, so all targets' values are neighbours in memory.
    """
    fields, targets, residues = out.shape[0], out.shape[2], spline.shape[1]
    orders = column_values.shape[0]
    width = fields * targets
    length = width + fields * ((orders + residues - 1) // residues)
    band, mixed = np.empty((residues, length)), np.empty(width)
    near = len(weights)
    for k in range(near):
        first, start = first_column[k], first_column[k] // residues
        band[:] = 0.0
        for a in range(row_values.shape[0]):
            factor = row_values[a, k] * weights[k]
            for q in range(residues):
                source = spline[first_row[k] + a, q, fields * start : fields * start + length]
                accumulator = band[q]
                for m in range(length):
                    accumulator[m] += factor * source[m]
        mixed[:] = 0.0
        for b in range(orders):
            factor, low = column_values[b, k], fields * ((first + b) // residues - start)
            source = band[(first + b) % residues, low : low + width]
            for m in range(width):
                mixed[m] += factor * source[m]
        for f in range(fields):
            accumulator = out[f, k]
            for t in range(targets):
                accumulator[t] = mixed[t * fields + f]
    for k in range(len(corrections)):
        low = fields * (grid_columns[k] // residues)
        source = grid[grid_rows[k], grid_columns[k] % residues, low : low + width]
        for f in range(fields):
            accumulator = out[f, near + k]
            for t in range(targets):
                accumulator[t] = corrections[k] * source[t * fields + f]


@dataclass(frozen=True, eq=False)
class NearTable:
    """Splines' values at the polar nodes of one row of targets, and the grid nodes to correct."""

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

    def fields(self, spline: Array, grid: Array, count: int, targets: int, weighted: bool) -> Array:
        """``count`` fields (count, K + K', T) at the nodes near T targets: see ``gather``."""
        out = np.empty((count, self.count, targets))
        weights, corrections = self.weights, self.corrections
        if not weighted:
            weights, corrections = np.ones_like(weights), np.ones_like(corrections)
        gather(
            spline, self.row_first, self.row_values, self.column_first, self.column_values,
            weights, grid, self.grid_rows, self.grid_columns, corrections, out,
        )  # fmt: skip
        return out
