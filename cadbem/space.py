"""Unknowns on a boundary: functions, collocation points, fields.

Functions are numbered patch by patch, within a patch with the last parameter fastest.  A
vector of coefficients has the component slowest: (dim, F).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike
from scipy.sparse import csr_array
from scipy.sparse.linalg import splu

from cadbem.boundary import Boundary
from cadbem.overviews import field_text, space_text
from cadbem.points import SurfacePoints, area_vector, dual_tangents, join, surface_points
from cadbem.quadrature.gauss import gauss_on_breaks, gauss_unit, tensor_rule
from cadbem.spline.basis import Array, basis_functions, greville
from cadbem.spline.nurbs import Nurbs

END_SHIFT = 0.3  # how far end points move towards their neighbours: see ``discontinuous_space``


@dataclass(frozen=True, eq=False)
class Space:
    """The patches' own NURBS functions as unknowns, with one collocation point a function.

    ``offsets`` (patches + 1,) are the numbers of each patch's first function; ``parameters``
    one (p, n) array a patch; ``collocation`` the points in the same order as the functions.
    """

    boundary: Boundary
    offsets: tuple[int, ...]
    parameters: tuple[Array, ...]
    collocation: SurfacePoints

    __repr__ = space_text

    @property
    def count(self) -> int:
        """Number of functions, and of collocation points."""
        return self.offsets[-1]

    def functions(self, patch: int) -> slice:
        """Numbers of a patch's functions."""
        return slice(self.offsets[patch], self.offsets[patch + 1])

    def values(self, coefficients: Array) -> Array:
        """Values (dim, N) at the collocation points of coefficients (dim, F)."""
        result = np.empty_like(coefficients)
        for i, matrix in enumerate(self._collocation_matrices):
            part = self.functions(i)
            result[:, part] = (matrix @ coefficients[:, part].T).T
        return result

    @cached_property
    def _collocation_matrices(self) -> list[csr_array]:
        pairs = zip(self.boundary.patches, self.parameters, strict=True)
        return [rational_basis(patch.surface, parameters) for patch, parameters in pairs]

    def collocation_matrix(self, patch: int) -> csr_array:
        """Values of a patch's functions at its collocation points: sparse (n, n)."""
        return self._collocation_matrices[patch]

    def interpolate(self, values: Array) -> Array:
        """Coefficients (dim, F) of the field with these values at the collocation points."""
        result = np.empty_like(values)
        for i in range(len(self.boundary.patches)):
            part = self.functions(i)
            factors = splu(self.collocation_matrix(i).tocsc())
            result[:, part] = factors.solve(np.ascontiguousarray(values[:, part].T)).T
        return result

    @cached_property
    def weights(self) -> Array:
        """What a value at each collocation point counts in an integral over the boundary: (N,).

        Σ w v = ∫ v dS for every v of the space.
        """
        result = np.empty(self.count)
        for i in range(len(self.boundary.patches)):
            factors = splu(self.collocation_matrix(i).tocsc())
            result[self.functions(i)] = factors.solve(self.integrals(i), trans="T")
        return result

    def integrals(self, patch: int) -> Array:
        """The integral of each function of a patch over it: (n,)."""
        element = self.boundary.patches[patch]
        order = max(element.surface.degrees) + 4
        basis = rational_basis(element.surface, _element_parameters(element.surface, order))
        return basis.T @ element.quadrature(order)[1]

    def project(self, patch: int, function: Callable[[SurfacePoints], Array]) -> Array:
        """L² projection (dim, n) of ``function(points) -> (dim, N)`` on one patch.

        It keeps the integral over the patch exactly: the functions sum to one.
        """
        surface = self.boundary.patches[patch].surface
        order = max(surface.degrees) + 8
        points, weights = self.boundary.patches[patch].quadrature(order)
        matrix = rational_basis(surface, _element_parameters(surface, order))
        mass = splu((matrix.T @ (matrix * weights[:, None])).tocsc())
        return mass.solve(matrix.T @ (weights * function(points)).T).T


