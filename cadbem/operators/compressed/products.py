"""Products with tables of 32 or 64 bits, summed with 64 bits."""

from __future__ import annotations

import numpy as np

from cadbem.compiled import compiled
from cadbem.kernels.kernel import Array


def times(table: Array, vector: Array) -> Array:
    """table @ vector (k[, M]) for a table (k, n) and a vector (n[, M]) of 64 bits.

    Many vectors at once are multiplied with the table's own precision.
    """
    if table.dtype == np.float64 or vector.ndim > 1:
        return table @ vector.astype(table.dtype, copy=False)
    out = np.empty(len(table))
    _times(table, vector, out)
    return out


def transposed_times(table: Array, vector: Array) -> Array:
    """tableᵀ @ vector (n[, M]) for a table (k, n) and a vector (k[, M]): see ``times``."""
    if table.dtype == np.float64 or vector.ndim > 1:
        return table.T @ vector.astype(table.dtype, copy=False)
    out = np.zeros(table.shape[1])
    _transposed_times(table, vector, out)
    return out


@compiled(fastmath=True)
def _times(table, vector, out):
    for k in range(table.shape[0]):
        row = table[k]
        total = 0.0
        for n in range(len(row)):
            total += row[n] * vector[n]
        out[k] = total


@compiled(fastmath=True)
def _transposed_times(table, vector, out):
    for k in range(table.shape[0]):
        row, factor = table[k], vector[k]
        for n in range(len(row)):
            out[n] += factor * row[n]
