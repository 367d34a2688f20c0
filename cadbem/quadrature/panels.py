"""Compiled geometry of Bézier panels: evaluation and closest points.

A panel is one rational Bézier piece.  ``nets`` (E, p + 1, q + 1, dim + 1) holds homogeneous
control points (w x, w) over parameters in [0, 1]²; a curve is a panel of degree q = 0.
"""

from __future__ import annotations

from math import sqrt

import numpy as np
from numpy.typing import NDArray

from cadbem.compiled import compiled

Array = NDArray[np.float64]

POINT = 1e-7  # share of a panel below which an edge counts as a point, and a distance to it as 0
APPROACH = 0.9  # share of the way to such an edge that a step may go


@compiled
def fill_bernstein(degree, t, values, slopes):
    """Bernstein polynomials and derivatives at t, into arrays of length degree + 1."""
    values[0] = 1.0
    slopes[0] = 0.0
    for p in range(1, degree + 1):
        if p == degree:
            slopes[0] = -p * values[0]
            for j in range(1, p):
                slopes[j] = p * (values[j - 1] - values[j])
            slopes[p] = p * values[p - 1]
        carried = 0.0
        for j in range(p):
            value = values[j]
            values[j] = carried + (1.0 - t) * value
            carried = t * value
        values[p] = carried


@compiled
def evaluate_panel(net, bu, bv, du, dv, point, tangent_u, tangent_v):
    """Position and tangents from Bernstein values and slopes; returns the weight function."""
    dim = net.shape[2] - 1
    weight = weight_u = weight_v = 0.0
    point[:] = 0.0
    tangent_u[:] = 0.0
    tangent_v[:] = 0.0
    for i in range(net.shape[0]):
        # one row first: then each control point is read once
        w = w_v = 0.0
        for j in range(net.shape[1]):
            w += bv[j] * net[i, j, dim]
            w_v += dv[j] * net[i, j, dim]
        weight += bu[i] * w
        weight_u += du[i] * w
        weight_v += bu[i] * w_v
        for c in range(dim):
            x = x_v = 0.0
            for j in range(net.shape[1]):
                x += bv[j] * net[i, j, c]
                x_v += dv[j] * net[i, j, c]
            point[c] += bu[i] * x
            tangent_u[c] += du[i] * x
            tangent_v[c] += bu[i] * x_v
    for c in range(dim):
        point[c] /= weight
        tangent_u[c] = (tangent_u[c] - weight_u * point[c]) / weight
        tangent_v[c] = (tangent_v[c] - weight_v * point[c]) / weight
    return weight


@compiled
def area_vector(tangent_u, tangent_v, normal):
    """Unit normal into ``normal`` (see ``surface_points``); returns the Jacobian."""
    if normal.shape[0] == 2:
        normal[0], normal[1] = tangent_u[1], -tangent_u[0]
        jacobian = sqrt(normal[0] * normal[0] + normal[1] * normal[1])
    else:
        normal[0] = tangent_u[1] * tangent_v[2] - tangent_u[2] * tangent_v[1]
        normal[1] = tangent_u[2] * tangent_v[0] - tangent_u[0] * tangent_v[2]
        normal[2] = tangent_u[0] * tangent_v[1] - tangent_u[1] * tangent_v[0]
        jacobian = sqrt(normal[0] * normal[0] + normal[1] * normal[1] + normal[2] * normal[2])
    if jacobian > 0.0:
        for c in range(normal.shape[0]):
            normal[c] /= jacobian
    return jacobian


@compiled
def _nearest_sample(targets, t, samples, sample_u, sample_v, bounds):
    """Number of the nearest sample of a panel within bounds, and the square of its distance."""
    best, square = 0, np.inf
    low_u, high_u, low_v, high_v = bounds[0], bounds[1], bounds[2], bounds[3]
    for s in range(samples.shape[0]):
        if not (low_u <= sample_u[s] <= high_u and low_v <= sample_v[s] <= high_v):
            continue
        distance = 0.0
        for c in range(targets.shape[0]):
            gap = samples[s, c] - targets[c, t]
            distance += gap * gap
        if distance < square:
            best, square = s, distance
    return best, square


@compiled
def _approaching(value, step, low, high):
    """A step of a parameter that only approaches a side that is a point."""
    if low > 0.0:
        step = max(step, -APPROACH * value)
    if high < 1.0:
        step = min(step, APPROACH * (1.0 - value))
    return step


@compiled
def _shortened(net, u, v, step_u, step_v, targets, t, square, work):
    """A step halved until the distance does not grow: whether it was found, u, v, and the square
    of the distance."""
    bu, du, bv, dv, point, tu, tv = work
    scale = 1.0
    new_u, new_v, distance = u, v, square
    for _ in range(12):
        new_u = min(max(u + scale * step_u, 0.0), 1.0)
        new_v = min(max(v + scale * step_v, 0.0), 1.0)
        fill_bernstein(net.shape[0] - 1, new_u, bu, du)
        fill_bernstein(net.shape[1] - 1, new_v, bv, dv)
        evaluate_panel(net, bu, bv, du, dv, point, tu, tv)
        distance = 0.0
        for c in range(targets.shape[0]):
            gap = point[c] - targets[c, t]
            distance += gap * gap
        if distance <= square:
            return True, new_u, new_v, distance
        scale *= 0.5
    return False, new_u, new_v, distance


