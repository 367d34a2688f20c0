"""Tables of nodes for pairs of a target and a panel that is close to it, or its own.

The positions of the nodes come from ``polar`` for surfaces, from ``lines`` for curves, and from
``uniform`` for the rules of the thesis.
"""

from __future__ import annotations

from functools import lru_cache
from math import sqrt

import numpy as np

from cadbem.compiled import compiled
from cadbem.quadrature.gauss import MAX_ORDER, gauss_unit, log_unit
from cadbem.quadrature.lines import evaluate_part, line_nodes, part_from
from cadbem.quadrature.panels import area_vector, metric
from cadbem.quadrature.polar import collapsed_side_nodes, polar_nodes
from cadbem.quadrature.uniform import thesis_nodes

SMALLEST = 1e-290  # length of a vector whose direction counts
TILE = 64  # nodes at a time, so that what they share stays in the nearest cache


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


@compiled
def _nodes_of_pair(
    net, box, curve, collapsed, panel, k, u, v, distance,
    tolerance, pieces, order, gauss, room, work,
):  # fmt: skip
    """Parameters and weights of the nodes for one pair into ``room``; returns their number, -1 if
    there are too many."""
    if curve is not None:
        return line_nodes(net, u, distance, tolerance, gauss, room, work)
    if pieces is not None and pieces[k] > 0:
        return thesis_nodes(u, v, distance, order, pieces[k], gauss, room)
    if collapsed is not None and collapsed[panel] >= 0:
        side = collapsed[panel]
        return collapsed_side_nodes(net, side, u, v, distance, tolerance, gauss, room, work)
    if box is not None:
        return polar_nodes(net, u, v, distance, box, tolerance, gauss, room, work)
    return 0


@compiled
def _place_foot(net, curve, u, v, foot, work):
    """The closest point into ``foot``; on a curve, prepare differences from it."""
    lu, su, lv, sv, point, tu, tv = work
    metric(net, u, v, lu, su, lv, sv, point, tu, tv)
    for c in range(len(foot)):
        foot[c] = point[c]
    if curve is not None:
        part_from(net, u, point, curve)


@compiled(fastmath=True)
def _bernstein_rows(degree, t, first, values, slopes, spare):
    """Bernstein polynomials at parameters t (N,) into ``values`` (degree + 1, from ``first`` on),
    and their derivatives into ``slopes`` (degree + 1, N): rows, which the compiler makes vectors
    of."""
    count = len(t)
    low, rest = spare[0], spare[1]
    out = values[0, first : first + count]
    for m in range(count):
        rest[m] = 1.0 - t[m]
        out[m] = 1.0
        slopes[0, m] = 0.0
    for p in range(1, degree + 1):
        if p == degree:
            _slope_rows(degree, count, first, values, slopes)
        for m in range(count):
            low[m] = 0.0
        for j in range(p):
            out = values[j, first : first + count]
            for m in range(count):
                value = out[m]
                out[m] = low[m] + rest[m] * value
                low[m] = t[m] * value
        out = values[p, first : first + count]
        for m in range(count):
            out[m] = low[m]


@compiled(fastmath=True)
def _slope_rows(degree, count, first, values, slopes):
    """Derivatives (degree + 1, N) from the polynomials of one degree less."""
    for j in range(degree + 1):
        out = slopes[j]
        for m in range(count):
            out[m] = 0.0
        if j > 0:
            lower = values[j - 1, first : first + count]
            for m in range(count):
                out[m] += degree * lower[m]
        if j < degree:
            lower = values[j, first : first + count]
            for m in range(count):
                out[m] -= degree * lower[m]


