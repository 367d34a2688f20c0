"""The geometry of a face: its edges in space and in the parameters of its surface."""

from __future__ import annotations

from collections.abc import Iterator
from functools import lru_cache

import numpy as np

from cadbem.cad.faces.curves import Interval, curve_nurbs
from cadbem.cad.faces.surfaces import natural_domain, surface_nurbs
from cadbem.cad.kernel.brep import BrepFace, EdgeUse
from cadbem.cad.kernel.brep_geometry import PLANE, CurveRecord
from cadbem.errors import CadError
from cadbem.spline.basis import Array
from cadbem.spline.nurbs import Nurbs

REMEMBERED = 4096  # edges and faces whose curves and boxes are kept for the next question
FLAT = 1e-7  # deviation from a line, plane or rectangle that is still rounding, per size of it


def shape_of(face: BrepFace) -> str:
    """In words: kind of surface, edges, holes."""
    counts = {"edge": sum(map(len, face.loops)), "hole": max(len(face.loops) - 1, 0)}
    words = [f"{count} {what}{'s' * (count != 1)}" for what, count in counts.items()]
    return ", ".join([face.surface.kind, *words])


@lru_cache(maxsize=REMEMBERED)
def world_curve(use: EdgeUse) -> Nurbs | None:
    """The edge in the model's coordinates, as its curve runs; None if it is a point."""
    if use.curve is None:
        return None
    return curve_nurbs(use.curve, use.interval).transformed(use.matrix[:3, :3], use.matrix[:3, 3])


def real_uses(face: BrepFace) -> Iterator[EdgeUse]:
    """The passes of the face's loops along edges that are not points."""
    return (use for loop in face.loops for use in loop if use.curve is not None)


def size_of(*faces: BrepFace) -> float:
    """Largest extent of the faces' edges, in millimetres; 0 if they have none."""
    points = np.concatenate([edge_points(face) for face in faces])
    return float(np.ptp(points, axis=0).max()) if len(points) else 0.0


def edge_points(face: BrepFace) -> Array:
    """Points (n, 3) along the face's edges, in the model's coordinates."""
    points = [points_on(use) for use in real_uses(face)]
    return np.concatenate(points) if points else np.zeros((0, 3))


def edge_length(face: BrepFace) -> float:
    """Length of the face's edges, by chords."""
    steps = [np.diff(points_on(use), axis=0) for use in real_uses(face)]
    return float(sum(np.linalg.norm(step, axis=1).sum() for step in steps))


@lru_cache(maxsize=REMEMBERED)
def points_on(use: EdgeUse) -> Array:
    """Points (n, 3) along an edge that is not a point."""
    try:
        curve = world_curve(use)
    except CadError:  # a curve that is no NURBS; its ends must do
        return use.ends
    assert curve is not None
    if _is_segment(curve):
        return np.linspace(curve.points[0], curve.points[1], 9)
    return curve.evaluate(np.linspace(*curve.domain[0], 9)).T


@lru_cache(maxsize=REMEMBERED)
def parameter_box(face: BrepFace) -> tuple[Interval, Interval] | None:
    """The rectangle of parameters round the face; None if an edge has no parameter curve."""
    curves = parameter_curves(face)
    if not curves:
        return None
    samples = np.concatenate([sampled(curve) for curve in curves], axis=1)
    box = []
    for low, high, (start, stop) in zip(
        samples.min(axis=1), samples.max(axis=1), natural_domain(face.surface), strict=True
    ):
        tolerance = FLAT * (high - low)
        low = start if abs(low - start) < tolerance else max(low, start)
        box.append((float(low), float(stop if abs(high - stop) < tolerance else min(high, stop))))
    return box[0], box[1]


@lru_cache(maxsize=REMEMBERED)
def parameter_curves(face: BrepFace) -> tuple[Nurbs, ...]:
    """The edges as curves (2D) in the parameter plane, in the loops' order; () if one lacks it."""
    curves = []
    for loop in face.loops:
        for use in loop:
            curve = _parameter_curve(face, use)
            if curve is None:
                return ()
            curves.append(curve)
    return tuple(curves)


def _parameter_curve(face: BrepFace, use: EdgeUse) -> Nurbs | None:
    if face.surface.kind == PLANE:  # planes may lack parameter curves; projecting is exact
        curve = world_curve(use)
        if curve is None:
            return None
        origin, _, x, y = face.surface.frame
        inverse = np.linalg.inv(face.matrix)
        local = curve.transformed(inverse[:3, :3], inverse[:3, 3] - origin)
        return Nurbs(curve.degrees, curve.knots, local.points @ np.stack([x, y], 1), curve.weights)
    if not use.parameter_curves:
        return None
    return curve_nurbs(curve_of(use), use.interval)


def curve_of(use: EdgeUse) -> CurveRecord:
    """The edge's parameter curve: on a seam the second one belongs to the reversed pass."""
    return use.parameter_curves[-1 if use.sign < 0 else 0]


def sampled(curve: Nurbs) -> Array:
    """Points (dim, n) on every span of the curve; the ends of a segment."""
    if _is_segment(curve):
        return curve.points.T
    breaks = np.unique(curve.knots[0])
    inside = np.linspace(breaks[:-1], breaks[1:], 7).T.ravel()
    return curve.evaluate(inside)


def _is_segment(curve: Nurbs) -> bool:
    return curve.degrees == (1,) and len(curve.points) == 2


def is_planar(face: BrepFace) -> bool:
    """A plane, or a spline surface whose control points lie in one."""
    if face.surface.kind == PLANE:
        return True
    box = parameter_box(face)
    if box is None or face.surface.basis is not None:
        return False
    points = surface_nurbs(face.surface, *box).points.reshape(-1, 3)
    sizes = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
    return bool(sizes[2] < FLAT * sizes[0])


def plane_of(face: BrepFace) -> tuple[Array, Array]:
    """A point of a planar face and two unit vectors (2, 3) in it; their cross product is along
    ∂u × ∂v of the surface."""
    if face.surface.kind == PLANE:
        origin, _, x, y = face.surface.frame
        first, second = np.array([x, y]) @ face.matrix[:3, :3].T
        return face.matrix[:3, :3] @ origin + face.matrix[:3, 3], np.array([first, second])
    box = parameter_box(face)
    assert box is not None
    surface = located(surface_nurbs(face.surface, *box), face)
    middle = [0.5 * (low + high) for low, high in surface.domain]
    tangents = surface.derivatives(1, *middle)
    flat = surface.points.reshape(-1, 3)
    centre = flat.mean(axis=0)
    first, second = np.linalg.svd(flat - centre, full_matrices=False)[2][:2]
    along = np.cross(first, second) @ np.cross(tangents[1, 0], tangents[0, 1])
    return centre, np.array([first, second if along > 0 else -second])


def located(surface: Nurbs, face: BrepFace) -> Nurbs:
    """A piece of the face's surface in the model's coordinates."""
    return surface.transformed(face.matrix[:3, :3], face.matrix[:3, 3])
