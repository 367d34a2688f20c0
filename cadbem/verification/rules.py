"""Integrals over one surface for one target: our rule, and that of the thesis."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from cadbem.operators.panels import split_patch
from cadbem.points import surface_points
from cadbem.quadrature import near
from cadbem.quadrature.panels import closest_on_panels, open_squares
from cadbem.quadrature.polar import WHOLE, collapsed_sides
from cadbem.quadrature.uniform import subdivided_nodes, triangle_nodes
from cadbem.spline.basis import Array
from cadbem.spline.nurbs import Nurbs

CAPACITY = 100_000  # nodes; a pair of a target and a panel takes some thousands at most


def near_rule(
    surface: Nurbs, target: ArrayLike, tolerance: float, own: tuple[float, float] | None = None
) -> tuple[Array, Array]:
    """Nodes (3, n) and weights (n,), Jacobian included, of our rule for one target (3,).

    ``own`` (u, v) says that the target lies on the surface there, which has one element then.
    """
    panels = split_patch(surface)
    nets = panels.flat_nets
    index = np.arange(len(nets))
    closest = np.empty((3, len(nets)))
    u, v, samples = panels.samples
    x = np.asarray(target, dtype=float).reshape(3, 1)
    closest_on_panels(x, 0 * index, index, nets, open_squares(nets), u, v, samples, closest)
    if own is not None:
        closest[:, 0] = *own, 0.0
    p, q = surface.degrees
    position, normal, weight = np.empty((3, CAPACITY)), np.empty((3, CAPACITY)), np.empty(CAPACITY)
    bu, bv = np.empty((p + 1, CAPACITY)), np.empty((q + 1, CAPACITY))
    starts, foot = np.empty(len(nets) + 1, dtype=np.int64), np.empty((3, len(nets)))
    done = near.place_nodes(
        nets, WHOLE, collapsed_sides(nets), index, 0, *closest,
        tolerance, None, 0, near.gauss_table(),
        starts, foot, None, position, normal, weight, bu, bv,
    )  # fmt: skip
    assert done == len(nets)
    owner = np.repeat(index, np.diff(starts))
    count = starts[-1]
    function = np.einsum("kij,ik,jk->k", nets[owner, :, :, 3], bu[:, :count], bv[:, :count])
    return position[:, :count] + foot[:, owner], weight[:count] * function


def even_rule(surface: Nurbs, parts: int, order: int = 10) -> tuple[Array, Array]:
    """The thesis's nodes and weights: Gauss points of an ``order`` on parts × parts equal parts of
    the surface's parameters."""
    nodes = np.empty((3, (order * parts) ** 2))
    subdivided_nodes(order, parts, near.gauss_table(), nodes)
    points = surface_points(surface, nodes[0], nodes[1])
    return points.position, nodes[2] * points.jacobian


def triangle_rule(surface: Nurbs, own: tuple[float, float], order: int) -> tuple[Array, Array]:
    """The thesis's nodes and weights for a target on the surface at ``own`` (u, v): polar
    coordinates of the parameters in four triangles, order² points each."""
    nodes = np.empty((3, 4 * order * order))
    nodes = nodes[:, : triangle_nodes(*own, order, near.gauss_table(), nodes)]
    points = surface_points(surface, nodes[0], nodes[1])
    return points.position, nodes[2] * points.jacobian
