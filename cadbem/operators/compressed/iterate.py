"""Linear systems of compressed layers, solved by iteration (GMRES, preconditioned)."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.sparse.linalg import LinearOperator, gcrotmk

from cadbem.errors import SolverError
from cadbem.kernels.kernel import Array
from cadbem.operators.compressed.coarse import TwoLevel
from cadbem.operators.compressed.matrix import CompressedMatrix
from cadbem.operators.solve import Border, Solved
from cadbem.progress import progress

INNER, KEPT, OUTER = 150, 10, 4  # iterations between restarts, directions kept, restarts


@dataclass(frozen=True, eq=False)
class Iteration:
    """A compressed system with k constraints, in place of factors.

    The ``matrix`` acts on unknowns over ``scale`` (unknowns, F), which makes tractions and
    velocities alike; residuals end below ``tolerance`` times the right side.
    """

    matrix: CompressedMatrix
    scale: Array
    border: Border
    preconditioner: TwoLevel
    tolerance: float

    def solve(self, right: Array, constraints: Array | float = 0.0) -> Solved:
        """The solution for a right side (rows, T), or for M of them (rows, T, M); constraints
        (k[, M]).  Raises ``SolverError`` if the iteration does not converge."""
        if right.ndim == 2:
            return self._solve(right, np.broadcast_to(constraints, len(self._rows)))
        many = np.broadcast_to(constraints, (len(self._rows), right.shape[2]))
        columns = [self._solve(right[..., m], many[:, m]) for m in range(right.shape[2])]
        return Solved(
            np.stack([c.unknowns for c in columns], axis=-1),
            np.stack([c.border for c in columns], axis=-1),
            sum(c.iterations for c in columns),
        )

    @cached_property
    def _weights(self) -> Array:
        """Factors (k,) of the constraints, which give each the weight of all equations."""
        norms = np.linalg.norm(self._scaled, axis=1)
        return np.sqrt(self.scale.size) / np.maximum(norms, 1e-300)

    @cached_property
    def _scaled(self) -> Array:
        return (self.border.rows * self.scale).reshape(-1, self.scale.size)

    @cached_property
    def _rows(self) -> Array:
        return self._scaled * self._weights[:, None]

    @cached_property
    def _fields(self) -> Array:
        """(rows × T, k)."""
        fields = self.border.fields
        return fields.reshape(len(fields), self.scale.size).T

    @cached_property
    def _schur(self) -> tuple[Array, Array]:
        """Approximately solved fields (F, k), and the inverse of what is left for their factors."""
        columns = [self._approximate(column) for column in self._fields.T]
        solved = np.reshape(columns, (len(self._rows), self.scale.size)).T
        inverse = np.asarray(np.linalg.inv(-self._rows @ solved), dtype=float)
        return solved, inverse

    def _approximate(self, right: Array) -> Array:
        shape = self.matrix.mixed.kernel.rows, -1
        return self.preconditioner.solve(right.reshape(shape)).ravel()

    def _precondition(self, right: Array) -> Array:
        count = self.scale.size
        unknowns = self._approximate(right[:count])
        solved, inverse = self._schur
        factors = inverse @ (right[count:] - self._rows @ unknowns)
        return np.concatenate([unknowns - solved @ factors, factors])

    def _apply(self, values: Array) -> Array:
        count = self.scale.size
        unknowns, factors = values[:count], values[count:]
        product = self.matrix.apply(unknowns.reshape(self.scale.shape)).ravel()
        return np.concatenate([product + self._fields @ factors, self._rows @ unknowns])

    def _solve(self, right: Array, constraints: Array) -> Solved:
        whole = np.concatenate([right.ravel(), self._weights * constraints])
        iterations = 0
        with progress(label="iterations") as bar:

            def apply(values: Array) -> Array:
                nonlocal iterations
                iterations += 1
                bar.update()
                return self._apply(values)

            operator = LinearOperator((whole.size, whole.size), apply, dtype=float)
            preconditioner = LinearOperator(operator.shape, self._precondition, dtype=float)
            # flexible, for the preconditioner rounds to 32 bits
            values, failed = gcrotmk(
                operator,
                whole,
                M=preconditioner,
                rtol=self.tolerance,
                m=INNER,
                k=KEPT,
                maxiter=OUTER,
            )
        if failed:
            residual = np.linalg.norm(self._apply(values) - whole) / np.linalg.norm(whole)
            raise SolverError(
                f"the flow did not converge: residual {residual:.1e} after {iterations} "
                f"iterations, tolerance {self.tolerance:.1e}; take a finer grid, or storage=Dense()"
            )
        unknowns = values[: self.scale.size].reshape(self.scale.shape) * self.scale
        return Solved(unknowns, values[self.scale.size :], iterations)
