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
from cadbem.kernels.kernel import Index, Sums
from cadbem.kernels.stokes_sums import stokes_sums
from cadbem.operators.closed import ClosedLayers
from cadbem.operators.closed_nearest import nearest_points
from cadbem.operators.equivalent import Sources
from cadbem.operators.gather import NearTable
from cadbem.points import area_vector, dual_tangents
from cadbem.quadrature.closed import PolarRule
from cadbem.spline.basis import Array
from cadbem.spline.closed import ClosedSpline, unit_parameters, unit_point


def even_sources(layers: ClosedLayers, single: Array | None, double: Array | None) -> Sources:
    """The even grid's nodes with densities as in ``OffSurface.apply``."""
    return _Field(layers, single, double).sources


@dataclass(frozen=True, eq=False)
class OffSurface:
    """Both layers at ``points`` (dim, M) off the surface, as often as densities change."""

    layers: ClosedLayers
    points: Array

    def apply(self, single: Array | None, double: Array | None) -> Array:
        """∫ G q dS + ∫ u·T·n dS (dim, M), n outwards.

        ``single`` and ``double`` are coefficients (dim, *shape) of q and u, or None for zero.
        """
        result = np.zeros(self.points.shape)
        field = _Field(self.layers, single, double)
        field.sources.add_to(self.points, result)
        for k, window in zip(self._close, self._windows, strict=True):
            result[:, k] += field.near(window)
        return result

    @cached_property
    def _close(self) -> Index:
        """Numbers of the points that need a window."""
        return np.nonzero(too_close(self.layers, self.points))[0]

    @cached_property
    def _windows(self) -> list[Window]:
        points = self.points[:, self._close]
        feet = nearest_points(self.layers.spline, points)
        return [_window(self.layers, *pair) for pair in zip(points.T, feet.T, strict=True)]


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
class Window:
    """Nodes around the point of a surface that is nearest to a target (dim, 1): ``position`` and
    ``area`` vectors (dim, K, 1), the former unweighted, and ``weights`` (K, 1)."""

    target: Array
    table: NearTable
    position: Array
    area: Array
    weights: Array


def _window(layers: ClosedLayers, point: Array, foot: Array) -> Window:
    operator, dim = layers.operator, len(point)
    tangents, _ = _tangents(layers.spline, foot[:, None])
    stretch = np.linalg.norm(area_vector(*tangents)) ** (1 / (dim - 1))
    gap = np.linalg.norm(point - layers.spline.evaluate(foot[:, None])[:, 0])
    table = operator.table(operator.nodes.near(foot, max(float(gap / stretch), 1e-12)))
    values = table.fields(*layers.tables, 2 * dim, targets=1, weighted=False)
    position, area = values.reshape(2, dim, -1, 1)
    weights = np.concatenate([table.weights, table.corrections])[:, None]
    return Window(np.ascontiguousarray(point[:, None]), table, position, area * weights, weights)


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
    def _densities(self) -> list[Array | None]:
        """q J and u (dim, nodes) at the grid's nodes, without weights."""
        values = self.layers.operator.grid.values
        return [
            None if self.single is None else values(self.single) * self.layers.points.jacobian,
            None if self.double is None else np.ascontiguousarray(values(self.double)),
        ]

    @cached_property
    def sources(self) -> Sources:
        """The even grid's nodes."""
        weights = self.layers.operator.weights
        single, double = self._densities
        if single is not None:
            single = single * weights
        position = np.ascontiguousarray(self.layers.points.position)
        return Sources(position, single, self.layers.area * weights, double)

    @cached_property
    def _tables(self) -> tuple[Array, Array]:
        """Densities as splines and as values, for ``gather``."""
        present = np.concatenate([d for d in self._densities if d is not None])
        return self.layers.operator.padded(present), self.layers.operator.on_rows(present)

    def near(self, window: Window) -> Array:
        """What a window around the nearest point changes: (dim,)."""
        dim = len(window.target)
        count = dim * sum(d is not None for d in self._densities)
        values = window.table.fields(*self._tables, count, targets=1, weighted=False)
        parts = list(values.reshape(-1, dim, *values.shape[1:]))
        out = np.zeros((dim, 1))
        if self.single is not None:
            density = parts.pop(0) * window.weights
            self._sums.single_near(window.target, window.position, density, out)
        if self.double is not None:
            zero = np.zeros((dim, 1))
            sources = window.position, window.area, parts.pop(0)
            self._sums.double_near(window.target, zero, *sources, out)
        return out[:, 0]
