"""Points of a boundary with normals, Jacobians and tangents, by field name."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cadbem.spline.basis import Array
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
