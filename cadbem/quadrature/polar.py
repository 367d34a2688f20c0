"""Singular and nearly singular rules on surfaces: polar around the closest point of a panel.

The panel is cut into triangles from the closest point to its edges, in coordinates that make the
surface's metric there the identity.  In a triangle of height h, the angle is replaced by
t = asinh(tan θ), so that the opening may approach a straight angle (Hayami); the radius is linear
for a target on the panel, and ρ = d sinh(s) for one at a distance d (Johnston and Elliott).  Both
leave integrands that are analytic in a strip of half width π/2, hence a Gauss order for a
tolerance: a range of length 2a needs ln(1/tolerance) / (2 asinh(π / 2a)) nodes.
"""

from __future__ import annotations

from math import asinh, ceil, cosh, exp, log, pi, sinh, sqrt

import numpy as np
from numpy.typing import NDArray

from cadbem.compiled import compiled
from cadbem.quadrature.gauss import MAX_ORDER
from cadbem.quadrature.panels import Array, metric, side_extents

WHOLE = (0.0, 0.0, 1.0, 1.0)


@compiled
def _order(length, digits, extra):
    """Gauss order for a range of the given length (see the top of this file)."""
    need = digits / (2.0 * asinh(pi / max(length, 0.5)))
    return min(max(int(ceil(need)) + extra, 2), MAX_ORDER)


def collapsed_sides(nets: Array) -> NDArray[np.int64] | None:
    """Which side of each panel is a point, as a pole: 0 v = 0, 1 u = 1, 2 v = 1, 3 u = 0; -1 none.

    None where all panels have four sides, so that nothing for poles is compiled.
    """
    extents = side_extents(nets)
    collapsed = extents.min(axis=0) < 1e-9
    return np.where(collapsed, extents.argmin(axis=0), -1) if collapsed.any() else None


@compiled
def _box(side, near, far):
    """Corners (u0, v0, u1, v1) of the strip between two depths from a side."""
    if side == 0:
        return 0.0, near, 1.0, far
    if side == 1:
        return 1.0 - far, 0.0, 1.0 - near, 1.0
    if side == 2:
        return 0.0, 1.0 - far, 1.0, 1.0 - near
    return near, 0.0, far, 1.0


@compiled
def _square(a, b):
    """Square of the distance of two points."""
    square = 0.0
    for c in range(len(a)):
        square += (a[c] - b[c]) * (a[c] - b[c])
    return square


@compiled
def collapsed_side_nodes(net, side, u, v, distance, tolerance, gauss, nodes, work):
    """As ``polar_nodes`` for a panel with one side that is a point.

    Strips that halve towards the pole, down to the target's own distance from it, are ordinary
    panels; what remains is polar by itself and far enough from the target for a tensor rule.
    """
    bu, du, bv, dv, point, tu, tv = work
    foot, pole = np.empty(len(point)), np.empty(len(point))
    metric(net, u, v, bu, du, bv, dv, foot, tu, tv)
    corner = _box(side, 0.0, 1.0)
    metric(net, corner[0] if side != 1 else 1.0, corner[1] if side != 2 else 1.0,
           bu, du, bv, dv, pole, tu, tv)  # fmt: skip
    own = (v, 1.0 - u, 1.0 - v, u)[side]
    middle = _box(side, 1.0, 1.0)
    metric(net, middle[0] if side % 2 else 0.5, 0.5 if side % 2 else middle[1],
           bu, du, bv, dv, point, tu, tv)  # fmt: skip
    stop = max(own, distance / sqrt(_square(point, pole)))
    far, count = 1.0, 0
    while far > 0.5 * stop and far > 1e-12:
        low_u, low_v, high_u, high_v = box = _box(side, 0.5 * far, far)
        strip_u, strip_v = min(max(u, low_u), high_u), min(max(v, low_v), high_v)
        metric(net, strip_u, strip_v, bu, du, bv, dv, point, tu, tv)
        away = sqrt(distance * distance + _square(point, foot))
        if strip_u == u and strip_v == v:
            away = distance
        room = nodes[:, count:]
        more = polar_nodes(net, strip_u, strip_v, away, box, tolerance, gauss, room, work)
        if more < 0:
            return -1
        count += more
        far *= 0.5
    order = min(int(ceil(0.5 * (-log(tolerance) + 2.0))), MAX_ORDER)
    return _tensor_nodes(_box(side, 0.0, far), order, gauss, nodes, count)


