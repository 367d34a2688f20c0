"""A preconditioner on two levels: what is constant on large clusters is solved first.

With the columns of Z constant on one cluster and zero elsewhere, and a preconditioner M of short
reach, a right side r is solved roughly by

    Z c + M (r - A Z c),    (Zᵀ A Z) c = Zᵀ r,

so that what travels through a long channel, above all pressure, need not wait for M.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cadbem.kernels.kernel import Array, Index
from cadbem.operators.clusters import Tree
from cadbem.operators.compress import LEAF
from cadbem.operators.compressed import CompressedMatrix
from cadbem.operators.overlapping import Overlapping, overlapping

COLUMNS = 24  # products at a time: each takes memory for all crosses
GROUPS = 100  # clusters, at least, unless they were smaller than two leaves


@dataclass(frozen=True, eq=False)
class TwoLevel:
    """See the top of this file.

    ``group`` (F,) numbers the cluster of each unknown; ``made`` (rows × T, k) is A Z and
    ``inverse`` (k, k) that of Zᵀ A Z, for k = components × clusters; ``near`` is M.
    """

    near: Overlapping
    group: Index
    made: Array
    inverse: Array

    def solve(self, right: Array) -> Array:
        """Unknowns (components, F), roughly, for a right side of the same shape."""
        sums = [np.bincount(self.group, weights=row) for row in right]
        amounts = self.inverse @ np.concatenate(sums)
        rest = right - (self.made @ amounts).reshape(right.shape)
        return self.near.solve(rest) + amounts.reshape(len(right), -1)[:, self.group]


def two_level(matrix: CompressedMatrix, positions: Array) -> TwoLevel:
    """The preconditioner of a matrix whose target i, at ``positions``[:, i], is unknown i's."""
    group, components = _groups(matrix.tree), matrix.mixed.unknowns
    count = int(group.max()) + 1
    columns = np.zeros((components, len(group), components, count))
    for c in range(components):
        columns[c, np.arange(len(group)), c, group] = 1.0
    columns = columns.reshape(components, len(group), -1)
    starts = range(0, columns.shape[2], COLUMNS)
    parts = [matrix.apply(columns[:, :, k : k + COLUMNS]) for k in starts]
    made = np.concatenate(parts, axis=2)
    sums = np.zeros((components, count, made.shape[2]))
    for c in range(components):
        np.add.at(sums[c], group, made[c])
    inverse = np.asarray(np.linalg.inv(sums.reshape(components * count, -1)), dtype=float)
    near = overlapping(matrix, positions)
    return TwoLevel(near, group, made.reshape(-1, made.shape[2]), inverse)


def _groups(tree: Tree) -> Index:
    """Number of the large cluster of each target."""
    most = max(2 * LEAF, len(tree.order) // GROUPS)
    group, count, todo = np.empty(len(tree.order), dtype=np.int64), 0, [0]
    while todo:
        c = todo.pop()
        if tree.stop[c] - tree.start[c] <= most or tree.children[c, 0] < 0:
            group[tree.items(c)] = count
            count += 1
        else:
            todo += [int(child) for child in tree.children[c]]
    return group
