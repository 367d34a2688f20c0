"""Points of closed splines on a fixed grid: normals, curvatures, surface derivatives."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache
from itertools import product

import numpy as np

from cadbem.points import area_vector, dual_tangents
from cadbem.spline.basis import Array
from cadbem.spline.closed import ClosedBasis, ClosedSpline


@dataclass(frozen=True, eq=False)
class ClosedGrid:
    """A tensor grid of parameters ``axes`` with the matrices that evaluate a basis there.

    Points are numbered with the last parameter fastest.
    """

    basis: ClosedBasis
    axes: list[Array]

    @cached_property
    def measure(self) -> Array:
        """Length or area of the unit circle or sphere per unit of parameters: 1, or sin θ."""
        if self.basis.dimension == 2:
            return np.ones(len(self.axes[0]))
        return np.repeat(np.sin(self.axes[0]), len(self.axes[1]))

    @cached_property
    def _matrices(self) -> dict[tuple[int, ...], list[Array]]:
        orders = product(range(3), repeat=len(self.axes))
        return {o: self.basis.axis_matrices(self.axes, o) for o in orders if sum(o) < 3}

    def values(self, coefficients: Array, orders: tuple[int, ...] | None = None) -> Array:
        """Values or derivatives (..., N) of coefficients (..., *shape)."""
        matrices = self._matrices[orders or (0,) * len(self.axes)]
        result = self.basis.on_grid(coefficients, matrices)
        return result.reshape(*result.shape[: -len(self.axes)], -1)

    def transposed(self, values: Array) -> Array:
        """Coefficients Σ_n N_i(n) values_n (..., *shape) of values (..., N): the transpose."""
        matrices = self._matrices[(0,) * len(self.axes)]
        shaped = values.reshape(*values.shape[:-1], *(len(axis) for axis in self.axes))
        result = shaped @ matrices[-1]
        if len(matrices) == 1:
            return result
        return self.basis.folded(matrices[0].T @ result)

    def first(self, coefficients: Array) -> Array:
        """First derivatives (p, ..., N)."""
        return np.stack([self.values(coefficients, o) for o in self._units])

    def second(self, coefficients: Array) -> Array:
        """Second derivatives (p, p, ..., N)."""
        units = np.array(self._units)
        orders = [[tuple((a + b).tolist()) for b in units] for a in units]
        found = {o: self.values(coefficients, o) for o in {o for row in orders for o in row}}
        return np.stack([np.stack([found[o] for o in row]) for row in orders])

    @property
    def _units(self) -> list[tuple[int, ...]]:
        return [tuple(row) for row in np.eye(len(self.axes), dtype=int).tolist()]

    def points(self, spline: ClosedSpline) -> ClosedPoints:
        """The points of a curve or surface on this grid."""
        tangents = self.first(spline.coefficients)
        second = self.second(spline.coefficients)
        area = np.ascontiguousarray(area_vector(*tangents))  # a cross product comes transposed
        length = np.linalg.norm(area, axis=0)
        normal = area / length
        duals = np.stack(dual_tangents(*tangents))
        # shape operator n_i,j in mixed components: minus second fundamental form over metric
        bending = -np.einsum("abcn,cn->abn", second, normal)
        operator = np.einsum("acn,bcn->abn", duals, duals)
        mixed = np.einsum("abn,bcn->acn", operator, bending)
        gaussian = _determinant(mixed) if len(tangents) == 2 else np.zeros_like(length)
        return ClosedPoints(
            grid=self,
            position=self.values(spline.coefficients),
            normal=normal,
            jacobian=length / self.measure,
            tangents=tangents,
            duals=duals,
            curvature=np.einsum("aan->n", mixed),
            gaussian=gaussian,
            second=second,
        )


@lru_cache(maxsize=16)
def collocation_grid(basis: ClosedBasis) -> ClosedGrid:
    """The collocation points of a basis."""
    return ClosedGrid(basis, basis.axes())


def _determinant(matrix: Array) -> Array:
    return matrix[0, 0] * matrix[1, 1] - matrix[0, 1] * matrix[1, 0]


@dataclass(frozen=True, eq=False)
class ClosedPoints:
    """N points of a closed curve or surface with all that interface laws need.

    ``position`` and outward unit ``normal`` (dim, N); ``jacobian`` (N,), length or area per unit
    of the unit circle or sphere; ``tangents`` and ``duals`` (p, dim, N); ``curvature`` (N,),
    div n, 2 / R on a sphere and 1 / R on a circle; ``gaussian`` curvature (N,), 0 in 2D;
    ``second`` derivatives of position (p, p, dim, N).
    """

    grid: ClosedGrid
    position: Array
    normal: Array
    jacobian: Array
    tangents: Array
    duals: Array
    curvature: Array
    gaussian: Array
    second: Array

    def gradient(self, coefficients: Array) -> Array:
        """Surface gradient (dim, N) of a scalar field with coefficients (*shape)."""
        return np.einsum("an,acn->cn", self.grid.first(coefficients), self.duals)

    def divergence(self, coefficients: Array) -> Array:
        """Surface divergence (N,) of a vector field with coefficients (dim, *shape)."""
        return np.einsum("acn,acn->n", self.grid.first(coefficients), self.duals)

    def laplacian(self, coefficients: Array) -> Array:
        """Surface Laplacian (N,) of a scalar field: g^ab (f_ab - x_ab · grad f)."""
        bent = np.einsum("abcn,cn->abn", self.second, self.gradient(coefficients))
        rest = self.grid.second(coefficients) - bent
        return np.einsum("abn,acn,bcn->n", rest, self.duals, self.duals)
