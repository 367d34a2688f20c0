"""Singular and nearly singular rules around the closest point of a panel.

On a surface they are polar.  The panel is cut into triangles from the closest point to its edges,
in coordinates that make the surface's metric there the identity.  In a triangle of height h, the
angle is replaced by t = asinh(tan θ), so that the opening may approach a straight angle (Hayami);
the radius is linear for a target on the panel, and ρ = d sinh(s) for one at a distance d (Johnston
and Elliott).  Both leave integrands that are analytic in a strip of half width π/2, hence a Gauss
order for a tolerance: a range of length 2a needs ln(1/tolerance) / (2 asinh(π / 2a)) nodes.

A curve is cut at the closest point.  To either side, the same ρ = d sinh(s) puts the nearest
singularities to iπ/2 above the end of the range, which spares nodes; a target on the curve asks
for a rule that holds the logarithm.
"""

from __future__ import annotations

from functools import lru_cache
from math import acosh, asinh, ceil, cosh, exp, log, pi, sinh, sqrt

import numpy as np
from numba import njit

from cadbem.quadrature.gauss import gauss_unit, log_unit
from cadbem.quadrature.panels import area_vector, evaluate_panel, fill_bernstein
from cadbem.quadrature.uniform import CORNERS, subdivided_nodes, triangle_nodes

MAX_ORDER = 64
TAPERED = 1.5  # share of digits that a panel asks for whose metric varies much


@lru_cache(maxsize=1)
def gauss_table():
    """Rules on [0, 1] of all orders to ``MAX_ORDER``: (4, M + 1, M).

    Nodes and weights of Gauss-Legendre, then those of ``log_unit``.
    """
    table = np.zeros((4, MAX_ORDER + 1, MAX_ORDER))
    for order in range(1, MAX_ORDER + 1):
        table[:2, order, :order] = gauss_unit(order)
        table[2:, order, :order] = log_unit(order)
    return table


@njit(cache=True, nogil=True)
def _order(length, digits, extra):
    """Gauss order for a range of the given length (see the top of this file)."""
    need = digits / (2.0 * asinh(pi / max(length, 0.5)))
    return min(max(int(ceil(need)) + extra, 2), MAX_ORDER)


@njit(cache=True, nogil=True)
def _frame(net, u, v, bu, du, bv, dv, point, tu, tv):
    """Entries (a, b, c) of the map (du, dv) -> (a du + b dv, c dv) to arc length at (u, v)."""
    fill_bernstein(net.shape[0] - 1, u, bu, du)
    fill_bernstein(net.shape[1] - 1, v, bv, dv)
    evaluate_panel(net, bu, bv, du, dv, point, tu, tv)
    e = f = g = 0.0
    for i in range(len(point)):
        e += tu[i] * tu[i]
        f += tu[i] * tv[i]
        g += tv[i] * tv[i]
    return e, f, g


@njit(cache=True, nogil=True)
def _is_tapered(net):
    """Whether opposite edges (their chords) differ much in length, as at a pole."""
    p, q, dim = net.shape[0] - 1, net.shape[1] - 1, net.shape[2] - 1
    south = north = west = east = 0.0
    for k in range(dim):
        sw, se = net[0, 0, k] / net[0, 0, dim], net[p, 0, k] / net[p, 0, dim]
        nw, ne = net[0, q, k] / net[0, q, dim], net[p, q, k] / net[p, q, dim]
        south += (se - sw) ** 2
        north += (ne - nw) ** 2
        west += (nw - sw) ** 2
        east += (ne - se) ** 2
    return min(south, north) < 0.1 * max(south, north) or min(west, east) < 0.1 * max(west, east)


