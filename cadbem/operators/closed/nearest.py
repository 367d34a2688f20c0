"""Nearest points of closed splines, and on which side of them points lie."""

from __future__ import annotations

from dataclasses import dataclass
from math import atan2, cos, hypot, pi, sin

import numpy as np
from scipy.spatial import cKDTree

from cadbem.closed_points import collocation_grid
from cadbem.compiled import compiled
from cadbem.spline.basis import Array
from cadbem.spline.closed import ClosedSpline

STEPS = 40
ARRIVED = 1e-12  # angle
LONGEST = 0.5  # angle that a step may go
OFF_POLE = 1e-6  # how near to a pole tangents are asked for: parameters are degenerate there


@dataclass(frozen=True, eq=False)
class Feet:
    """Of M points: parameters (p, M) of the nearest surface points, these points and the
    outward normals there, of any length, (dim, M)."""

    parameters: Array
    position: Array
    normal: Array


def nearest_feet(spline: ClosedSpline, points: Array) -> Feet:
    """The nearest points to points (dim, M).

    From the nearest collocation point, Gauss-Newton steps on the unit circle or sphere; far
    outside they are shortened, where the surface curves away from the point.
    """
    dim, count = points.shape
    feet = Feet(np.empty((dim - 1, count)), np.empty((dim, count)), np.empty((dim, count)))
    if count:
        known = collocation_grid(spline.basis).points(spline)
        distance, start = cKDTree(known.position.T).query(points.T)
        feet.parameters[:] = spline.basis.parameters()[:, start]
        damping = 1 / (1 + distance * np.abs(known.curvature).max())
        net = np.moveaxis(spline.basis.doubled(spline.coefficients), 0, -1)
        net = np.ascontiguousarray(net.reshape(-1, *net.shape[-2:]))
        find = _feet_on_curve if dim == 2 else _feet_on_surface
        find(np.ascontiguousarray(points), spline.basis.degree, net, damping,
             feet.parameters, feet.position, feet.normal)  # fmt: skip
    return feet


def nearest_points(spline: ClosedSpline, points: Array) -> Array:
    """Parameters (p, M) of the surface points nearest to points (dim, M)."""
    return nearest_feet(spline, points).parameters


def signed_distance(spline: ClosedSpline, points: Array) -> Array:
    """Distance (M,) of points (dim, M) from a closed curve or surface, negative inside."""
    feet = nearest_feet(spline, points)
    way = points - feet.position
    inside = (way * feet.normal).sum(axis=0) < 0
    return np.linalg.norm(way, axis=0) * np.where(inside, -1.0, 1.0)


@compiled
def _fill(degree, count, angle, values, slopes):
    """Uniform B-splines around an angle and their derivatives; returns the first one's number."""
    step = 2.0 * pi / count
    place = angle / step - 0.5 + 0.5 * (degree + 1)
    span = int(np.floor(place))
    t = place - span
    values[0] = 1.0
    for q in range(1, degree + 1):
        if q == degree:
            for k in range(degree + 1):
                left = values[k - 1] if k > 0 else 0.0
                slopes[k] = (left - (values[k] if k < degree else 0.0)) / step
        values[q] = 0.0
        for k in range(q, -1, -1):
            left = values[k - 1] if k > 0 else 0.0
            values[k] = ((t + q - k) * left + (k + 1 - t) * values[k]) / q
    return span - degree


@compiled
def _add(net, row, first, values, factor, out):
    """Add factor Σ values_k net[row, first + k] to a vector."""
    columns = net.shape[1]
    for k in range(len(values)):
        column = (first + k) % columns
        for c in range(len(out)):
            out[c] += factor * values[k] * net[row, column, c]


@compiled
def _feet_on_curve(points, degree, net, damping, at, foot, normal):
    values, slopes = np.empty(degree + 1), np.empty(degree + 1)
    x, tangent = np.empty(2), np.empty(2)
    for m in range(points.shape[1]):
        for repeat in range(STEPS + 1):
            first = _fill(degree, net.shape[1], at[0, m], values, slopes)
            x[:], tangent[:] = 0.0, 0.0
            _add(net, 0, first, values, 1.0, x)
            _add(net, 0, first, slopes, 1.0, tangent)
            step = tangent[0] * (points[0, m] - x[0]) + tangent[1] * (points[1, m] - x[1])
            step /= tangent[0] ** 2 + tangent[1] ** 2
            if abs(step) < ARRIVED or repeat == STEPS:
                break
            step = max(-LONGEST, min(LONGEST, step * damping[m]))
            at[0, m] += step
        foot[:, m] = x
        normal[0, m], normal[1, m] = tangent[1], -tangent[0]


@compiled
def _feet_on_surface(points, degree, net, damping, at, foot, normal):
    values, slopes = np.empty((2, degree + 1)), np.empty((2, degree + 1))
    x, south, east = np.empty(3), np.empty(3), np.empty(3)
    for m in range(points.shape[1]):
        for repeat in range(STEPS + 1):
            theta, phi = min(max(at[0, m], OFF_POLE), pi - OFF_POLE), at[1, m]
            row = _fill(degree, net.shape[0], theta, values[0], slopes[0])
            column = _fill(degree, net.shape[1], phi, values[1], slopes[1])
            x[:], south[:], east[:] = 0.0, 0.0, 0.0
            for a in range(degree + 1):
                here = (row + a) % net.shape[0]
                _add(net, here, column, values[1], values[0, a], x)
                _add(net, here, column, values[1], slopes[0, a], south)
                _add(net, here, column, slopes[1], values[0, a] / sin(theta), east)
            e = f = g = b = d = 0.0
            for c in range(3):
                way = points[c, m] - x[c]
                e += south[c] ** 2
                f += south[c] * east[c]
                g += east[c] ** 2
                b += south[c] * way
                d += east[c] * way
            inverse = 1.0 / (e * g - f * f)
            b, d = inverse * (g * b - f * d), inverse * (e * d - f * b)
            length = hypot(b, d)
            if length < ARRIVED or repeat == STEPS:
                break
            share = min(damping[m], LONGEST / length)
            at[0, m], at[1, m] = _moved(theta, phi, share * b, share * d)
        foot[:, m] = x
        for c in range(3):
            i, j = (c + 1) % 3, (c + 2) % 3
            normal[c, m] = south[i] * east[j] - south[j] * east[i]


@compiled
def _moved(theta, phi, south, east):
    """Colatitude and longitude after a step in the tangent plane of the unit sphere."""
    radial = sin(theta) + south * cos(theta)
    x = radial * cos(phi) - east * sin(phi)
    y = radial * sin(phi) + east * cos(phi)
    return atan2(hypot(x, y), cos(theta) - south * sin(theta)), atan2(y, x)
