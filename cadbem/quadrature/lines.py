"""Singular and nearly singular rules on curves, to either side of the closest point of a panel.

ρ = d sinh(s) puts the nearest singularities to iπ/2 above the end of the range, which spares nodes;
a target on the curve needs a rule for the logarithm.
"""

from __future__ import annotations

from math import acosh, asinh, ceil, cosh, exp, log, pi, sinh, sqrt

from cadbem.compiled import compiled
from cadbem.quadrature.gauss import MAX_ORDER
from cadbem.quadrature.panels import fill_bernstein, metric


@compiled
def line_nodes(net, u, distance, tolerance, gauss, nodes, work):
    """As ``polar_nodes`` for a panel of a curve: nodes to either side of the closest point."""
    bu, du, bv, dv, point, tu, tv = work
    speed = sqrt(metric(net, u, 0.0, bu, du, bv, dv, point, tu, tv)[0])
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


@compiled
def part_from(net, u, foot, part):
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
    for c in range(dim):
        part[0, c] = 0.0


@compiled
def evaluate_part(part, u, t, weight, values, slopes, point):
    """Point of a panel at t relative to its foot at u, also on the shorter part."""
    along = (t - u) / (1.0 - u) if u <= 0.5 else (u - t) / u
    fill_bernstein(part.shape[0] - 1, along, values, slopes)
    point[:] = 0.0
    for i in range(1, part.shape[0]):
        for c in range(part.shape[1]):
            point[c] += values[i] * part[i, c] / weight
