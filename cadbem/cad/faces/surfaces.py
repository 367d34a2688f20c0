"""Surface records of the CAD kernel as exact NURBS over a rectangle of their parameters.

Parametrisations (OpenCASCADE, Geom package), with origin O and directions X, Y, Z:
plane O + u X + v Y; cylinder O + r e(u) + v Z with e(u) = cos u X + sin u Y;
cone O + (r + v sin α) e(u) + v cos α Z; sphere O + r cos v e(u) + r sin v Z;
torus O + (R + r cos v) e(u) + r sin v Z; extrusion C(u) + v D; revolution: C(v) turned by u.
"""

from __future__ import annotations

from itertools import pairwise, product
from math import cos, sin

import numpy as np

from cadbem.cad.faces.curves import (
    Interval,
    arc,
    arc_angles,
    arc_knots,
    curve_nurbs,
    spline_domain,
    spline_nurbs,
)
from cadbem.cad.kernel.brep_geometry import (
    CONE,
    CYLINDER,
    EXTRUSION,
    OFFSET,
    PLANE,
    REVOLUTION,
    SPHERE,
    TORUS,
    SplineRecord,
    SurfaceRecord,
)
from cadbem.errors import CadError
from cadbem.spline.basis import Array, multiplicities
from cadbem.spline.nurbs import Nurbs


def surface_nurbs(record: SurfaceRecord, u: Interval, v: Interval) -> Nurbs:
    """The surface over [u] × [v], parameters in the kernel's order.

    Raises CadError for offset surfaces, which no NURBS represents.
    """
    if record.spline is not None:
        return spline_nurbs(record.spline, (u, v))
    if record.kind == OFFSET:
        raise CadError("an offset surface has no exact NURBS")
    if record.kind == PLANE:
        return _plane(record, u, v)
    if record.curve is not None and record.kind == EXTRUSION:
        return _extruded(curve_nurbs(record.curve, u), record.frame[0], v)
    if record.curve is not None and record.kind == REVOLUTION:
        origin, axis = record.frame
        return revolved(curve_nurbs(record.curve, v), origin, axis, u)
    origin, _, x, y = record.frame
    return revolved(_profile(record, v), origin, np.cross(x, y), u)


def _plane(record: SurfaceRecord, u: Interval, v: Interval) -> Nurbs:
    origin, _, x, y = record.frame
    points = np.array([[origin + a * x + b * y for b in v] for a in u])
    knots = (np.repeat(u, 2), np.repeat(v, 2))
    return Nurbs((1, 1), knots, points, np.ones((2, 2)))


def _profile(record: SurfaceRecord, v: Interval) -> Nurbs:
    """The curve u = 0 of a cylinder, cone, sphere or torus."""
    origin, z, x, _ = record.frame
    radius = record.sizes[0]
    if record.kind == SPHERE:
        return arc(origin, radius * x, radius * z, v)
    if record.kind == TORUS:
        minor = record.sizes[1]
        return arc(origin + radius * x, minor * x, minor * z, v)
    angle = record.sizes[1] if record.kind == CONE else 0.0
    assert record.kind in (CYLINDER, CONE)
    slope = sin(angle) * x + cos(angle) * z
    points = np.array([origin + radius * x + t * slope for t in v])
    return Nurbs((1,), (np.repeat(v, 2),), points, np.ones(2))


def _extruded(curve: Nurbs, direction: np.ndarray, v: Interval) -> Nurbs:
    points = np.stack([curve.points + t * direction for t in v], axis=1)
    weights = np.stack([curve.weights] * 2, axis=1)
    return Nurbs((curve.degrees[0], 1), (curve.knots[0], np.repeat(v, 2)), points, weights)


def revolved(profile: Nurbs, origin: np.ndarray, axis: np.ndarray, u: Interval) -> Nurbs:
    """A curve turned about an axis from angle u[0] to u[1] (NURBS Book, section 8.5)."""
    angles, turn_weights = arc_angles(u)
    axis = axis / np.linalg.norm(axis)
    arm = profile.points - origin
    along = np.outer(arm @ axis, axis)
    radial = arm - along
    sideways = np.cross(axis, radial)
    rows = [
        origin + along + (cos(t) * radial + sin(t) * sideways) / w
        for t, w in zip(angles, turn_weights, strict=True)
    ]
    weights = np.outer(turn_weights, profile.weights)
    degrees, knots = (2, profile.degrees[0]), (arc_knots(angles), profile.knots[0])
    return Nurbs(degrees, knots, np.array(rows), weights)


def natural_domain(record: SurfaceRecord) -> tuple[Interval, Interval]:
    """Where a spline surface, or the curve it is made from, ends; infinite where nothing ends."""
    endless = (-np.inf, np.inf)
    if record.spline is not None:
        return spline_domain(record.spline, 0), spline_domain(record.spline, 1)
    if record.curve is None or record.curve.spline is None:
        return endless, endless
    along = spline_domain(record.curve.spline, 0)
    return (along, endless) if record.kind == EXTRUSION else (endless, along)


def kink_lines(record: SurfaceRecord, box: tuple[Interval, Interval]) -> list[tuple[int, float]]:
    """Lines (axis, parameter) inside a rectangle across which second derivatives may jump, where
    programs join the pieces of spline surfaces."""
    lines = []
    for axis, spline, along in splines_of(record):
        values, counts = multiplicities(unrolled_knots(spline, along))
        kinks = values[counts >= max(spline.degrees[along] - 1, 1)]
        low, high = box[axis]
        margin = 1e-6 * (high - low)
        lines += [(axis, float(x)) for x in kinks if low + margin < x < high - margin]
    return lines


def splines_of(record: SurfaceRecord) -> list[tuple[int, SplineRecord, int]]:
    """Spline, and its own axis, along each axis of a surface that has one."""
    while record.basis is not None:
        record = record.basis
    if record.spline is not None:
        return [(0, record.spline, 0), (1, record.spline, 1)]
    if record.curve is None or record.curve.spline is None:
        return []
    return [(0 if record.kind == EXTRUSION else 1, record.curve.spline, 0)]


def unrolled_knots(spline: SplineRecord, axis: int) -> Array:
    """Knots of a spline; of a periodic one those of the periods before and after, too."""
    knots = spline.knots[axis]
    if not spline.periodic[axis]:
        return knots
    period = knots[-1] - knots[0]
    return np.concatenate([knots[:-1] - period, knots[:-1], knots + period])


def smooth_pieces(surface: Nurbs) -> list[Nurbs]:
    """Cut where a knot's multiplicity reaches the degree, so that each piece is smooth inside."""
    intervals = []
    for degree, knots in zip(surface.degrees, surface.knots, strict=True):
        values, counts = multiplicities(knots)
        intervals.append(list(pairwise(values[counts >= degree])))
    if all(len(parts) == 1 for parts in intervals):
        return [surface]
    return [surface.restricted(*box) for box in product(*intervals)]
