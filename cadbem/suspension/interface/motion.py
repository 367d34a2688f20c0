"""Rules for the motion of points on an interface: the normal velocity is that of the fluid, the
tangential velocity may be chosen.

Each rule is a function of the layers and of the coefficients of the fluid velocity that returns
coefficients.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from cadbem.closed_points import ClosedPoints
from cadbem.operators.closed.layers import ClosedLayers
from cadbem.spline.basis import Array
from cadbem.suspension.interface.equation import collocation_weights

Motion = Callable[[ClosedLayers, Array], Array]
RIDGE = 1e-2  # strain rate that costs as much as the same share of normal velocity


def full_velocity(layers: ClosedLayers, velocity: Array) -> Array:
    """Points are carried by the fluid."""
    return velocity


def normal_velocity(layers: ClosedLayers, velocity: Array) -> Array:
    """Points move along the normal only (Eq. 3.12), as in the thesis."""
    targets = layers.targets
    return _with_normal_part(layers, np.zeros_like(targets.normal), velocity)


def affine_velocity(layers: ClosedLayers, velocity: Array) -> Array:
    """Points move tangentially as if the whole body were strained evenly.

    The tangential velocity is that of the linear field a + A (x - x_c) whose normal part fits the
    fluid's best (least squares over the surface).  Ellipsoids then keep the points of the sphere
    they were, close together at their tips; points neither circulate with a tank-treading drop
    nor gather where the flow converges.  A small weight on A settles what the shape leaves
    undetermined, such as the rotation of a sphere.
    """
    targets = layers.targets
    values = layers.operator.collocation.values(velocity)
    weights = targets.jacobian * collocation_weights(layers)
    return _with_normal_part(
        layers, _affine_fit(targets, values, weights / weights.sum()), velocity
    )


def _affine_fit(targets: ClosedPoints, values: Array, weights: Array) -> Array:
    """The linear field (dim, N) with the same normal part, as nearly as possible."""
    dim, normal = len(values), targets.normal
    arm = targets.position - (targets.position @ weights)[:, None]
    size = np.sqrt((arm**2).sum(axis=0) @ weights)
    linear = (normal[:, None] * arm[None] / size).reshape(dim * dim, -1)
    columns = np.concatenate([normal, linear])
    ridge = np.repeat([0.0, RIDGE**2], [dim, dim * dim])
    system = (columns * weights) @ columns.T + np.diag(ridge)
    right = (columns * weights) @ (values * normal).sum(axis=0)
    solution = np.linalg.solve(system, right)
    return solution[:dim, None] + solution[dim:].reshape(dim, dim) @ arm / size


def _with_normal_part(layers: ClosedLayers, tangential: Array, velocity: Array) -> Array:
    """Coefficients of a field with the given tangential and the velocity's normal part."""
    basis, normal = layers.operator.basis, layers.targets.normal
    values = layers.operator.collocation.values(velocity)
    mixed = tangential + normal * ((values - tangential) * normal).sum(axis=0)
    return basis.fit(mixed.reshape(-1, *basis.shape))
