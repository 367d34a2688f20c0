"""Where contributions of panels go: matrices of a kernel, potentials of given densities, or a
record that gives potentials of any densities later."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np

from cadbem.kernels.kernel import Index, Layout
from cadbem.spline.basis import Array


class Sink(Protocol):
    """Where contributions of a patch go."""

    def block(
        self, rows: slice | Index, table: Array, basis: Array, part_u: slice, part_v: slice
    ) -> None:
        """Add table (entries, R, nodes) times basis (nodes, functions of the net's block)."""

    def pairs(self, rows: Index, first_u: Index, first_v: Index, values: Array) -> None:
        """Add values (pairs, entries, p + 1, q + 1) for the functions from (first_u, first_v)."""


@dataclass(frozen=True, eq=False)
class MatrixSink:
    """Adds to ``entries`` (entries, T, n_u, n_v), the kernel's matrix of one patch."""

    entries: Array

    def block(
        self, rows: slice | Index, table: Array, basis: Array, part_u: slice, part_v: slice
    ) -> None:
        shape = (*table.shape[:2], part_u.stop - part_u.start, part_v.stop - part_v.start)
        self.entries[:, rows, part_u, part_v] += (table @ basis).reshape(shape)

    def pairs(self, rows: Index, first_u: Index, first_v: Index, values: Array) -> None:
        for k, (t, u, v) in enumerate(zip(rows, first_u, first_v, strict=True)):
            part = (slice(u, u + values.shape[2]), slice(v, v + values.shape[3]))
            self.entries[(slice(None), t, *part)] += values[k]


@dataclass(frozen=True, eq=False)
class PotentialSink:
    """Adds potentials of densities (components, n_u, n_v) to ``result`` (rows, T)."""

    result: Array
    layouts: Sequence[Layout]
    densities: Sequence[Array]

    def block(
        self, rows: slice | Index, table: Array, basis: Array, part_u: slice, part_v: slice
    ) -> None:
        for layout, density in zip(self.layouts, self.densities, strict=True):
            local = density[:, part_u, part_v].reshape(len(density), -1)
            first = min(map(min, layout))
            values = table[first : max(map(max, layout)) + 1] @ (basis @ local.T)
            for i, row in enumerate(layout):
                self.result[i, rows] += sum(values[e - first, :, j] for j, e in enumerate(row))

    def pairs(self, rows: Index, first_u: Index, first_v: Index, values: Array) -> None:
        p, q = values.shape[2], values.shape[3]
        u = (first_u[:, None] + np.arange(p))[:, :, None]
        v = (first_v[:, None] + np.arange(q))[:, None, :]
        for layout, density in zip(self.layouts, self.densities, strict=True):
            local = density[:, u, v]
            if not local.any():
                continue
            for i, row in enumerate(layout):
                for j, entry in enumerate(row):
                    np.add.at(self.result[i], rows, (values[:, entry] * local[j]).sum(axis=(1, 2)))


@dataclass(frozen=True, eq=False)
class _Block:
    """Recorded contributions (entries, R, n_u n_v) of a block of functions to some rows."""

    rows: slice | Index
    values: Array
    parts: tuple[slice, slice]

    def add(self, sink: PotentialSink) -> None:
        """Their potentials."""
        for layout, density in zip(sink.layouts, sink.densities, strict=True):
            local = density[:, *self.parts].reshape(len(density), -1)
            if local.any():
                products = np.einsum("ijrk,jk->ir", self.values[np.array(layout)], local)
                sink.result[:, self.rows] += products


@dataclass(frozen=True, eq=False)
class Record:
    """Keeps contributions, multiplied by ``sign``, to give potentials again and again."""

    sign: float = 1.0
    blocks: list[_Block] = field(default_factory=list)
    rows_of_pairs: list[tuple[Index, Index, Index, Array]] = field(default_factory=list)

    @property
    def negative(self) -> Record:
        """A sink that takes away from the same record."""
        return Record(-self.sign, self.blocks, self.rows_of_pairs)

    def block(
        self, rows: slice | Index, table: Array, basis: Array, part_u: slice, part_v: slice
    ) -> None:
        self.blocks.append(_Block(rows, self.sign * (table @ basis), (part_u, part_v)))

    def pairs(self, rows: Index, first_u: Index, first_v: Index, values: Array) -> None:
        self.rows_of_pairs.append((rows, first_u, first_v, self.sign * values))

    def replay(self, sink: PotentialSink) -> None:
        """Give everything to a sink with densities."""
        for block in self.blocks:
            block.add(sink)
        for pairs in self.rows_of_pairs:
            sink.pairs(*pairs)
