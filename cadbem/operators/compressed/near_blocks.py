"""Interactions of panels with targets near them: one dense block for each cluster of targets."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from threading import Lock

import numpy as np

from cadbem.compiled import compiled
from cadbem.kernels.kernel import Array, Index
from cadbem.operators.compressed.cross import MixedKernel
from cadbem.space import Space


@dataclass(frozen=True, eq=False)
class NearBlocks:
    """Blocks (rows × T, unknowns × F) of a mixed kernel, one a cluster of targets.

    Block b has the targets with ``block``[t] = b, of which t has the number ``place``[t], and the
    functions ``functions``[b], sorted; ``entries`` holds all blocks, b from ``first``[b] on.
    """

    mixed: MixedKernel
    block: Index
    place: Index
    counts: Index
    functions: Sequence[Index]
    first: Index
    entries: Array

    @classmethod
    def empty(
        cls, mixed: MixedKernel, clusters: Sequence[Index], functions: Sequence[Index]
    ) -> NearBlocks:
        """Zero blocks of ``clusters`` of targets with these functions."""
        block = np.empty(sum(map(len, clusters)), dtype=np.int64)
        place = np.empty_like(block)
        for b, targets in enumerate(clusters):
            block[targets], place[targets] = b, np.arange(len(targets))
        counts = np.array([len(c) for c in clusters])
        sizes = counts * [len(f) for f in functions] * mixed.kernel.rows * mixed.unknowns
        first = np.concatenate([[0], np.cumsum(sizes)])
        return cls(mixed, block, place, counts, functions, first, np.zeros(first[-1]))

    @cached_property
    def flat_functions(self) -> Index:
        """The functions of all blocks, one after the other."""
        return np.concatenate(self.functions)

    @cached_property
    def first_function(self) -> Index:
        """Where those of each block begin."""
        return np.concatenate([[0], np.cumsum([len(f) for f in self.functions])])

    def matrix(self, block: int) -> Array:
        """A block (rows × T, unknowns × F)."""
        flat = self.entries[self.first[block] : self.first[block + 1]]
        return flat.reshape(self.mixed.kernel.rows * self.counts[block], -1)

    def take(self, space: Space, patch: int, factors: Array) -> None:
        """Take from all blocks ``factors`` (rows, unknowns) times the functions of a patch at its
        own collocation points."""
        values, part = space.collocation_matrix(patch), space.functions(patch)
        for b in np.unique(self.block[part]):
            here = np.nonzero(self.block[part] == b)[0]
            sparse = values[here].tocoo()
            places = np.searchsorted(self.functions[b], part.start + sparse.col)
            lines = self.place[part][here[sparse.row]]
            table = self.matrix(b).reshape(*factors.shape[:1], self.counts[b], factors.shape[1], -1)
            for i, k in zip(*np.nonzero(factors), strict=True):
                table[i, lines, k, places] -= factors[i, k] * sparse.data


@dataclass(frozen=True, eq=False)
class NearAccumulator:
    """Adds the contributions of a patch to near blocks: see ``Accumulator``; ``offset`` of the
    patch's functions, of which ``columns`` make a row."""

    blocks: NearBlocks
    patch: int
    offset: int
    columns: int
    lock: Lock

    def pairs(self, rows: Index, first_u: Index, first_v: Index, values: Array) -> None:
        u = first_u[:, None, None] + np.arange(values.shape[2])[:, None]
        v = first_v[:, None, None] + np.arange(values.shape[3])
        numbers = (self.offset + u * self.columns + v).reshape(len(rows), -1)
        own, mixed = self.blocks, self.blocks.mixed
        with self.lock:
            scatter(
                rows, numbers, values.reshape(*values.shape[:2], -1), *mixed.layouts,
                mixed.mixing[self.patch], own.block, own.place, own.counts, own.flat_functions,
                own.first_function, own.first, own.entries,
            )  # fmt: skip


@compiled(fastmath=True)
def scatter(
    rows, numbers, values, single, double, mixing, block, place, counts, functions,
    first_function, first, entries,
):  # fmt: skip
    """Add ``values`` (R, entries, F) of functions ``numbers`` (R, F) to near blocks."""
    width, unknowns = values.shape[2], mixing.shape[2]
    places, last, last_first = np.empty(width, dtype=np.int64), -1, -1
    for r in range(values.shape[0]):
        b = block[rows[r]]
        if b != last or numbers[r, 0] != last_first:  # neighbours mostly share a panel
            here = functions[first_function[b] : first_function[b + 1]]
            places[:] = np.searchsorted(here, numbers[r])
            last, last_first = b, numbers[r, 0]
        columns = first_function[b + 1] - first_function[b]
        for i in range(single.shape[0]):
            for k in range(unknowns):
                line = (i * counts[b] + place[rows[r]]) * unknowns + k
                into = entries[first[b] + line * columns : first[b] + (line + 1) * columns]
                for j in range(single.shape[1]):
                    for layer in range(2):
                        factor = mixing[layer, j, k]
                        if factor != 0.0:
                            part = values[r, single[i, j] if layer == 0 else double[i, j]]
                            for m in range(width):
                                into[places[m]] += factor * part[m]
