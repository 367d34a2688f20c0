"""Linear systems of single and double layer, with one combination of both on each patch."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.linalg import lu_factor, lu_solve

from cadbem.operators.assembly import add_layers
from cadbem.operators.layers import OwnLayers
from cadbem.progress import stage
from cadbem.spline.basis import Array


@dataclass(frozen=True, eq=False)
class Solved:
    """``unknowns`` (components, F[, M]), the factors (k[, M]) of a ``border``'s fields, and the
    number of ``iterations`` that it took."""

    unknowns: Array
    border: Array
    iterations: int = 0


@dataclass(frozen=True, eq=False)
class DenseFactors:
    """LU factors of a dense system with unknowns (components, F)."""

    factors: tuple[Array, Array]
    shape: tuple[int, int]

    def solve(self, right: Array, constraints: Array | float = 0.0) -> Solved:
        """The solution for a right side (rows, T), or for M of them (rows, T, M).

        ``constraints`` (k,) are the right sides of a border's rows.
        """
        equations, count = right.shape[0] * right.shape[1], self.shape[0] * self.shape[1]
        columns = np.empty((len(self.factors[1]), *right.shape[2:]))
        columns[:equations] = right.reshape(equations, *right.shape[2:])
        columns[equations:] = constraints
        # the factors are those of the transposed matrix, which saved a copy
        solution = lu_solve(self.factors, columns, trans=1)
        return Solved(solution[:count].reshape(*self.shape, *right.shape[2:]), solution[count:])

    def solve_transposed(self, functionals: Array) -> Array:
        """What errors of the equations do to linear functionals of the unknowns.

        For ``functionals`` (M, components, F) the weights (M, rows, T) of the equations: the
        transposed system's solutions.
        """
        columns = np.zeros((len(self.factors[1]), len(functionals)))
        columns[: self.shape[0] * self.shape[1]] = functionals.reshape(len(functionals), -1).T
        solution = lu_solve(self.factors, columns, trans=0)
        rows = self.shape[0] * self.shape[1]
        return solution[:rows].T.reshape(len(functionals), *self.shape)


@dataclass(frozen=True, eq=False)
class Border:
    """k constraints on the unknowns, and k fields that make room for them.

    ``rows`` (k, components, F) of the constraints; ``fields`` (k, rows, T), each added to the
    equations with a factor that is unknown too.
    """

    rows: Array
    fields: Array


def factorise(
    layers: OwnLayers,
    free_term: float,
    single: Sequence[Array],
    double: Sequence[Array],
    border: Border | None = None,
) -> DenseFactors:
    """Factors of q -> S (F q) + (D - free_term) (U q), collocated in the layers' own space.

    ``single`` = F and ``double`` = U hold one (components, k) matrix a patch.  A ``border``
    removes null spaces.
    """
    rows, count, unknowns = layers.kernel.rows, layers.count, single[0].shape[1]
    extra = 0 if border is None else len(border.rows)
    equations, columns = rows * count, unknowns * count
    square = np.zeros((equations + extra, columns + extra))
    if border is not None:
        square[equations:, :columns] = border.rows.reshape(extra, columns)
        square[:equations, columns:] = border.fields.reshape(extra, equations).T
    matrix = square[:equations, :columns].reshape(rows, count, unknowns, count, copy=False)
    with stage(f"assembling {count} points"):
        add_layers(layers, single, double, matrix)
    for patch, u in enumerate(double):
        part, own = layers.space.functions(patch), layers.space.collocation_matrix(patch)
        matrix[:, part, :, part] -= free_term * u[:, None, :, None] * own.toarray()[:, None]
    with stage(f"factorising {len(square)} unknowns"):
        factors = lu_factor(square.T, overwrite_a=True, check_finite=False)
    return DenseFactors(factors, (unknowns, count))