@compiled(fastmath=True)
def _sum_rows(net, count, first, bu, bv, du, dv, sums, spare):
    """Homogeneous positions and derivatives of a panel at nodes: ``sums`` (3, dim + 1, N)."""
    row, slope = spare[0], spare[1]
    for c in range(net.shape[2]):
        point, along_u, along_v = sums[0, c], sums[1, c], sums[2, c]
        for m in range(count):
            point[m] = along_u[m] = along_v[m] = 0.0
        for i in range(net.shape[0]):
            for m in range(count):
                row[m] = slope[m] = 0.0
            for j in range(net.shape[1]):
                factor, value, change = net[i, j, c], bv[j, first : first + count], dv[j]
                for m in range(count):
                    row[m] += factor * value[m]
                    slope[m] += factor * change[m]
            value, change = bu[i, first : first + count], du[i]
            for m in range(count):
                point[m] += value[m] * row[m]
                along_u[m] += change[m] * row[m]
                along_v[m] += value[m] * slope[m]


@compiled
def _fill_tables(
    net, curve, u, foot, nodes, low, count, used, room, work, spare,
    position, normal, weight, bu, bv,
):  # fmt: skip
    """The tables' entries from ``used`` on for ``count`` nodes of one pair from ``low`` on, at most
    ``TILE``."""
    lu, su, lv, sv, point, tu, tv = work
    lp, unit = spare
    du, dv, sums, rows = room
    p, q, dim = net.shape[0] - 1, net.shape[1] - 1, position.shape[0]
    high = low + count
    _bernstein_rows(p, nodes[0, low:high], used, bu, du, rows)
    _bernstein_rows(q, nodes[1, low:high], used, bv, dv, rows)
    _sum_rows(net, count, used, bu, bv, du, dv, sums, rows)
    if curve is None:
        _finish_surface(sums, foot, nodes, low, count, used, position, normal, weight)
    else:
        for m in range(count):
            w = sums[0, dim, m]
            for c in range(dim):
                point[c] = sums[0, c, m] / w
                tu[c] = (sums[1, c, m] - sums[1, dim, m] * point[c]) / w
            for i in range(p + 1):
                lu[i] = bu[i, used + m]
            evaluate_part(curve, u, nodes[0, low + m], w, lp, su, point)
            weight[used + m] = nodes[2, low + m] * area_vector(tu, tv, unit) / w
            for c in range(dim):
                position[c, used + m] = point[c]
                normal[c, used + m] = unit[c]


@compiled(fastmath=True)
def _finish_surface(sums, foot, nodes, low, count, used, position, normal, weight):
    """Positions relative to the foot, normals and weights from the sums of ``_sum_rows``."""
    high = used + count
    x, y, z, w = sums[0, 0], sums[0, 1], sums[0, 2], sums[0, 3]
    ux, uy, uz, uw = sums[1, 0], sums[1, 1], sums[1, 2], sums[1, 3]
    vx, vy, vz, vw = sums[2, 0], sums[2, 1], sums[2, 2], sums[2, 3]
    px, py, pz = position[0, used:high], position[1, used:high], position[2, used:high]
    nx, ny, nz = normal[0, used:high], normal[1, used:high], normal[2, used:high]
    out, share = weight[used:high], nodes[2, low : low + count]
    fx, fy, fz = foot[0], foot[1], foot[2]
    for m in range(count):
        over = 1.0 / w[m]
        px[m], py[m], pz[m] = x[m] * over, y[m] * over, z[m] * over
        nx[m] = (uy[m] - uw[m] * py[m]) * (vz[m] - vw[m] * pz[m])
        nx[m] -= (uz[m] - uw[m] * pz[m]) * (vy[m] - vw[m] * py[m])
        ny[m] = (uz[m] - uw[m] * pz[m]) * (vx[m] - vw[m] * px[m])
        ny[m] -= (ux[m] - uw[m] * px[m]) * (vz[m] - vw[m] * pz[m])
        nz[m] = (ux[m] - uw[m] * px[m]) * (vy[m] - vw[m] * py[m])
        nz[m] -= (uy[m] - uw[m] * py[m]) * (vx[m] - vw[m] * px[m])
    for m in range(count):
        size = sqrt(nx[m] * nx[m] + ny[m] * ny[m] + nz[m] * nz[m])
        # at a pole the vector is zero, and any normal does
        over = 1.0 / max(size, SMALLEST)
        nx[m], ny[m], nz[m] = nx[m] * over, ny[m] * over, nz[m] * over
        px[m], py[m], pz[m] = px[m] - fx, py[m] - fy, pz[m] - fz
        out[m] = share[m] * size / (w[m] * w[m] * w[m])