@njit(cache=True, nogil=True)
def polar_nodes(net, u, v, distance, tolerance, gauss, nodes, work):
    """Nodes (3, capacity): u, v, weight (without Jacobian) into ``nodes``; returns their number.

    (u, v) is the closest point of the panel and ``distance`` that of the target; 0 for a target
    on the panel.  Returns -1 when the capacity is too small.
    """
    p, q = net.shape[0] - 1, net.shape[1] - 1
    bu, du, bv, dv, point, tu, tv = work
    e, f, g = _frame(net, u, v, bu, du, bv, dv, point, tu, tv)
    if e * g - f * f <= 1e-8 * e * g or e == 0.0 or g == 0.0:
        e, f, g = _frame(net, 0.5, 0.5, bu, du, bv, dv, point, tu, tv)
    a, b = sqrt(e), f / sqrt(e)
    c = sqrt(max(g - b * b, 1e-12 * g))
    digits = (-log(tolerance) + 2.0) * (TAPERED if _is_tapered(net) else 1.0)
    extra = (max(p, q) + 1) // 2
    count = 0
    for side in range(4):
        u1, v1 = CORNERS[side]
        u2, v2 = CORNERS[side + 1]
        x1, y1 = a * (u1 - u) + b * (v1 - v), c * (v1 - v)
        x2, y2 = a * (u2 - u) + b * (v2 - v), c * (v2 - v)
        length = sqrt((x2 - x1) ** 2 + (y2 - y1) ** 2)
        ex, ey = (x2 - x1) / length, (y2 - y1) / length
        height = x1 * ey - y1 * ex
        if height <= 1e-14 * length:
            continue
        fx, fy = x1 - (x1 * ex + y1 * ey) * ex, y1 - (x1 * ex + y1 * ey) * ey
        t1, t2 = asinh((x1 * ex + y1 * ey) / height), asinh((x2 * ex + y2 * ey) / height)
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
                m_r = min(max(p, q) + 2 + int(ceil(digits / 6.0)), MAX_ORDER)
            if count + m_r > nodes.shape[1]:
                return -1
            for j in range(m_r):
                s = top * gauss[0, m_r, j]
                weight = weight_t * top * gauss[1, m_r, j]
                rho = s
                if distance > 0.0:
                    rho = distance * sinh(s)
                    weight *= distance * cosh(s)
                step_v = rho * dir_y / c
                nodes[0, count] = u + (rho * dir_x - b * step_v) / a
                nodes[1, count] = v + step_v
                nodes[2, count] = weight * rho / (a * c)
                count += 1
    return count


@njit(cache=True, nogil=True)
def line_nodes(net, u, distance, tolerance, gauss, nodes, work):
    """As ``polar_nodes`` for a panel of a curve: nodes to either side of the closest point."""
    bu, du, bv, dv, point, tu, tv = work
    speed = sqrt(_frame(net, u, 0.0, bu, du, bv, dv, point, tu, tv)[0])
    digits, degree = -log(tolerance) + 5.0, net.shape[0] - 1
    count = 0
    for side in (-1.0, 1.0):
        span = u if side < 0.0 else 1.0 - u
        if span < 1e-14:
            continue
        top = asinh(span * speed / distance) if distance > 0.0 else 1.0
        if distance > 0.0:
            strip = acosh(exp(asinh(0.5 * pi / top)))
            order = int(ceil(digits / (2.0 * strip))) + degree
        else:
            order = int(ceil(0.55 * digits)) + degree
        order = min(order, MAX_ORDER)
        if count + order > nodes.shape[1]:
            return -1
        for i in range(order):
            if distance > 0.0:
                s = top * gauss[0, order, i]
                nodes[0, count] = u + side * distance * sinh(s) / speed
                nodes[2, count] = top * gauss[1, order, i] * distance * cosh(s) / speed
            else:
                nodes[0, count] = u + side * span * gauss[2, order, i]
                nodes[2, count] = span * gauss[3, order, i]
            nodes[1, count] = 0.0
            count += 1
    return count


@njit(cache=True, nogil=True)
def _part_from(net, u, foot, part):
    """Control points w (x - foot) of the longer part of a curve's panel from u to an end.

    The first one is the foot itself, hence zero: so differences of points near the foot, of
    which the double layer divides the square, keep their digits.
    """
    p, dim = net.shape[0] - 1, net.shape[2] - 1
    share = min(u, 1.0 - u)
    for i in range(p + 1):
        j = i if u <= 0.5 else p - i
        for c in range(dim):
            part[i, c] = net[j, 0, c] - net[j, 0, dim] * foot[c]
    for level in range(p):
        for i in range(p - level):
            for c in range(dim):
                part[i, c] += share * (part[i + 1, c] - part[i, c])
    part[0] = 0.0