@compiled
def _descended(net, u, v, square, targets, t, bounds, work):
    """Gauss-Newton from u, v: the parameters of the closest point, and the square of its
    distance."""
    bu, du, bv, dv, point, tu, tv = work
    low_u, high_u, low_v, high_v = bounds[0], bounds[1], bounds[2], bounds[3]
    for _ in range(30):
        fill_bernstein(net.shape[0] - 1, u, bu, du)
        fill_bernstein(net.shape[1] - 1, v, bv, dv)
        evaluate_panel(net, bu, bv, du, dv, point, tu, tv)
        step_u, step_v = _step(u, v, point, tu, tv, targets, t)
        step_u = _approaching(u, step_u, low_u, high_u)
        step_v = _approaching(v, step_v, low_v, high_v)
        accepted, new_u, new_v, distance = _shortened(
            net, u, v, step_u, step_v, targets, t, square, work
        )
        if not accepted:
            break
        moved = abs(new_u - u) + abs(new_v - v)
        u, v, square = new_u, new_v, distance
        if moved < 1e-12:
            break
    return u, v, square


@compiled
def closest_on_panels(
    targets, target_of, panel_of, nets, squares, sample_u, sample_v, samples, result
):  # fmt: skip
    """Closest point of panel panel_of[k] to target target_of[k], for each pair k.

    Starts from the nearest of ``samples`` (E, S, dim) at parameters sample_u, sample_v (S,),
    then Gauss-Newton held in the unit square.  ``result`` (3, pairs): u, v, distance.
    ``squares`` (E, 4) are the panels' ``open_squares``.

    On an edge that is a point (a pole) one parameter means nothing, and a step from there would
    not change it: such edges are only approached.
    """
    p, q, dim = nets.shape[1] - 1, nets.shape[2] - 1, targets.shape[0]
    bu, du = np.empty(p + 1), np.empty(p + 1)
    bv, dv = np.empty(q + 1), np.empty(q + 1)
    work = (bu, du, bv, dv, np.empty(dim), np.empty(dim), np.empty(dim))
    for k in range(len(target_of)):
        e, t = panel_of[k], target_of[k]
        net = nets[e]
        low_u, high_u = squares[e, 0], squares[e, 1]
        low_v, high_v = squares[e, 2], squares[e, 3]
        best, square = _nearest_sample(targets, t, samples[e], sample_u, sample_v, squares[e])
        u, v = sample_u[best], sample_v[best]
        u, v, square = _descended(net, u, v, square, targets, t, squares[e], work)
        u = 0.0 if u < low_u else (1.0 if u > high_u else u)
        v = 0.0 if v < low_v else (1.0 if v > high_v else v)
        result[0, k], result[1, k], result[2, k] = u, v, sqrt(square)


def side_extents(nets: Array) -> Array:
    """Lengths (4, E) of the sides v = 0, u = 1, v = 1, u = 0 of panels; the longest is 1."""
    points = nets[..., :-1] / nets[..., -1:]
    sides = points[:, :, 0], points[:, -1], points[:, :, -1], points[:, 0]
    extents = np.stack([abs(side - side[:, :1]).max(axis=(1, 2)) for side in sides])
    return extents / extents.max(axis=0)


def open_squares(nets: Array) -> Array:
    """Bounds u0, u1, v0, v1 that leave out the sides of panels that are points: (E, 4)."""
    south, east, north, west = (side_extents(nets) < POINT) * POINT
    if nets.shape[2] == 1:  # the ends of a curve
        east, west = 0.0 * east, 0.0 * west
    return np.stack([west, 1.0 - east, south, 1.0 - north], axis=1)


@compiled
def _step(u, v, point, tu, tv, targets, t):
    """Gauss-Newton step; a parameter that presses against its bound is held."""
    a = b = c = g = h = 0.0
    for i in range(len(point)):
        gap = targets[i, t] - point[i]
        a += tu[i] * tu[i]
        b += tu[i] * tv[i]
        c += tv[i] * tv[i]
        g += tu[i] * gap
        h += tv[i] * gap
    hold_u = (u <= 0.0 and g <= 0.0) or (u >= 1.0 and g >= 0.0) or a == 0.0
    hold_v = (v <= 0.0 and h <= 0.0) or (v >= 1.0 and h >= 0.0) or c == 0.0
    if hold_u and hold_v:
        return 0.0, 0.0
    if hold_u:
        return 0.0, h / c
    if hold_v:
        return g / a, 0.0
    determinant = a * c - b * b
    if determinant <= 1e-14 * a * c:
        return g / a, 0.0
    step_u, step_v = (g * c - h * b) / determinant, (h * a - g * b) / determinant
    # where the full step leaves through one side, slide along it
    if u + step_u < 0.0 or u + step_u > 1.0:
        held = min(max(u + step_u, 0.0), 1.0) - u
        return held, (h - b * held) / c
    if v + step_v < 0.0 or v + step_v > 1.0:
        held = min(max(v + step_v, 0.0), 1.0) - v
        return (g - b * held) / a, held
    return step_u, step_v


@compiled
def metric(net, u, v, bu, du, bv, dv, point, tu, tv):
    """First fundamental form (E, F, G) at (u, v); leaves the position in ``point``."""
    fill_bernstein(net.shape[0] - 1, u, bu, du)
    fill_bernstein(net.shape[1] - 1, v, bv, dv)
    evaluate_panel(net, bu, bv, du, dv, point, tu, tv)
    e = f = g = 0.0
    for i in range(len(point)):
        e += tu[i] * tu[i]
        f += tu[i] * tv[i]
        g += tv[i] * tv[i]
    return e, f, g
