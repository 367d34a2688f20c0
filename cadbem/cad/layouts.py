"""A face of the CAD model as NURBS patches: the cascade of ways to lay patches out.

Each way takes a face and returns its patches with ∂u × ∂v in the surface's own direction, or
None where it does not apply. A way for trimmed faces joins `WAYS` as the last one.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from cadbem.cad.brep import BrepFace, EdgeUse
from cadbem.cad.brep_geometry import CIRCLE, ELLIPSE, PLANE, CurveRecord
from cadbem.cad.coons import coons_patch, disk_patches
from cadbem.cad.curves import Interval, curve_nurbs
from cadbem.cad.surfaces import natural_domain, smooth_pieces, surface_nurbs
from cadbem.errors import CadError
from cadbem.spline.basis import Array
from cadbem.spline.nurbs import Nurbs

FLAT = 1e-7  # deviation from a line, plane or rectangle that is still rounding, per size of it
SHARPEST = 0.02  # smallest sine of an angle between the edges or parameter lines of a patch


def face_patches(face: BrepFace) -> list[Nurbs]:
    """Smooth patches that cover the face exactly, their normals pointing into the solid.

    Raises CadError, saying what the face is like, if no way of laying patches applies.
    """
    for way in WAYS:
        surfaces = way(face)
        if surfaces:
            pieces = [piece for surface in surfaces for piece in smooth_pieces(surface)]
            return [piece.swapped() for piece in pieces] if face.outward > 0 else pieces
    raise CadError(shape_of(face))


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


def parameter_box(face: BrepFace) -> tuple[Interval, Interval] | None:
    """The rectangle of parameters round the face; None if an edge has no parameter curve."""
    curves = _parameter_curves(face)
    if not curves:
        return None
    samples = np.concatenate([_sampled(curve) for curve in curves], axis=1)
    box = []
    for low, high, (start, stop) in zip(
        samples.min(axis=1), samples.max(axis=1), natural_domain(face.surface), strict=True
    ):
        tolerance = FLAT * (high - low)
        low = start if abs(low - start) < tolerance else max(low, start)
        box.append((float(low), float(stop if abs(high - stop) < tolerance else min(high, stop))))
    return box[0], box[1]


def whole_rectangle(face: BrepFace) -> list[Nurbs] | None:
    """The face fills a rectangle of its surface's parameters."""
    box = parameter_box(face)
    if box is None or len(face.loops) != 1:
        return None
    bounds = np.array(box)
    lengths = np.diff(bounds).ravel()
    travelled = 0.0
    for curve in _parameter_curves(face):
        points = (_sampled(curve) - bounds[:, :1]) / lengths[:, None]
        if not any(np.abs(row - side).max() < FLAT for row in points for side in (0, 1)):
            return None
        travelled += np.abs(np.diff(points, axis=1)).sum()
    if abs(travelled - 4) > 1e-3:  # the loop covers the rectangle's border once
        return None
    return [_located(surface_nurbs(face.surface, *box), face)]


def planar_disk(face: BrepFace) -> list[Nurbs] | None:
    """A plane face whose only loop is one circle or ellipse, perhaps in several arcs."""
    loop = _planar_loop(face)
    conics = [use.curve for use in loop or [] if use.curve and use.curve.kind in (CIRCLE, ELLIPSE)]
    if not loop or len(conics) != len(loop):
        return None
    turn = sum(use.interval[1] - use.interval[0] for use in loop)
    if abs(turn - 2 * np.pi) > 1e-6 or not all(_same_conic(conics[0], c) for c in conics):
        return None
    origin, x, y = conics[0].frame
    place = loop[0].matrix
    a, b = conics[0].sizes[0], conics[0].sizes[-1]
    disk = disk_patches(origin, a * x, b * y, loop[0].interval[0])
    return _facing(face, [s.transformed(place[:3, :3], place[:3, 3]) for s in disk])


def planar_four_sided(face: BrepFace) -> list[Nurbs] | None:
    """A plane face with one loop of four sides; straight edges in line count as one side."""
    loop = _planar_loop(face)
    if not loop:
        return None
    sides = _merged([_along_loop(use) for use in loop])
    if len(sides) != 4:
        return None
    try:
        patch = coons_patch(sides)
    except ValueError:  # a weight vanished: the edges bend too much
        return None
    facing = _facing(face, [patch])
    return facing if _is_regular(facing[0], _normal(face)) else None


