"""Adaptive cross approximation of the block of a cluster of panels and a cluster of targets.

A block K B of a mixed kernel K (targets × nodes) and a basis B (nodes × functions) becomes U V with
few columns in U.  Crosses are chosen in K, between targets and a few points on each panel; the row
of each cross is integrated against the functions as well, so that only rows are integrated:

    row of target t:      r = K(t, points), s = K(t, nodes) B,
    column of a point p:  c = K(targets, p),

each minus the sum of the former crosses there; then U gets the column c / r(p), V the row s.
(Bebendorf 2000; the functions are treated as further columns of the matrix, which are never
computed.)
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from cadbem.kernels.kernel import Array, Index, Kernel
from cadbem.operators.compressed.mixing import integrate, mix, mix_one
from cadbem.operators.compressed.sources import Sources

FIRST_ROOM = 48  # crosses


@dataclass(frozen=True, eq=False)
class MixedKernel:
    """A kernel and the ``mixing`` (patches, 2, components, unknowns) of its layers: see ``mix``."""

    kernel: Kernel
    mixing: Array

    @property
    def unknowns(self) -> int:
        """Unknowns of a function."""
        return self.mixing.shape[3]

    @cached_property
    def layouts(self) -> tuple[Index, Index]:
        """Entries of both layers as arrays (rows, components)."""
        return np.array(self.kernel.single), np.array(self.kernel.double)


@dataclass(frozen=True, eq=False)
class PanelCluster:
    """A cluster of panels: its ``points`` for crosses and its ``nodes``, the ``patch`` (E,) of each
    panel, the panels' ``functions`` (numbers among the cluster's ``count``), flat, and where each
    panel's begin, ``function_first`` (E + 1,)."""

    mixed: MixedKernel
    points: Sources
    nodes: Sources
    patch: Index
    functions: Index
    function_first: Index
    count: int

    def row(self, target: Array) -> Array:
        """Rows (rows, unknowns × (points + functions)) of a target (dim, 1)."""
        at_points = self._mixed_row(target, self.points)
        values = self._mixed_row(target, self.nodes)
        rows, unknowns, nodes = values.shape
        integrals = np.empty((rows * unknowns, self.count))
        table = self.nodes
        integrate(
            values.reshape(-1, nodes), table.first, table.basis, table.basis_first,
            self.functions, self.function_first, integrals,
        )  # fmt: skip
        return np.concatenate([at_points.reshape(rows, -1), integrals.reshape(rows, -1)], axis=1)

    def _mixed_row(self, target: Array, sources: Sources) -> Array:
        kernel, count = self.mixed.kernel, sources.position.shape[1]
        table = np.empty((kernel.entries, count))
        start, stop = np.zeros(1, dtype=np.int64), np.full(1, count)
        kernel.fill(target, start, stop, start, sources.position, sources.normal, table)
        out = np.empty((kernel.rows, self.mixed.unknowns, count))
        mix(table, *self.mixed.layouts, self.mixed.mixing, self.patch, sources.first, out)
        return out

    def column(self, targets: Array, number: int) -> Array:
        """Column (rows × T) of one unknown of one point."""
        kernel, count = self.mixed.kernel, targets.shape[1]
        unknown, point = divmod(number, self.points.position.shape[1])
        panel = np.searchsorted(self.points.first, point, side="right") - 1
        table = np.empty((kernel.entries, count))
        start = np.full(count, point)
        columns = np.arange(count)
        kernel.fill(
            targets, start, start + 1, columns, self.points.position, self.points.normal, table
        )
        out = np.empty((kernel.rows, count))
        factors = np.ascontiguousarray(self.mixed.mixing[self.patch[panel], :, :, unknown])
        mix_one(table, *self.mixed.layouts, factors, out)
        return out.ravel()


def cross_approximation(
    cluster: PanelCluster, targets: Array, tolerance: float
) -> tuple[Array, Array]:
    """U (k, rows × T) and V (k, unknowns × F) with UᵀV ≈ the block, for targets (dim, T).

    It ends when the crosses of a whole target are smaller than ``tolerance`` times the largest.
    """
    rows, count = cluster.mixed.kernel.rows, targets.shape[1]
    points = cluster.mixed.unknowns * cluster.points.position.shape[1]
    left = np.empty((FIRST_ROOM, rows * count))
    right = np.empty((FIRST_ROOM, points + cluster.mixed.unknowns * cluster.count))
    untried = np.ones(count, dtype=bool)
    target, largest, kept, done = count // 2, 0.0, 0, 0
    while untried.any():
        untried[target] = False
        block = cluster.row(np.ascontiguousarray(targets[:, target : target + 1]))
        weight, largest_here = np.zeros(count), 0.0
        for i in range(rows):
            row = block[i] - left[:done, i * count + target] @ right[:done]
            pivot = int(abs(row[:points]).argmax())
            if row[pivot] == 0.0:
                continue
            column = cluster.column(targets, pivot) - right[:done, pivot] @ left[:done]
            column /= row[pivot]
            if done == len(left):
                left, right = _doubled(left), _doubled(right)
            left[done], right[done] = column, row
            done += 1
            square = (column.reshape(rows, count) ** 2).sum(axis=0)
            scale = float((row[points:] ** 2).sum())
            weight += scale * square
            largest_here = max(largest_here, np.sqrt(scale * square.sum()))
        largest = max(largest, largest_here)
        if largest_here <= tolerance * largest:
            break
        kept = done
        target = int(np.where(untried, weight, -1.0).argmax())
    return left[:kept], right[:kept, points:]


def recompressed(left: Array, right: Array, tolerance: float) -> tuple[Array, Array]:
    """The same product in as few rows as a ``tolerance`` of its Frobenius norm allows."""
    if len(left) == 0:
        return left, right
    (q_left, r_left), (q_right, r_right) = np.linalg.qr(left.T), np.linalg.qr(right.T)
    u, values, v = np.linalg.svd(r_left @ r_right.T)
    tails = np.sqrt(np.cumsum(values[::-1] ** 2))[::-1]
    kept = int((tails > tolerance * tails[0]).sum())
    return (q_left @ (u[:, :kept] * values[:kept])).T, v[:kept] @ q_right.T


def _doubled(table: Array) -> Array:
    """Room for twice as many rows."""
    return np.concatenate([table, np.empty_like(table)])
