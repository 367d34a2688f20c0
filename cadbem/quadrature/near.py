"""Tables of nodes for pairs of a target and a panel that is close to it, or its own.

The positions of the nodes come from ``polar`` for surfaces, from ``lines`` for curves, and from
``uniform`` for the rules of the thesis.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from cadbem.compiled import compiled
from cadbem.quadrature.gauss import MAX_ORDER, gauss_unit, log_unit
from cadbem.quadrature.lines import evaluate_part, line_nodes, part_from
from cadbem.quadrature.panels import area_vector, evaluate_panel, fill_bernstein, metric
from cadbem.quadrature.polar import collapsed_side_nodes, polar_nodes
from cadbem.quadrature.uniform import thesis_nodes


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


@compiled
def _fill_tables(
    net, curve, u, foot, nodes, count, used, work, spare, position, normal, weight, bu, bv
):
    """The tables' entries from ``used`` on for the ``count`` nodes of one pair."""
    lu, su, lv, sv, point, tu, tv = work
    lp, unit = spare
    p, q, dim = net.shape[0] - 1, net.shape[1] - 1, position.shape[0]
    for m in range(count):
        fill_bernstein(p, nodes[0, m], lu, su)
        fill_bernstein(q, nodes[1, m], lv, sv)
        w = evaluate_panel(net, lu, lv, su, sv, point, tu, tv)
        if curve is not None:
            evaluate_part(curve, u, nodes[0, m], w, lp, su, point)
        else:
            for c in range(dim):
                point[c] -= foot[c]
        weight[used + m] = nodes[2, m] * area_vector(tu, tv, unit) / w
        for c in range(dim):
            position[c, used + m] = point[c]
            normal[c, used + m] = unit[c]
        for i in range(p + 1):
            bu[i, used + m] = lu[i]
        for j in range(q + 1):
            bv[j, used + m] = lv[j]


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
        _fill_tables(
            net, curve, u[k], foot[:, done], nodes, count, used, work, spare,
            position, normal, weight, bu, bv,
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
    result[:] = 0.0
    entries, rows, columns = result.shape[1], result.shape[2], result.shape[3]
    flat = result.reshape(result.shape[0], entries, rows * columns)
    functions = np.empty(rows * columns)
    for k in range(flat.shape[0]):
        for m in range(starts[k], starts[k + 1]):
            for i in range(rows):
                value = weight[m] * bu[i, m]
                for j in range(columns):
                    functions[i * columns + j] = value * bv[j, m]
            for e in range(entries):
                value = table[e, m]
                sums = flat[k, e]
                for f in range(len(functions)):
                    sums[f] += value * functions[f]
