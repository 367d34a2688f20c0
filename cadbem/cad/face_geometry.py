"""What a face of the CAD model looks like: its edges, parameters, plane and loops."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from cadbem.cad.brep import BrepFace, EdgeUse
from cadbem.cad.brep_geometry import PLANE
from cadbem.cad.coons import joined, segment
from cadbem.cad.curves import Interval, curve_nurbs
from cadbem.cad.surfaces import natural_domain, surface_nurbs
from cadbem.errors import CadError
from cadbem.spline.basis import Array
from cadbem.spline.nurbs import Nurbs

SHARPEST = 0.02  # sine of the smallest angle that counts as a corner
FLAT = 1e-7  # deviation from a line, plane or rectangle that is still rounding, per size of it


def shape_of(face: BrepFace) -> str:
    """In words: kind of surface, edges, holes."""
    counts = {"edge": sum(map(len, face.loops)), "hole": max(len(face.loops) - 1, 0)}
    words = [f"{count} {what}{'s' * (count != 1)}" for what, count in counts.items()]
    return ", ".join([face.surface.kind, *words])


def world_curve(use: EdgeUse) -> Nurbs | None:
    """The edge in the model's coordinates, as its curve runs; None if it is a point."""
    if use.curve is None:
        return None
    return curve_nurbs(use.curve, use.interval).transformed(use.matrix[:3, :3], use.matrix[:3, 3])


def edge_points(face: BrepFace) -> Array:
    """Points (n, 3) along the face's edges, in the model's coordinates."""
    points = [points_on(use) for loop in face.loops for use in loop if use.curve is not None]
    return np.concatenate(points) if points else np.zeros((0, 3))


def points_on(use: EdgeUse) -> Array:
    """Points (n, 3) along an edge that is not a point."""
    try:
        curve = world_curve(use)
    except CadError:  # a curve that is no NURBS; its ends must do
        return use.ends
    assert curve is not None
    return curve.evaluate(np.linspace(*curve.domain[0], 9)).T


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


def parameter_curves(face: BrepFace) -> list[Nurbs]:
    """The edges as curves (2D) in the parameter plane, in the loops' order; [] if one lacks it."""
    curves = []
    for loop in face.loops:
        for use in loop:
            curve = _parameter_curve(face, use)
            if curve is None:
                return []
            curves.append(curve)
    return curves


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
    # on a seam the second curve belongs to the reversed pass
    record = use.parameter_curves[-1 if use.sign < 0 else 0]
    return curve_nurbs(record, use.interval)


def sampled(curve: Nurbs) -> Array:
    """Points (dim, n) on every span of the curve."""
    breaks = np.unique(curve.knots[0])
    inside = np.linspace(breaks[:-1], breaks[1:], 7).T.ravel()
    return curve.evaluate(inside)


def located(surface: Nurbs, face: BrepFace) -> Nurbs:
    """A piece of the face's surface in the model's coordinates."""
    return surface.transformed(face.matrix[:3, :3], face.matrix[:3, 3])


def planar_loop(face: BrepFace) -> list[EdgeUse] | None:
    """The edges of a plane face's only loop, one after the other; None if it is not such."""
    uses = [use for loop in face.loops for use in loop]
    if len(face.loops) != 1 or any(use.curve is None for use in uses) or not _is_planar(face):
        return None
    return _chained(uses)


def _is_planar(face: BrepFace) -> bool:
    """A plane, or a spline surface whose control points lie in one."""
    if face.surface.kind == PLANE:
        return True
    box = parameter_box(face)
    if box is None or face.surface.basis is not None:
        return False
    points = surface_nurbs(face.surface, *box).points.reshape(-1, 3)
    sizes = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
    return bool(sizes[2] < FLAT * sizes[0])


def _chained(uses: list[EdgeUse]) -> list[EdgeUse] | None:
    """A wire lists its edges in any order: follow them from vertex to vertex."""
    rest, chain = uses[1:], uses[:1]
    while rest:
        end = _ends(chain[-1])[1]
        gaps = [float(np.linalg.norm(_ends(use)[0] - end)) for use in rest]
        nearest = int(np.argmin(gaps))
        size = np.ptp(np.concatenate([use.ends for use in uses]), axis=0).max()
        if gaps[nearest] > 1e-5 * size:
            return None
        chain.append(rest.pop(nearest))
    return chain


def _ends(use: EdgeUse) -> Array:
    return use.ends[:: use.sign]


def _along_loop(use: EdgeUse) -> Nurbs:
    curve = world_curve(use)
    assert curve is not None
    return curve if use.sign > 0 else curve.reversed()


def planar_edges(face: BrepFace) -> list[Nurbs]:
    """The edges of a plane face with one loop, in its direction; [] if it is not such.

    Straight edges that continue each other are one.
    """
    edges = [_along_loop(use) for use in planar_loop(face) or []]
    return _merged(edges, _continues, lambda a, b: segment(a.points[0], b.points[-1]))


def planar_sides(face: BrepFace) -> list[Nurbs]:
    """As `planar_edges`, but all edges between two corners are one curve, with a kink in it."""
    return _merged(planar_edges(face), _is_smooth, joined)


def _merged(
    curves: list[Nurbs],
    belong: Callable[[Nurbs, Nurbs], bool],
    merge: Callable[[Nurbs, Nurbs], Nurbs],
) -> list[Nurbs]:
    """Neighbours round the loop that belong together, merged."""
    merged = curves[:1]
    for curve in curves[1:]:
        if belong(merged[-1], curve):
            merged[-1] = merge(merged[-1], curve)
        else:
            merged.append(curve)
    if len(merged) > 1 and belong(merged[-1], merged[0]):
        merged[0] = merge(merged.pop(), merged[0])
    return merged


def _is_smooth(first: Nurbs, second: Nurbs) -> bool:
    """Whether the second goes on in the direction in which the first ends."""
    ahead, onward = first.points[-1] - first.points[-2], second.points[1] - second.points[0]
    product = np.linalg.norm(ahead) * np.linalg.norm(onward)
    turn = np.linalg.norm(np.cross(ahead, onward))
    return bool(turn < SHARPEST * product and ahead @ onward > 0)


def _continues(first: Nurbs, second: Nurbs) -> bool:
    points = np.concatenate([first.points, second.points])
    chord = points[-1] - points[0]
    length = np.linalg.norm(chord)
    if length == 0:
        return False
    steps = (points - points[0]) @ chord / length
    off = np.linalg.norm(points - points[0] - np.outer(steps, chord / length), axis=1)
    return bool(off.max() < FLAT * length and (np.diff(steps) > -FLAT * length).all())


def normal(face: BrepFace) -> Array:
    """Unit ∂u × ∂v of a planar face's surface."""
    box = parameter_box(face) or ((0.0, 1.0), (0.0, 1.0))
    surface = located(surface_nurbs(face.surface, *box), face)
    middle = [0.5 * (low + high) for low, high in surface.domain]
    tangents = surface.derivatives(1, *middle)
    direction = np.cross(tangents[1, 0], tangents[0, 1])
    return direction / np.linalg.norm(direction)