@njit(cache=True, nogil=True)
def _evaluate_part(part, u, t, weight, values, slopes, point):
    """Point of a panel at t relative to its foot at u, also on the shorter part."""
    along = (t - u) / (1.0 - u) if u <= 0.5 else (u - t) / u
    fill_bernstein(part.shape[0] - 1, along, values, slopes)
    point[:] = 0.0
    for i in range(1, part.shape[0]):
        for c in range(part.shape[1]):
            point[c] += values[i] * part[i, c] / weight


@njit(cache=True, nogil=True)
def place_nodes(
    nets, panel_of, first, u, v, distance, tolerance, pieces, order, gauss,
    starts, foot, position, normal, weight, bu, bv,
):  # fmt: skip
    """Fill node tables for pairs first, first + 1, ... until the tables are full.

    ``u``, ``v``, ``distance`` give each pair's closest point, whose place in space goes to
    ``foot`` (dim, pairs).  Where ``pieces`` (pairs,) is not 0, the thesis's rule of ``order`` on
    so many parts a direction replaces ours (on surfaces).  Tables: ``position``, relative to the
    foot, and ``normal`` (dim, capacity); ``weight`` (capacity,), with the Jacobian, over the
    panel's weight function; Bernstein values ``bu`` (p + 1, capacity), ``bv`` (q + 1, capacity);
    ``starts`` (pairs + 1,) offsets.  Returns the number of pairs done.
    """
    p, q, dim = nets.shape[1] - 1, nets.shape[2] - 1, position.shape[0]
    lu, su, lv, sv = np.empty(p + 1), np.empty(p + 1), np.empty(q + 1), np.empty(q + 1)
    point, tu, tv, unit = np.empty(dim), np.empty(dim), np.empty(dim), np.empty(dim)
    work, part = (lu, su, lv, sv, point, tu, tv), np.empty((p + 1, dim))
    lp = np.empty(p + 1)
    nodes = np.empty((3, position.shape[1]))
    starts[0] = 0
    used = done = 0
    for k in range(first, len(panel_of)):
        net = nets[panel_of[k]]
        room = nodes[:, : position.shape[1] - used]
        if dim == 2:
            count = line_nodes(net, u[k], distance[k], tolerance, gauss, room, work)
        elif pieces[k] > 0 and distance[k] == 0.0:
            count = triangle_nodes(u[k], v[k], order, gauss, room)
        elif pieces[k] > 0:
            count = subdivided_nodes(order, pieces[k], gauss, room)
        else:
            count = polar_nodes(net, u[k], v[k], distance[k], tolerance, gauss, room, work)
        if count < 0:
            break
        _frame(net, u[k], v[k], lu, su, lv, sv, point, tu, tv)
        foot[:, done] = point
        if dim == 2:
            _part_from(net, u[k], foot[:, done], part)
        for m in range(count):
            fill_bernstein(p, nodes[0, m], lu, su)
            fill_bernstein(q, nodes[1, m], lv, sv)
            w = evaluate_panel(net, lu, lv, su, sv, point, tu, tv)
            if dim == 2:
                _evaluate_part(part, u[k], nodes[0, m], w, lp, su, point)
            else:
                point -= foot[:, done]
            weight[used + m] = nodes[2, m] * area_vector(tu, tv, unit) / w
            for c in range(dim):
                position[c, used + m] = point[c]
                normal[c, used + m] = unit[c]
            for i in range(p + 1):
                bu[i, used + m] = lu[i]
            for j in range(q + 1):
                bv[j, used + m] = lv[j]
        used += count
        done += 1
        starts[done] = used
    return done


@njit(cache=True, nogil=True, fastmath=True)
def moments(starts, table, weight, bu, bv, result):
    """Bernstein moments of each pair: result (pairs, entries, p + 1, q + 1).

    result[k, e, i, j] = Σ table[e, m] weight[m] bu[i, m] bv[j, m] over the pair's nodes m.
    """
    result[:] = 0.0
    for k in range(result.shape[0]):
        for e in range(result.shape[1]):
            for i in range(result.shape[2]):
                for m in range(starts[k], starts[k + 1]):
                    value = table[e, m] * weight[m] * bu[i, m]
                    for j in range(result.shape[3]):
                        result[k, e, i, j] += value * bv[j, m]
