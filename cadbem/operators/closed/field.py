"""Layers of a closed spline at points off it: inside, outside, close by.

The even grid of nodes that serves the spline itself integrates accurately for targets some spacings
away.  For closer ones a window around the nearest point of the surface is integrated in polar
coordinates that neighbours there, as in ``quadrature/closed.py``.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.spatial import cKDTree

from cadbem.kernels.kernel import Index
from cadbem.operators.closed.layers import ClosedLayers
from cadbem.operators.closed.windows import Windows
from cadbem.operators.far.equivalent import Sources
from cadbem.quadrature.closed import PolarRule
from cadbem.spline.basis import Array


@dataclass(frozen=True, eq=False)
class OffSurface:
    """Both layers at ``points`` (dim, M) off the surface, as often as densities change."""

    layers: ClosedLayers
    points: Array

    def apply(self, single: Array | None, double: Array | None) -> Array:
        """∫ G q dS + ∫ u·T·n dS (dim, M), n outwards.

        ``single`` are values q (dim, nodes) at the even grid's nodes, ``double`` coefficients
        (dim, *shape) of u; None stands for zero.  A jump of the traction has as many derivatives
        of the shape in it that a spline through its values at the collocation points has a net
        force of its own.
        """
        result = np.zeros(self.points.shape)
        densities = at_nodes(self.layers, single, double)
        _weighted(self.layers, *densities).add_to(self.points, result)
        result[:, self._close] += self._windows.apply(*densities)
        return result

    @cached_property
    def _close(self) -> Index:
        """Numbers of the points that need a window."""
        return np.nonzero(too_close(self.layers, self.points))[0]

    @cached_property
    def _windows(self) -> Windows:
        return Windows(self.layers, self.points[:, self._close])


def even_sources(layers: ClosedLayers, single: Array | None, double: Array | None) -> Sources:
    """The even grid's nodes with densities as in ``OffSurface.apply``."""
    return _weighted(layers, *at_nodes(layers, single, double))


def at_nodes(
    layers: ClosedLayers, single: Array | None, double: Array | None
) -> tuple[Array | None, Array | None]:
    """q J and u (dim, nodes) at the grid's nodes, without weights: see ``OffSurface.apply``."""
    values = layers.operator.grid.values
    return (
        None if single is None else single * layers.points.jacobian,
        None if double is None else np.ascontiguousarray(values(double)),
    )


def _weighted(layers: ClosedLayers, single: Array | None, double: Array | None) -> Sources:
    weights = layers.operator.weights
    position = np.ascontiguousarray(layers.points.position)
    if single is not None:
        single = single * weights
    return Sources(position, single, layers.area * weights, double)


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
