"""Layers of a closed spline at points off it: inside, outside, close by.

The even grid of nodes that serves the spline itself integrates accurately for targets some spacings
away.  For closer ones a window around the nearest point of the surface is integrated in polar
coordinates that crowd there, as in ``quadrature/closed.py``.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.spatial import cKDTree

from cadbem.closed_points import collocation_grid
from cadbem.kernels.kernel import Sums
from cadbem.kernels.stokes_sums import stokes_sums
from cadbem.operators.closed import ClosedLayers
from cadbem.points import area_vector, dual_tangents
from cadbem.quadrature.closed import PolarRule
from cadbem.spline.basis import Array
from cadbem.spline.closed import ClosedSpline, unit_parameters, unit_point

NEWTON_STEPS = 20


def off_surface(
    layers: ClosedLayers, single: Array | None, double: Array | None, points: Array
) -> Array:
    """∫ G q dS + ∫ u·T·n dS (dim, M) at points (dim, M) off the surface, n outwards.

    ``single`` and ``double`` are coefficients (dim, *shape) of q and u, or None for zero.
    """
    points = np.ascontiguousarray(points, dtype=float)
    field = _Field(layers, single, double)
    result = field.far(points)
    close = np.nonzero(too_close(layers, points))[0]
    feet = nearest_points(layers.spline, points[:, close])
    for k, foot in zip(close, feet.T, strict=True):
        result[:, k] += field.near(points[:, k], foot)
    return result


def too_close(layers: ClosedLayers, points: Array) -> Array:
    """Which points are so near that the even grid would miss the tolerance: bool (M,).

    Its error falls like exp(-2π d / s) at a distance d, with the spacing s.
    """
    rule, nodes = layers.operator.rule, layers.points
    if not isinstance(rule, PolarRule) or not points.size:
        return np.zeros(points.shape[1], dtype=bool)
    steps = [float(axis[1] - axis[0]) for axis in layers.operator.nodes.axes]
    spacing = np.max(
        [s * np.linalg.norm(t, axis=0) for s, t in zip(steps, nodes.tangents, strict=True)], axis=0
    )
    reach = spacing * (0.5 - np.log(rule.tolerance) / (2 * np.pi))
    distance, nearest = cKDTree(nodes.position.T).query(points.T)
    return distance < reach[nearest]


def nearest_points(spline: ClosedSpline, points: Array) -> Array:
    """Parameters (p, M) of the surface points nearest to points (dim, M).

    From the nearest collocation point, Gauss-Newton steps on the unit circle or sphere; far
    outside they are shortened, where the surface curves away from the point.
    """
    if not points.size:
        return np.zeros((spline.dimension - 1, 0))
    known = collocation_grid(spline.basis).points(spline)
    distance, start = cKDTree(known.position.T).query(points.T)
    damping = 1 / (1 + distance * np.abs(known.curvature).max())
    at = spline.basis.parameters()[:, start]
    for _ in range(NEWTON_STEPS):
        tangents, frame = _tangents(spline, at)
        duals = np.stack(dual_tangents(*tangents))
        step = np.einsum("acn,cn->an", duals, points - spline.evaluate(at))
        length = np.linalg.norm(step, axis=0)
        step *= np.minimum(damping, 0.5 / np.maximum(length, 1e-300))
        at = unit_parameters(unit_point(*at) + np.einsum("an,acn->cn", step, frame))
    return at


def _tangents(spline: ClosedSpline, at: Array) -> tuple[Array, Array]:
    """Derivatives along orthonormal directions of the unit circle or sphere, and these (p, dim,
    M)."""
    if spline.dimension == 2:
        frame = np.stack([-np.sin(at[0]), np.cos(at[0])])[None]
        return spline.evaluate(at, (1,))[None], frame
    theta, phi = at
    sine = np.maximum(np.sin(theta), 1e-12)
    south = np.stack([np.cos(theta) * np.cos(phi), np.cos(theta) * np.sin(phi), -np.sin(theta)])
    east = np.stack([-np.sin(phi), np.cos(phi), 0 * phi])
    tangents = [spline.evaluate(at, (1, 0)), spline.evaluate(at, (0, 1)) / sine]
    return np.stack(tangents), np.stack([south, east])


@dataclass(frozen=True, eq=False)
class _Field:
    """Both layers with densities, at single points near the surface and many points far away."""

    layers: ClosedLayers
    single: Array | None
    double: Array | None

    @cached_property
    def _sums(self) -> Sums:
        return stokes_sums(self.layers.spline.dimension)

    @cached_property
    def _nodes(self) -> list[Array]:
        """Positions, area vectors, q J and u (dim, nodes) at the grid's nodes, without weights."""
        layers, grid = self.layers, self.layers.operator.grid
        densities = [None if c is None else grid.values(c) for c in (self.single, self.double)]
        empty = np.zeros_like(layers.points.position)
        single = empty if densities[0] is None else densities[0] * layers.points.jacobian
        double = empty if densities[1] is None else densities[1]
        return [
            np.ascontiguousarray(a) for a in (layers.points.position, layers.area, single, double)
        ]

    @cached_property
    def _tables(self) -> tuple[Array, Array]:
        """All of them as splines and as values, for ``gather``."""
        values = np.concatenate(self._nodes)
        operator = self.layers.operator
        return operator.padded(values), operator.on_rows(values)

    def far(self, points: Array) -> Array:
        """The even grid's sums."""
        out, weights = np.zeros(points.shape), self.layers.operator.weights
        position, area, single, double = self._nodes
        if self.single is not None:
            self._sums.single(points, position, single * weights, out)
        if self.double is not None:
            self._sums.double(points, np.zeros_like(out), position, area * weights, double, out)
        return out

    def near(self, point: Array, foot: Array) -> Array:
        """What a window around the nearest point changes: (dim,)."""
        operator, dim = self.layers.operator, len(point)
        tangents, _ = _tangents(self.layers.spline, foot[:, None])
        stretch = np.linalg.norm(area_vector(*tangents)) ** (1 / (dim - 1))
        gap = np.linalg.norm(point - self.layers.spline.evaluate(foot[:, None])[:, 0])
        table = operator.table(operator.nodes.near(foot, max(float(gap / stretch), 1e-12)))
        values = table.fields(*self._tables, 4 * dim, targets=1, weighted=False)
        position, area, single, double = values.reshape(4, dim, -1, 1)
        weights = np.concatenate([table.weights, table.corrections])[:, None]
        target, out = np.ascontiguousarray(point[:, None]), np.zeros((dim, 1))
        if self.single is not None:
            self._sums.single_near(target, position, single * weights, out)
        if self.double is not None:
            zero = np.zeros((dim, 1))
            self._sums.double_near(target, zero, position, area * weights, double, out)
        return out[:, 0]
