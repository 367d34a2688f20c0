"""The thesis's rules: uniform subdivision for close targets, plain polar coordinates for own ones.

They serve for comparison; ``cadbem.quadrature.near`` is more accurate at any distance.
"""

from __future__ import annotations

from math import atan2, cos, pi, sin

from cadbem.compiled import compiled

CORNERS = ((0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0), (0.0, 0.0))  # counter-clockwise


@compiled
def thesis_nodes(u, v, distance, order, pieces, gauss, nodes):
    """Nodes for the closest point (u, v) of a panel to a target, at a ``distance`` or on it."""
    if distance == 0.0:
        return triangle_nodes(u, v, order, gauss, nodes)
    return subdivided_nodes(order, pieces, gauss, nodes)


@compiled
def subdivided_nodes(order, pieces, gauss, nodes):
    """Tensor Gauss rule of ``order`` on pieces × pieces parts of the unit square.

    Fills ``nodes`` (3, capacity) with u, v, weight; returns their number, -1 without room.
    """
    if (order * pieces) ** 2 > nodes.shape[1]:
        return -1
    count = 0
    for a in range(pieces):
        for i in range(order):
            u = (a + gauss[0, order, i]) / pieces
            for b in range(pieces):
                for j in range(order):
                    nodes[0, count] = u
                    nodes[1, count] = (b + gauss[0, order, j]) / pieces
                    nodes[2, count] = gauss[1, order, i] * gauss[1, order, j] / (pieces * pieces)
                    count += 1
    return count


@compiled
def triangle_nodes(u, v, order, gauss, nodes):
    """Polar coordinates of the parameters around (u, v), in four triangles with order² nodes."""
    if 4 * order * order > nodes.shape[1]:
        return -1
    count = 0
    for side in range(4):
        x1, y1 = CORNERS[side][0] - u, CORNERS[side][1] - v
        x2, y2 = CORNERS[side + 1][0] - u, CORNERS[side + 1][1] - v
        area = x1 * y2 - x2 * y1
        if area <= 1e-14:
            continue
        start, opening = atan2(y1, x1), atan2(y2, x2) - atan2(y1, x1)
        opening += 2.0 * pi if opening < 0.0 else 0.0
        for i in range(order):
            angle = start + opening * gauss[0, order, i]
            c, s = cos(angle), sin(angle)
            reach = area / (c * (y2 - y1) - s * (x2 - x1))
            for j in range(order):
                rho = reach * gauss[0, order, j]
                nodes[0, count] = u + rho * c
                nodes[1, count] = v + rho * s
                weight = opening * gauss[1, order, i] * reach * gauss[1, order, j]
                nodes[2, count] = weight * rho
                count += 1
    return count
