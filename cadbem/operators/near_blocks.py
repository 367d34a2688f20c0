"""What panels do to targets near them: one dense block for each small cluster of targets."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from threading import Lock

import numpy as np

from cadbem.compiled import compiled
from cadbem.kernels.kernel import Array, Index
from cadbem.operators.cross import MixedKernel


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

    def matrix(self, block: int) -> Array:
        """A block (rows × T, unknowns × F)."""
        flat = self.entries[self.first[block] : self.first[block + 1]]
        return flat.reshape(self.mixed.kernel.rows * self.counts[block], -1)


@dataclass(frozen=True, eq=False)
class NearSink:
    """Adds what a patch does to near blocks: see ``Sink``; ``offset`` of the patch's functions, of
    which ``columns`` make a row."""

    blocks: NearBlocks
    patch: int
    offset: int
    columns: int
    lock: Lock

    def block(
        self, rows: slice | Index, table: Array, basis: Array, part_u: slice, part_v: slice
    ) -> None:
        values = np.ascontiguousarray((table @ basis).swapaxes(0, 1))
        u, v = np.arange(part_u.start, part_u.stop), np.arange(part_v.start, part_v.stop)
        numbers = (self.offset + u[:, None] * self.columns + v).ravel()
        self._add(np.asarray(rows), np.broadcast_to(numbers, (len(values), len(numbers))), values)

    def pairs(self, rows: Index, first_u: Index, first_v: Index, values: Array) -> None:
        u = first_u[:, None, None] + np.arange(values.shape[2])[:, None]
        v = first_v[:, None, None] + np.arange(values.shape[3])
        numbers = (self.offset + u * self.columns + v).reshape(len(rows), -1)
        self._add(rows, numbers, values.reshape(*values.shape[:2], -1))

    def _add(self, rows: Index, numbers: Index, values: Array) -> None:
        """Add values (R, entries, F) of functions with numbers (R, F)."""
        own, mixed = self.blocks, self.blocks.mixed
        block = own.block[rows]
        numbers = np.ascontiguousarray(numbers)
        places = np.empty_like(numbers)
        for b in np.unique(block):
            here = block == b
            places[here] = np.searchsorted(own.functions[b], numbers[here])
        widths = np.array([len(f) for f in own.functions])
        with self.lock:
            scatter(
                values, *mixed.layouts, mixed.mixing[self.patch], own.first[block],
                own.place[rows], own.counts[block], widths[block], places, own.entries,
            )  # fmt: skip


@compiled(fastmath=True)
def scatter(values, single, double, mixing, first, place, counts, widths, places, entries):
    """Add mixed ``values`` (R, entries, F) to blocks in flat ``entries``; see ``NearBlocks``.

    ``first``, ``counts`` and ``widths`` (R,) describe the block of each row, ``places`` (R, F) the
    columns.
    """
    rows, components, unknowns = single.shape[0], single.shape[1], mixing.shape[2]
    for r in range(values.shape[0]):
        for i in range(rows):
            for k in range(unknowns):
                line = (i * counts[r] + place[r]) * unknowns + k
                start = first[r] + line * widths[r]
                for j in range(components):
                    f, u = mixing[0, j, k], mixing[1, j, k]
                    if f == 0.0 and u == 0.0:
                        continue
                    for m in range(values.shape[2]):
                        value = f * values[r, single[i, j], m] + u * values[r, double[i, j], m]
                        entries[start + places[r, m]] += value