@dataclass(frozen=True, eq=False)
class Field:
    """A vector field (dim, ·) or a scalar one (1, ·) on a space: ``coefficients`` (dim, F)."""

    space: Space
    coefficients: Array

    __repr__ = field_text

    def patch_coefficients(self, patch: int) -> Array:
        """Control values (dim, n_1[, n_2]) of one patch."""
        shape = self.space.boundary.patches[patch].surface.weights.shape
        part = self.coefficients[:, self.space.functions(patch)]
        return part.reshape(-1, *shape)

    def on_patch(self, patch: int, *parameters: ArrayLike) -> Array:
        """Values (dim, *shape) at parameters of one patch."""
        surface = self.space.boundary.patches[patch].surface
        control = np.moveaxis(self.patch_coefficients(patch), 0, -1)
        return replace(surface, points=control).evaluate(*parameters)

    def surface_divergence(self, patch: int, *parameters: ArrayLike) -> tuple[Array, Array]:
        """Unit normal (dim, *shape) and surface divergence (*shape) of a vector field."""
        surface = self.space.boundary.patches[patch].surface
        control = np.moveaxis(self.patch_coefficients(patch), 0, -1)
        x = surface.derivatives(1, *parameters)
        f = replace(surface, points=control).derivatives(1, *parameters)
        first = sorted((key for key in x if sum(key) == 1), reverse=True)
        tangents = [x[key] for key in first]
        normal, duals = area_vector(*tangents), dual_tangents(*tangents)
        rates = [(f[key] * dual).sum(axis=0) for key, dual in zip(first, duals, strict=True)]
        return normal / np.linalg.norm(normal, axis=0), np.sum(rates, axis=0)

    def nodes(self, patch: int) -> tuple[list[Array], SurfacePoints, Array]:
        """Parameters, points and weights of a Gauss rule that suits the field's degree."""
        element = self.space.boundary.patches[patch]
        order = max(element.surface.degrees) + 8
        points, weights = element.quadrature(order)
        return _element_parameters(element.surface, order), points, weights

    def quadrature(self, patch: int) -> tuple[Array, SurfacePoints, Array]:
        """Values (dim, N), points and weights of the same rule."""
        parameters, points, weights = self.nodes(patch)
        return self.on_patch(patch, *parameters), points, weights

    def integral(self, patch: int) -> Array:
        """Integral (dim,) over one patch."""
        values, _, weights = self.quadrature(patch)
        return values @ weights


def discontinuous_space(boundary: Boundary, end_shift: float = END_SHIFT) -> Space:
    """Each patch has its own unknowns; no collocation point lies on an edge of a patch.

    Where a patch has one element along a parameter, collocation is at Gauss points: integrals of
    residuals then nearly vanish as in Galerkin's method, and so do errors of forces and flow rates.
    Elsewhere it is at Greville abscissae, the first and last of each direction moved inwards by
    ``end_shift`` times the distance to the next (Marussig et al. 2015), so that corners and
    edges, where tractions jump, need no special treatment.
    """
    parameters, points, offsets = [], [], [0]
    for patch in boundary.patches:
        surface = patch.surface
        axes = [
            _abscissae(p, k, end_shift)
            for p, k in zip(surface.degrees, surface.knots, strict=True)
        ]
        grid = np.stack([g.ravel() for g in np.meshgrid(*axes, indexing="ij")])
        parameters.append(grid)
        points.append(surface_points(surface, *grid))
        offsets.append(offsets[-1] + grid.shape[1])
    return Space(boundary, tuple(offsets), tuple(parameters), join(points))


def _abscissae(degree: int, knots: Array, share: float) -> Array:
    if len(knots) == 2 * degree + 2:
        return knots[0] + (knots[-1] - knots[0]) * gauss_unit(degree + 1)[0]
    abscissae = greville(degree, knots)
    shifted = abscissae.copy()
    shifted[0] += share * (abscissae[1] - abscissae[0])
    shifted[-1] -= share * (abscissae[-1] - abscissae[-2])
    return shifted


def rational_basis(surface: Nurbs, parameters: ArrayLike) -> csr_array:
    """All functions R = w N / W of a spline at parameters (p, m): sparse (m, n)."""
    numbers = np.zeros((1, 1), dtype=np.int64)
    values = np.ones((1, 1))
    shape = surface.weights.shape
    for p, k, u, n in zip(
        surface.degrees, surface.knots, np.asarray(parameters), shape, strict=True
    ):
        first, table = basis_functions(p, k, u)
        here = first[:, None] + np.arange(p + 1)
        numbers = (numbers[:, :, None] * n + here[:, None]).reshape(len(here), -1)
        values = (values[:, :, None] * table[0].T[:, None]).reshape(len(here), -1)
    values = values * surface.weights.ravel()[numbers]
    values /= values.sum(axis=1, keepdims=True)
    starts = np.arange(0, values.size + 1, values.shape[1])
    return csr_array(
        (values.ravel(), numbers.ravel(), starts), shape=(len(values), surface.weights.size)
    )


def _element_parameters(surface: Nurbs, order: int) -> list[Array]:
    rules = [gauss_on_breaks(order, surface.breaks(d)) for d in range(len(surface.degrees))]
    return tensor_rule(rules)[0]