@compiled
def place_nodes(
    nets, box, collapsed, panel_of, first, u, v, distance, tolerance, pieces, order, gauss,
    starts, foot, curve, position, normal, weight, bu, bv,
):  # fmt: skip
    """Fill node tables for pairs first, first + 1, ... until the tables are full.

    ``u``, ``v``, ``distance`` give each pair's closest point, whose place in space goes to
    ``foot`` (dim, pairs).  Surfaces need ``box``, which is ``WHOLE``, and the panels' ``collapsed``
    (see ``collapsed_sides``); curves need room ``curve`` (p + 1, dim).  Where ``pieces`` (pairs,)
    is not 0, the thesis's rule of ``order`` on so many parts a direction replaces ours (on
    surfaces).  What of these is None is not compiled.  Tables: ``position``, relative to the foot,
    and ``normal`` (dim, capacity); ``weight`` (capacity,), with the Jacobian, over the panel's
    weight function; Bernstein values ``bu`` (p + 1, capacity), ``bv`` (q + 1, capacity);
    ``starts`` (pairs + 1,) offsets.  Returns the number of pairs done.
    """
    p, q, dim = nets.shape[1] - 1, nets.shape[2] - 1, position.shape[0]
    lu, su, lv, sv = np.empty(p + 1), np.empty(p + 1), np.empty(q + 1), np.empty(q + 1)
    point, tu, tv, unit = np.empty(dim), np.empty(dim), np.empty(dim), np.empty(dim)
    work = (lu, su, lv, sv, point, tu, tv)
    spare = np.empty(p + 1), unit
    slopes, sums = (np.empty((p + 1, TILE)), np.empty((q + 1, TILE))), np.empty((3, dim + 1, TILE))
    tables = (slopes[0], slopes[1], sums, np.empty((2, TILE)))
    nodes = np.empty((3, position.shape[1]))
    starts[0] = 0
    used = done = 0
    for k in range(first, len(panel_of)):
        net = nets[panel_of[k]]
        room = nodes[:, : position.shape[1] - used]
        count = _nodes_of_pair(
            net, box, curve, collapsed, panel_of[k], k, u[k], v[k], distance[k],
            tolerance, pieces, order, gauss, room, work,
        )  # fmt: skip
        if count < 0:
            break
        _place_foot(net, curve, u[k], v[k], foot[:, done], work)
        for low in range(0, count, TILE):
            _fill_tables(
                net, curve, u[k], foot[:, done], nodes, low, min(TILE, count - low), used + low,
                tables, work, spare, position, normal, weight, bu, bv,
            )  # fmt: skip
        used += count
        done += 1
        starts[done] = used
    return done


@compiled(fastmath=True)
def moments(starts, table, weight, bu, bv, result):
    """Bernstein moments of each pair: result (pairs, entries, p + 1, q + 1).

    result[k, e, i, j] = Σ table[e, m] weight[m] bu[i, m] bv[j, m] over the pair's nodes m.
    """
    entries, rows, columns = result.shape[1], result.shape[2], result.shape[3]
    functions = np.empty(TILE)
    result[:] = 0.0
    for k in range(result.shape[0]):
        for low in range(starts[k], starts[k + 1], TILE):
            high = min(low + TILE, starts[k + 1])
            for i in range(rows):
                for j in range(columns):
                    w, a, b = weight[low:high], bu[i, low:high], bv[j, low:high]
                    for m in range(high - low):
                        functions[m] = w[m] * a[m] * b[m]
                    for e in range(entries):
                        values, total = table[e, low:high], 0.0
                        for m in range(high - low):
                            total += values[m] * functions[m]
                        result[k, e, i, j] += total
