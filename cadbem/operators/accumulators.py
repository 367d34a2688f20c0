"""Accumulators receive the contributions of panels: in matrices of a kernel, in potentials of given
densities, or in a record that gives potentials of any densities later."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Protocol

import numpy as np

from cadbem.compiled import compiled
from cadbem.kernels.kernel import Index, Layout
from cadbem.spline.basis import Array


class Accumulator(Protocol):
    """Where contributions of a patch go."""

    def pairs(self, rows: Index, first_u: Index, first_v: Index, values: Array) -> None:
        """Add values (pairs, entries, p + 1, q + 1) for the functions from (first_u, first_v)."""


@dataclass(frozen=True, eq=False)
class MatrixAccumulator:
    """Adds to ``entries`` (entries, T, F), a kernel's matrix: from target ``row`` on, and from the
    number ``offset`` on the functions of a patch, of which ``columns`` make a row of its net."""

    entries: Array
    columns: int
    row: int = 0
    offset: int = 0

    def pairs(self, rows: Index, first_u: Index, first_v: Index, values: Array) -> None:
        place = self.columns, self.row, self.offset
        add_entries(rows, first_u, first_v, values, *place, self.entries)


@dataclass(frozen=True, eq=False)
class PotentialAccumulator:
    """Adds potentials of densities (components, n_u, n_v) to ``result`` (rows, T)."""

    result: Array
    layouts: Sequence[Layout]
    densities: Sequence[Array]

    def pairs(self, rows: Index, first_u: Index, first_v: Index, values: Array) -> None:
        for layout, density in zip(self.layouts, self.densities, strict=True):
            if density.any():
                add_pairs(rows, first_u, first_v, values, np.array(layout), density, self.result)


@dataclass(frozen=True, eq=False)
class Record:
    """Keeps contributions, multiplied by ``sign``, to give potentials again and again.

    ``kept``: tuples of rows, first functions in both directions, and values, as of ``pairs``.
    """

    sign: float = 1.0
    kept: list[tuple[Index, Index, Index, Array]] = field(default_factory=list)

    @property
    def negative(self) -> Record:
        """An accumulator that takes away from the same record."""
        return Record(-self.sign, self.kept)

    def pairs(self, rows: Index, first_u: Index, first_v: Index, values: Array) -> None:
        self.kept.append((rows, first_u, first_v, self.sign * values))

    @cached_property
    def _together(self) -> tuple[Index, Index, Index, Array] | None:
        """The sum of all entries: each function of a target once, as a pair with one function."""
        if not self.kept:
            return None
        rows, first_u, first_v, values = (np.concatenate(x) for x in zip(*self.kept, strict=True))
        entries, height, width = values.shape[1:]
        spread = np.broadcast_arrays(
            rows[:, None, None],
            first_u[:, None, None] + np.arange(height)[:, None],
            first_v[:, None, None] + np.arange(width),
        )
        places = np.stack([x.ravel() for x in spread])
        shape = places.max(axis=1) + 1
        self.kept.clear()
        keys, place = np.unique(np.ravel_multi_index(tuple(places), shape), return_inverse=True)
        sums = np.zeros((len(keys), entries))
        np.add.at(sums, place, values.transpose(0, 2, 3, 1).reshape(-1, entries))
        row, u, v = map(np.ascontiguousarray, np.unravel_index(keys, shape))
        return row, u, v, sums[:, :, None, None]

    def replay(self, accumulator: Accumulator) -> None:
        """Give everything to another accumulator; afterwards nothing can be added."""
        if self._together is not None:
            accumulator.pairs(*self._together)


@compiled(fastmath=True)
def add_pairs(rows, first_u, first_v, values, layout, density, result):
    """Add potentials of a density (components, n_u, n_v) to ``result`` (rows, T)."""
    for k in range(len(rows)):
        part = density[
            :,
            first_u[k] : first_u[k] + values.shape[2],
            first_v[k] : first_v[k] + values.shape[3],
        ]
        for i in range(layout.shape[0]):
            total = 0.0
            for j in range(layout.shape[1]):
                entry = values[k, layout[i, j]]
                for a in range(entry.shape[0]):
                    for b in range(entry.shape[1]):
                        total += entry[a, b] * part[j, a, b]
            result[i, rows[k]] += total


@compiled
def add_entries(rows, first_u, first_v, values, columns, row, offset, entries):
    """Add values (pairs, entries, i, j) to ``entries`` (entries, T, F)."""
    for e in range(len(entries)):  # outermost: what neighbouring panels share stays in cache
        for k in range(len(rows)):
            # slices once, not all indices each time: what is added is short
            low = offset + columns * first_u[k] + first_v[k]
            into, part = entries[e, row + rows[k], low:], values[k, e]
            for i in range(part.shape[0]):
                for j in range(part.shape[1]):
                    into[i * columns + j] += part[i, j]
