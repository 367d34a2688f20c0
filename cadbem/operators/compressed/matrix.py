"""Layers as a compressed matrix: dense blocks near by, cross approximations far away.

Clusters of targets and clusters of panels that are far enough from each other form blocks of low
rank (an H-matrix: Hackbusch 1999; Bebendorf 2008); between neighbouring clusters all integrals are
as accurate as in the dense matrix.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from cadbem.kernels.kernel import Array, Index
from cadbem.operators.compressed.clusters import Tree
from cadbem.operators.compressed.cross import MixedKernel
from cadbem.operators.compressed.near_blocks import NearBlocks
from cadbem.operators.compressed.products import times, transposed_times
from cadbem.operators.parallel import in_shares


@dataclass(frozen=True, eq=False)
class SourceFactors:
    """Crosses of one cluster of panels: ``table`` (k, unknowns × F) for ``functions`` (F,)."""

    functions: Index
    table: Array


@dataclass(frozen=True, eq=False)
class TargetFactors:
    """Crosses of one cluster of targets, ``part`` of all in the tree's order: ``table``
    (k, rows × T), and which of all crosses they are, ``crosses`` (k,)."""

    part: slice
    table: Array
    crosses: Index


@dataclass(frozen=True, eq=False)
class CompressedMatrix:
    """A mixed kernel between the T targets of a ``tree`` and functions."""

    mixed: MixedKernel
    tree: Tree
    near: NearBlocks
    source_factors: Sequence[SourceFactors]
    target_factors: Sequence[TargetFactors]

    @property
    def size(self) -> int:
        """Bytes that are kept."""
        tables = [s.table for s in self.source_factors] + [t.table for t in self.target_factors]
        return sum(table.nbytes for table in tables) + self.near.entries.nbytes

    def apply(self, unknowns: Array) -> Array:
        """Values (rows, T[, M]) at the targets of coefficients (unknowns, F[, M])."""
        many = unknowns.shape[2:]

        def of(functions: Index) -> Array:
            return unknowns[:, functions].reshape(-1, *many)

        crosses = np.concatenate(
            [np.empty((0, *many))]
            + in_shares(lambda s: times(s.table, of(s.functions)), self.source_factors)
        )
        rows, count = self.mixed.kernel.rows, len(self.tree.order)
        result = np.zeros((rows, count, *many))

        def far(c: TargetFactors) -> Array:
            return transposed_times(c.table, crosses[c.crosses]).reshape(rows, -1, *many)

        def near(b: int) -> Array:
            part = of(self.near.functions[b])
            return (self.near.matrix(b) @ part).reshape(rows, -1, *many)

        for c, values in zip(self.target_factors, in_shares(far, self.target_factors), strict=True):
            result[:, c.part] += values
        leaves = range(len(self.near.counts))
        for part, values in zip(self._leaves, in_shares(near, leaves), strict=True):
            result[:, part] += values
        ordered = np.empty_like(result)
        ordered[:, self.tree.order] = result
        return ordered

    @cached_property
    def _leaves(self) -> list[slice]:
        """The part of the targets, in the tree's order, of each leaf."""
        start, stop = self.tree.start, self.tree.stop
        return [slice(start[c], stop[c]) for c in self.tree.leaves]
