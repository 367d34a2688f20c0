"""Points of a boundary with normals, Jacobians and tangents, by field name."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cadbem.quadrature.gauss import gauss_on_breaks
from cadbem.spline.basis import Array, basis_matrices
from cadbem.spline.nurbs import Nurbs


@dataclass(frozen=True, eq=False)
class SurfacePoints:
    """N points of a surface (dim = 3) or curve (dim = 2).

    ``position`` and unit ``normal`` (dim, N); ``jacobian`` (N,), area or length per unit of
    parameter; ``tangents`` (dim - 1, dim, N), the derivatives of position.
    """

    position: Array
    normal: Array
    jacobian: Array
    tangents: Array

    @property
    def count(self) -> int:
        """Number of points."""
        return self.position.shape[1]

    def chosen(self, which: NDArray[np.bool_]) -> SurfacePoints:
        """Some of the points (N,)."""
        return SurfacePoints(
            self.position[:, which], self.normal[:, which], self.jacobian[which],
            self.tangents[:, :, which],
        )  # fmt: skip


def surface_points(spline: Nurbs, *parameters: ArrayLike) -> SurfacePoints:
    """Points at flat parameter arrays.

    The normal is x_u × x_v on a surface, and on a plane curve the right of its direction, which
    is outward when the curve runs counter-clockwise.
    """
    derivatives = spline.derivatives(1, *parameters)
    flat = {key: value.reshape(spline.dimension, -1) for key, value in derivatives.items()}
    first = sorted((key for key in flat if sum(key) == 1), reverse=True)
    tangents = np.stack([flat[key] for key in first])
    normal = area_vector(*tangents)
    jacobian = np.linalg.norm(normal, axis=0)
    position = flat[(0,) * len(spline.degrees)]
    unit = normal / np.where(jacobian > 0, jacobian, 1.0)
    return SurfacePoints(position, unit, jacobian, tangents)


def area_vector(*tangents: Array) -> Array:
    """Normal as long as the Jacobian: x_u × x_v, or the right of a plane curve's tangent."""
    if len(tangents) == 1:
        return np.stack([tangents[0][1], -tangents[0][0]])
    (a, b, c), (d, e, f) = tangents  # np.cross moves axes about first, which costs more than this
    return np.stack([b * f - c * e, c * d - a * f, a * e - b * d])


def moment(arm: Array, force: Array) -> Array:
    """arm × force (3, N) of vectors (3, N); in a plane its only component (1, N)."""
    if len(arm) == 2:
        return (arm[0] * force[1] - arm[1] * force[0])[None]
    return np.cross(arm, force, axis=0)


def dual_tangents(*tangents: Array) -> list[Array]:
    """Vectors in the tangent plane with products 1 and 0 with the tangents."""
    if len(tangents) == 1:
        return [tangents[0] / (tangents[0] ** 2).sum(axis=0)]
    normal = area_vector(*tangents)
    normal /= (normal**2).sum(axis=0)
    return [area_vector(tangents[1], normal), area_vector(normal, tangents[0])]


def join(parts: list[SurfacePoints]) -> SurfacePoints:
    """Several sets of points as one."""
    return SurfacePoints(
        np.concatenate([p.position for p in parts], axis=-1),
        np.concatenate([p.normal for p in parts], axis=-1),
        np.concatenate([p.jacobian for p in parts], axis=-1),
        np.concatenate([p.tangents for p in parts], axis=-1),
    )


def gauss_measures(splines: Sequence[Nurbs], order: int) -> tuple[Array, Array, Array]:
    """Gauss points (dim, N) of all splines, ``order`` a direction in each element, spline by
    spline; normals (dim, N), as long as the Jacobian; weights (N,) of the parameters.

    Splines with the same knots, up to their scale, are evaluated together.
    """
    groups: dict[tuple, list[int]] = {}
    for index, spline in enumerate(splines):
        relative = [np.round((k - k[0]) / (k[-1] - k[0]), 12).tobytes() for k in spline.knots]
        key = (spline.degrees, spline.dimension, *relative)
        groups.setdefault(key, []).append(index)
    found: list[tuple[Array, Array, Array]] = [(np.empty(0),) * 3] * len(splines)
    for indices in groups.values():
        *fields, weights = _measures_together([splines[i] for i in indices], order)
        for index, position, normal in zip(indices, *fields, strict=True):
            found[index] = position, normal, weights
    position, normal, weight = (np.concatenate(part, axis=-1) for part in zip(*found, strict=True))
    return position, normal, weight


def _measures_together(splines: list[Nurbs], order: int) -> tuple[Array, Array, Array]:
    """Positions and normals (splines, dim, N) and weights (N,) over parameters from 0 to 1."""
    control = np.stack([spline.homogeneous for spline in splines])
    values, rules = [], []
    for degree, knots in zip(splines[0].degrees, splines[0].knots, strict=True):
        scaled = (knots - knots[0]) / (knots[-1] - knots[0])
        nodes, weights = gauss_on_breaks(order, np.unique(scaled))
        values.append(basis_matrices(degree, scaled, nodes, 1))
        rules.append(weights)
    kinds = [(0,), (1,)] if len(rules) == 1 else [(0, 0), (1, 0), (0, 1)]
    point, *slopes = (_applied(control, [v[k] for v, k in zip(values, kind, strict=True)])
                      for kind in kinds)  # fmt: skip
    position = point[:, :-1] / point[:, -1:]
    tangents = [(s[:, :-1] - s[:, -1:] * position) / point[:, -1:] for s in slopes]
    normal = area_vector(*(tangent.swapaxes(0, 1) for tangent in tangents)).swapaxes(0, 1)
    weights = rules[0] if len(rules) == 1 else np.multiply.outer(*rules).ravel()
    return position, normal, weights


def _applied(control: Array, matrices: list[Array]) -> Array:
    """Control points (splines, n_1[, n_2], dim + 1) by matrices (m, n): (splines, dim + 1, M)."""
    for matrix in matrices:  # the axis goes to the end, and the next one comes up
        control = np.tensordot(control, matrix, axes=(1, 1))
    return control.reshape(len(control), control.shape[1], -1)
