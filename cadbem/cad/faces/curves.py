"""Curve records of the CAD kernel as exact NURBS.

Parametrisations (OpenCASCADE, Geom package), with origin O and directions X, Y:
line O + t X; circle and ellipse O + a cos t X + b sin t Y; parabola O + t²/(4f) X + t Y;
hyperbola O + a cosh t X + b sinh t Y. Splines keep their knots.
"""

from __future__ import annotations

from math import ceil, cos, cosh, pi, sin, sinh

import numpy as np

from cadbem.cad.kernel.brep_geometry import (
    CIRCLE,
    ELLIPSE,
    HYPERBOLA,
    LINE,
    OFFSET,
    PARABOLA,
    CurveRecord,
    SplineRecord,
)
from cadbem.errors import CadError
from cadbem.spline.nurbs import Nurbs

Interval = tuple[float, float]
SNAP = 1e-9  # parameters this close to a knot, relative to the spline's range, mean the knot


def curve_nurbs(record: CurveRecord, interval: Interval) -> Nurbs:
    """The curve over the interval; arcs over 90° become pieces that join with full multiplicity.

    Lines and splines keep the kernel's parameter, conics agree with it at the joints only.
    Raises CadError for offset curves, which no NURBS represents.
    """
    if record.spline is not None:
        return spline_nurbs(record.spline, (interval,))
    if record.kind == OFFSET:
        raise CadError("an offset curve has no exact NURBS")
    first, last = interval
    if record.kind == LINE:
        origin, direction = record.frame
        return _bezier([origin + first * direction, origin + last * direction], [1.0, 1.0])
    origin, x, y = record.frame
    if record.kind == PARABOLA:
        focal = 4 * record.sizes[0]
        middle = origin + first * last / focal * x + (first + last) / 2 * y
        ends = [origin + t * t / focal * x + t * y for t in interval]
        return _bezier([ends[0], middle, ends[1]], [1.0, 1.0, 1.0])
    a, b = record.sizes[0], record.sizes[-1]
    if record.kind == HYPERBOLA:
        middle, half = (first + last) / 2, (last - first) / 2
        parameters, weights = [first, middle, last], [1.0, cosh(half), 1.0]
        points = [
            origin + (a * cosh(t) * x + b * sinh(t) * y) / w
            for t, w in zip(parameters, weights, strict=True)
        ]
        return _bezier(points, weights)
    assert record.kind in (CIRCLE, ELLIPSE)
    return arc(origin, a * x, b * y, interval)


def _bezier(points: list[np.ndarray], weights: list[float]) -> Nurbs:
    degree = len(points) - 1
    knots = np.repeat([0.0, 1.0], degree + 1)
    return Nurbs((degree,), (knots,), np.array(points), np.array(weights))


def arc_angles(interval: Interval) -> tuple[np.ndarray, np.ndarray]:
    """Angles (2k + 1,) and weights of the control points of an arc cut into k pieces of ≤ 90°."""
    first, last = interval
    pieces = max(1, ceil((last - first) / (pi / 2) - 1e-9))
    angles = np.linspace(first, last, 2 * pieces + 1)
    weights = np.ones(2 * pieces + 1)
    weights[1::2] = cos((last - first) / (2 * pieces))
    return angles, weights


def arc_knots(angles: np.ndarray) -> np.ndarray:
    """Quadratic knots for `arc_angles`: every joint twice, so that pieces come apart there."""
    joints = angles[::2]
    return np.concatenate([joints[:1], np.repeat(joints, 2), joints[-1:]])


def arc(origin: np.ndarray, x: np.ndarray, y: np.ndarray, interval: Interval) -> Nurbs:
    """O + cos t X + sin t Y over the interval (NURBS Book, section 7.3)."""
    angles, weights = arc_angles(interval)
    points = [origin + (cos(t) * x + sin(t) * y) / w for t, w in zip(angles, weights, strict=True)]
    return Nurbs((2,), (arc_knots(angles),), np.array(points), weights)


def spline_nurbs(record: SplineRecord, box: tuple[Interval, ...]) -> Nurbs:
    """The part of a spline over a box of parameters, clamped; periodic splines are unrolled."""
    control = np.concatenate(
        [record.points * record.weights[..., None], record.weights[..., None]], axis=-1
    )
    knots = []
    for axis, interval in enumerate(box):
        control = np.moveaxis(control, axis, 0)
        clamped, control = _clamped(record, axis, control, interval)
        control = np.moveaxis(control, 0, axis)
        knots.append(clamped)
    return Nurbs.from_homogeneous(record.degrees, tuple(knots), control)


def spline_domain(record: SplineRecord, axis: int) -> Interval:
    """Where the spline is defined; (-inf, inf) if periodic."""
    if record.periodic[axis]:
        return -np.inf, np.inf
    degree, knots = record.degrees[axis], record.knots[axis]
    return float(knots[degree]), float(knots[-degree - 1])


def _clamped(
    record: SplineRecord, axis: int, control: np.ndarray, interval: Interval
) -> tuple[np.ndarray, np.ndarray]:
    degree, knots = record.degrees[axis], record.knots[axis]
    if record.periodic[axis]:
        knots, control = _unrolled(degree, knots, control, interval)
    limits = float(knots[degree]), float(knots[-degree - 1])
    low, high = (min(max(_snapped(knots, end), limits[0]), limits[1]) for end in interval)
    if low >= high:
        raise CadError("an edge runs outside the curve that it lies on; export it again")
    for end in (low, high):
        for _ in range(degree - int((knots == end).sum())):
            knots, control = _with_knot(degree, knots, control, end)
    start = max(int(np.searchsorted(knots, low, side="right")) - degree - 1, 0)
    stop = int(np.searchsorted(knots, high, side="left"))
    inner = knots[(knots > low) & (knots < high)]
    ends = np.ones(degree + 1)
    return np.concatenate([low * ends, inner, high * ends]), control[start:stop]


def _snapped(knots: np.ndarray, value: float) -> float:
    nearest = knots[np.argmin(np.abs(knots - value))]
    return float(nearest if abs(nearest - value) < SNAP * (knots[-1] - knots[0]) else value)


def _unrolled(
    degree: int, knots: np.ndarray, control: np.ndarray, interval: Interval
) -> tuple[np.ndarray, np.ndarray]:
    """Knots and control points repeated over the periods that the interval touches, and one more
    on each side. The first control point belongs to the first of the degree + 1 - m knots that
    precede the first knot of multiplicity m."""
    count, period = len(control), knots[-1] - knots[0]
    offset = degree + 1 - int((knots == knots[0]).sum())
    low = int(np.floor((interval[0] - knots[0]) / period)) - 1
    high = int(np.ceil((interval[1] - knots[0]) / period)) + 1
    index = np.arange(low * count, high * count + degree + 1)
    turns, place = np.divmod(index - offset, count)
    return knots[place] + turns * period, control[index[: -degree - 1] % count]


def _with_knot(
    degree: int, knots: np.ndarray, control: np.ndarray, value: float
) -> tuple[np.ndarray, np.ndarray]:
    """One knot inserted (Boehm's algorithm)."""
    span = int(np.searchsorted(knots, value, side="right")) - 1
    first, last = span - degree + 1, span - int((knots == value).sum())
    index = np.arange(first, last + 1)
    share = (value - knots[index]) / (knots[index + degree] - knots[index])
    share = share.reshape(-1, *[1] * (control.ndim - 1))
    blended = share * control[index] + (1 - share) * control[index - 1]
    control = np.concatenate([control[:first], blended, control[last:]])
    return np.insert(knots, span + 1, value), control