WAYS = (whole_rectangle, planar_disk, planar_four_sided)


def _parameter_curves(face: BrepFace) -> list[Nurbs]:
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


def _sampled(curve: Nurbs) -> Array:
    breaks = np.unique(curve.knots[0])
    inside = np.linspace(breaks[:-1], breaks[1:], 7).T.ravel()
    return curve.evaluate(inside)


def _located(surface: Nurbs, face: BrepFace) -> Nurbs:
    return surface.transformed(face.matrix[:3, :3], face.matrix[:3, 3])


def _planar_loop(face: BrepFace) -> list[EdgeUse] | None:
    """The edges of a plane face's only loop, one after the other."""
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
    curve = curve_nurbs(use.curve, use.interval) if use.curve else None
    assert curve is not None
    curve = curve.transformed(use.matrix[:3, :3], use.matrix[:3, 3])
    return curve if use.sign > 0 else curve.reversed()


def _same_conic(first: CurveRecord, second: CurveRecord) -> bool:
    size = max(first.sizes)
    same_centre = np.allclose(first.frame[0], second.frame[0], rtol=0, atol=FLAT * size)
    same_axes = first.kind == CIRCLE or np.allclose(abs(first.frame), abs(second.frame))
    return bool(same_centre and same_axes and np.allclose(first.sizes, second.sizes, rtol=FLAT))


def _merged(sides: list[Nurbs]) -> list[Nurbs]:
    """Straight edges that continue each other become one."""
    joined = [sides[0]]
    for side in sides[1:]:
        if _continues(joined[-1], side):
            joined[-1] = _straight(joined[-1], side)
        else:
            joined.append(side)
    if len(joined) > 2 and _continues(joined[-1], joined[0]):
        joined[0] = _straight(joined.pop(), joined[0])
    return joined


def _continues(first: Nurbs, second: Nurbs) -> bool:
    points = np.concatenate([first.points, second.points])
    chord = points[-1] - points[0]
    length = np.linalg.norm(chord)
    if length == 0:
        return False
    steps = (points - points[0]) @ chord / length
    off = np.linalg.norm(points - points[0] - np.outer(steps, chord / length), axis=1)
    return bool(off.max() < FLAT * length and (np.diff(steps) > -FLAT * length).all())


def _straight(first: Nurbs, second: Nurbs) -> Nurbs:
    knots = np.array([0.0, 0.0, 1.0, 1.0])
    return Nurbs((1,), (knots,), np.stack([first.points[0], second.points[-1]]), np.ones(2))


def _normal(face: BrepFace) -> Array:
    """Unit ∂u × ∂v of a planar face's surface."""
    box = parameter_box(face) or ((0.0, 1.0), (0.0, 1.0))
    surface = _located(surface_nurbs(face.surface, *box), face)
    middle = [0.5 * (low + high) for low, high in surface.domain]
    tangents = surface.derivatives(1, *middle)
    normal = np.cross(tangents[1, 0], tangents[0, 1])
    return normal / np.linalg.norm(normal)


def _facing(face: BrepFace, surfaces: list[Nurbs]) -> list[Nurbs]:
    normal = _normal(face)
    middle = [[0.5 * (low + high) for low, high in s.domain] for s in surfaces]
    tangents = [s.derivatives(1, *m) for s, m in zip(surfaces, middle, strict=True)]
    same = [np.cross(t[1, 0], t[0, 1]) @ normal > 0 for t in tangents]
    return [s if keep else s.swapped() for s, keep in zip(surfaces, same, strict=True)]


def _is_regular(surface: Nurbs, normal: Array) -> bool:
    """No fold and no vanishing angle at corners or inside."""
    u, v = (
        np.concatenate([np.linspace(a, b, 9) for a, b in pairwise(surface.breaks(d))])
        for d in (0, 1)
    )
    tangents = surface.derivatives(1, *np.meshgrid(u, v, indexing="ij"))
    along_u, along_v = tangents[1, 0], tangents[0, 1]
    area = np.einsum("i...,i...->...", np.cross(along_u, along_v, axis=0), normal)
    lengths = np.linalg.norm(along_u, axis=0) * np.linalg.norm(along_v, axis=0)
    return bool((area > SHARPEST * lengths).all())
