"""A preconditioner on two levels: a coarse problem of functions that are constant on large clusters
is solved first.

With the columns of Z constant on one cluster and zero elsewhere, and a preconditioner M of short
reach, a right side r is solved approximately by

    Z c + M (r - A Z c),    (Zᵀ A Z) c = Zᵀ r,

so that the pressure in a long channel converges in few iterations, in spite of the short reach of
M.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cadbem.kernels.kernel import Array, Index
from cadbem.operators.compressed.clusters import Tree
from cadbem.operators.compressed.compress import LEAF
from cadbem.operators.compressed.matrix import CompressedMatrix
from cadbem.operators.compressed.overlapping import Overlapping, overlapping
from cadbem.progress import progress

COLUMNS = 24  # products at a time: each takes memory for all crosses
GROUPS = 100  # clusters, at least, unless they were smaller than two leaves


@dataclass(frozen=True, eq=False)
class TwoLevel:
    """See the top of this file.

    ``group`` (F,) numbers the cluster of each unknown; ``applied`` (rows × T, k) is A Z in 32 bits
    and ``inverse`` (k, k) that of Zᵀ A Z, for k = components × clusters; ``near`` is M.
    """

    near: Overlapping
    group: Index
    applied: NDArray[np.float32]
    inverse: Array

    def solve(self, right: Array) -> Array:
        """Unknowns (components, F), approximately, for a right side of the same shape."""
        sums = [np.bincount(self.group, weights=row) for row in right]
        amounts = self.inverse @ np.concatenate(sums)
        rest = right - (self.applied @ amounts.astype(np.float32)).reshape(right.shape)
        return self.near.solve(rest) + amounts.reshape(len(right), -1)[:, self.group]


def two_level(matrix: CompressedMatrix, positions: Array) -> TwoLevel:
    """The preconditioner of a matrix whose target i, at ``positions``[:, i], is unknown i's."""
    group, components = _groups(matrix.tree), matrix.mixed.unknowns
    count, size = int(group.max()) + 1, len(group)
    applied = np.empty((components * size, components * count), dtype=np.float32)
    sums = np.zeros((components * count, components * count))
    starts = range(0, components * count, COLUMNS)
    for low in progress(starts, "preconditioner"):
        high = min(low + COLUMNS, components * count)
        columns = np.zeros((components, size, high - low))
        for k in range(low, high):
            columns[k // count, group == k % count, k - low] = 1.0
        part = matrix.apply(columns)
        applied[:, low:high] = part.reshape(components * size, -1)
        for c in range(components):
            np.add.at(sums[c * count : (c + 1) * count, low:high], group, part[c])
    inverse = np.asarray(np.linalg.inv(sums), dtype=float)
    return TwoLevel(overlapping(matrix, positions), group, applied, inverse)


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
