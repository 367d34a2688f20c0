"""A preconditioner: small clusters of unknowns, each solved with its neighbours.

(Restricted additive Schwarz: Cai and Sarkis 1999.)  It keeps numbers of 32 bits.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import lu_factor, lu_solve
from scipy.spatial import cKDTree

from cadbem.kernels.kernel import Array, Index
from cadbem.operators.compressed.matrix import CompressedMatrix
from cadbem.operators.compressed.near_blocks import NearBlocks
from cadbem.operators.parallel import in_shares

OVERLAP = 3.0  # spacings of points by which clusters reach into their neighbours


@dataclass(frozen=True, eq=False)
class Part:
    """The unknowns of a cluster, ``own`` (n,), which are solved with others, ``all`` (m,); their
    ``places`` among all, and LU factors of the square matrix."""

    own: Index
    all: Index
    places: Index
    factors: tuple[Array, Array]

    def solve(self, right: Array) -> Array:
        """Unknowns (components, n) of the cluster for a right side (components, F)."""
        values = lu_solve(self.factors, right[:, self.all].ravel(), check_finite=False)
        return values.reshape(len(right), -1)[:, self.places]


@dataclass(frozen=True, eq=False)
class Overlapping:
    """An approximate inverse of a square compressed matrix."""

    parts: Sequence[Part]

    def solve(self, right: Array) -> Array:
        """Unknowns (components, F), approximately, for a right side of the same shape."""
        right = right.astype(self.parts[0].factors[0].dtype)
        result = np.empty(right.shape)
        made = in_shares(lambda part: part.solve(right), self.parts)
        for part, values in zip(self.parts, made, strict=True):
            result[:, part.own] = values
        return result


def overlapping(matrix: CompressedMatrix, positions: Array) -> Overlapping:
    """The preconditioner of a matrix whose target i, at ``positions``[:, i], is unknown i's."""
    points, near = cKDTree(positions.T), matrix.near
    dim = len(positions)

    def part(leaf: int) -> Part:
        own = np.sort(matrix.tree.items(leaf))
        spacing = np.sqrt(2) * matrix.tree.radius[leaf] / len(own) ** (1 / (dim - 1))
        around = points.query_ball_point(positions[:, own].T, OVERLAP * spacing)
        everything = np.unique(np.concatenate([own, *around]).astype(np.int64))
        factors = lu_factor(_square(near, everything), overwrite_a=True, check_finite=False)
        return Part(own, everything, np.searchsorted(everything, own), factors)

    return Overlapping(in_shares(part, list(matrix.tree.leaves)))


def _square(near: NearBlocks, numbers: Index) -> NDArray[np.float32]:
    """The part (components × m, components × m) of the near blocks that belongs to m unknowns; zero
    where no block has it."""
    rows, unknowns = near.mixed.kernel.rows, near.mixed.unknowns
    result = np.zeros((rows, len(numbers), unknowns, len(numbers)), dtype=np.float32)
    for b in np.unique(near.block[numbers]):
        here = np.nonzero(near.block[numbers] == b)[0]
        known = np.nonzero(np.isin(numbers, near.functions[b]))[0]
        places = np.searchsorted(near.functions[b], numbers[known])
        table = near.matrix(b).reshape(rows, near.counts[b], unknowns, -1)
        lines = near.place[numbers[here]]
        part = table[:, lines[:, None, None], np.arange(unknowns)[:, None], places]
        result[:, here[:, None, None], np.arange(unknowns)[:, None], known] = part
    return result.reshape(rows * len(numbers), -1)