@compiled
def _tensor_nodes(box, order, gauss, nodes, count):
    """Nodes of a tensor rule on a box, from ``count`` on; returns their number, -1 if too many."""
    if count + order * order > nodes.shape[1]:
        return -1
    low_u, low_v, high_u, high_v = box
    for i in range(order):
        for j in range(order):
            nodes[0, count] = low_u + (high_u - low_u) * gauss[0, order, i]
            nodes[1, count] = low_v + (high_v - low_v) * gauss[0, order, j]
            area = (high_u - low_u) * (high_v - low_v)
            nodes[2, count] = area * gauss[1, order, i] * gauss[1, order, j]
            count += 1
    return count


@compiled
def polar_nodes(net, u, v, distance, box, tolerance, gauss, nodes, work):
    """Nodes (3, capacity): u, v, weight (without Jacobian) into ``nodes``; returns their number.

    (u, v) is the closest point of the part ``box`` (u0, v0, u1, v1) of the panel and
    ``distance`` that of the target; 0 for a target on the panel.  Returns -1 when the capacity
    is too small.
    """
    degree = max(net.shape[0], net.shape[1]) - 1
    a, b, c = root = _metric_root(net, u, v, work)
    digits = -log(tolerance) + 2.0
    low_u, low_v, high_u, high_v = box
    count = 0
    for side in range(4):
        # corners counter-clockwise
        u1, v1 = high_u if side % 3 else low_u, high_v if side > 1 else low_v
        u2, v2 = high_u if side < 2 else low_u, high_v if side % 3 else low_v
        x1, y1 = a * (u1 - u) + b * (v1 - v), c * (v1 - v)
        x2, y2 = a * (u2 - u) + b * (v2 - v), c * (v2 - v)
        edge = (x1, y1, x2, y2)
        count = _triangle(edge, root, u, v, distance, degree, digits, gauss, nodes, count)
        if count < 0:
            return -1
    return count


@compiled
def _metric_root(net, u, v, work):
    """The triangular root a, b, c of the metric at a point: x = a du + b dv, y = c dv."""
    bu, du, bv, dv, point, tu, tv = work
    e, f, g = metric(net, u, v, bu, du, bv, dv, point, tu, tv)
    if e * g - f * f <= 1e-8 * e * g or e == 0.0 or g == 0.0:
        e, f, g = metric(net, 0.5, 0.5, bu, du, bv, dv, point, tu, tv)
    a, b = sqrt(e), f / sqrt(e)
    return a, b, sqrt(max(g - b * b, 1e-12 * g))


@compiled
def _triangle(edge, root, u, v, distance, degree, digits, gauss, nodes, count):
    """Nodes in the triangle from the closest point to an ``edge`` (x1, y1, x2, y2), from ``count``
    on; returns their number, -1 if too many."""
    x1, y1, x2, y2 = edge
    ex, ey = x2 - x1, y2 - y1
    length = sqrt(ex * ex + ey * ey)
    ex, ey = ex / length, ey / length
    height = x1 * ey - y1 * ex
    if height <= 1e-14 * length:
        return count
    fx, fy = x1 - (x1 * ex + y1 * ey) * ex, y1 - (x1 * ex + y1 * ey) * ey
    t1, t2 = asinh((x1 * ex + y1 * ey) / height), asinh((x2 * ex + y2 * ey) / height)
    extra = (degree + 1) // 2
    m_t = _order(t2 - t1, digits, extra)
    for i in range(m_t):
        t = t1 + (t2 - t1) * gauss[0, m_t, i]
        weight_t = (t2 - t1) * gauss[1, m_t, i] / cosh(t)
        along, reach = height * sinh(t), height * cosh(t)
        dir_x, dir_y = (fx + along * ex) / reach, (fy + along * ey) / reach
        if distance > 0.0:
            top = asinh(reach / distance)
            m_r = _order(top, digits, extra)
        else:
            top = reach
            m_r = min(degree + 2 + int(ceil(digits / 6.0)), MAX_ORDER)
        if count + m_r > nodes.shape[1]:
            return -1
        ray = (weight_t, top, dir_x, dir_y)
        count = _ray(ray, m_r, root, u, v, distance, gauss, nodes, count)
    return count


@compiled
def _ray(ray, order, root, u, v, distance, gauss, nodes, count):
    """Nodes along one ``ray``: its weight, the range of the radius, and its direction."""
    weight_t, top, dir_x, dir_y = ray
    a, b, c = root
    for j in range(order):
        s = top * gauss[0, order, j]
        weight = weight_t * top * gauss[1, order, j]
        rho = s
        if distance > 0.0:
            # sinh and cosh; a small radius loses digits, but none of the distance to the target
            grown = exp(s)
            rho = 0.5 * distance * (grown - 1.0 / grown)
            weight *= 0.5 * distance * (grown + 1.0 / grown)
        step_v = rho * dir_y / c
        nodes[0, count] = u + (rho * dir_x - b * step_v) / a
        nodes[1, count] = v + step_v
        nodes[2, count] = weight * rho / (a * c)
        count += 1
    return count
