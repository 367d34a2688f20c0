"""A face of the CAD model as NURBS patches: the cascade of ways to lay patches out.

Each way takes a face and returns its patches with ∂u × ∂v in the surface's own direction, or
None where it does not apply. A way for trimmed faces joins `WAYS` as the last one.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from cadbem.cad.brep import BrepFace
from cadbem.cad.brep_geometry import CIRCLE, ELLIPSE, CurveRecord
from cadbem.cad.coons import coons_patch, round_patches, star_patches
from cadbem.cad.curves import arc
from cadbem.cad.face_geometry import (
    FLAT,
    SHARPEST,
    located,
    normal,
    parameter_box,
    parameter_curves,
    planar_edges,
    planar_loop,
    planar_sides,
    sampled,
    shape_of,
)
from cadbem.cad.surfaces import smooth_pieces, surface_nurbs
from cadbem.errors import CadError
from cadbem.spline.basis import Array
from cadbem.spline.nurbs import Nurbs

MOST_SIDES = 8  # of a face that is cut from a point inside


def face_patches(face: BrepFace) -> list[Nurbs]:
    """Smooth patches that cover the face exactly, their normals pointing into the solid.

    Raises CadError, saying what the face is like, if no way of laying patches applies.
    """
    for way in WAYS:
        try:
            surfaces = way(face)
        except ValueError:  # a weight vanished: edges bend too much for this way
            continue
        if surfaces:
            pieces = [piece for surface in surfaces for piece in smooth_pieces(surface)]
            return [piece.swapped() for piece in pieces] if face.outward > 0 else pieces
    raise CadError(shape_of(face))


def whole_rectangle(face: BrepFace) -> list[Nurbs] | None:
    """The face fills a rectangle of its surface's parameters."""
    box = parameter_box(face)
    if box is None or len(face.loops) != 1:
        return None
    bounds = np.array(box)
    lengths = np.diff(bounds).ravel()
    travelled = 0.0
    for curve in parameter_curves(face):
        points = (sampled(curve) - bounds[:, :1]) / lengths[:, None]
        if not any(np.abs(row - side).max() < FLAT for row in points for side in (0, 1)):
            return None
        travelled += np.abs(np.diff(points, axis=1)).sum()
    if abs(travelled - 4) > 1e-3:  # the loop covers the rectangle's border once
        return None
    return [located(surface_nurbs(face.surface, *box), face)]


def planar_ellipse(face: BrepFace) -> list[Nurbs] | None:
    """A plane face whose only loop is one circle or ellipse, perhaps in several arcs."""
    loop = planar_loop(face)
    conics = [use.curve for use in loop or [] if use.curve and use.curve.kind in (CIRCLE, ELLIPSE)]
    if not loop or len(conics) != len(loop):
        return None
    turn = sum(use.interval[1] - use.interval[0] for use in loop)
    if abs(turn - 2 * np.pi) > 1e-6 or not all(_same_conic(conics[0], c) for c in conics):
        return None
    origin, x, y = conics[0].frame
    a, b = conics[0].sizes[0], conics[0].sizes[-1]
    angles = loop[0].interval[0] + np.pi / 2 * np.arange(5)
    place = loop[0].matrix
    rim = [
        arc(origin, a * x, b * y, ends).transformed(place[:3, :3], place[:3, 3])
        for ends in pairwise(angles)
    ]
    return _accepted(face, round_patches(rim))


def planar_four_sided(face: BrepFace) -> list[Nurbs] | None:
    """A plane face with one loop of four sides."""
    sides = planar_sides(face)
    return _accepted(face, [coons_patch(sides)]) if len(sides) == 4 else None


def planar_round(face: BrepFace) -> list[Nurbs] | None:
    """A plane face with one, two or four sides that may meet smoothly, like an oval or a lens."""
    sides = planar_edges(face)
    if len(sides) not in (1, 2, 4):
        sides = planar_sides(face)
    if len(sides) not in (1, 2, 4):
        return None
    parts = 4 // len(sides)
    return _accepted(face, round_patches([piece for s in sides for piece in _cut(s, parts)]))


def planar_star(face: BrepFace) -> list[Nurbs] | None:
    """A plane face with one loop of few sides that a point in the middle sees all of."""
    sides = planar_sides(face)
    if not 3 <= len(sides) <= MOST_SIDES:
        return None
    return _accepted(face, star_patches([_cut(side, 2) for side in sides]))


WAYS = (whole_rectangle, planar_ellipse, planar_four_sided, planar_round, planar_star)


def _cut(curve: Nurbs, parts: int) -> list[Nurbs]:
    """Equal parts of the parameter's range, at a knot where one is there up to rounding."""
    low, high = curve.domain[0]
    knots = curve.breaks(0)
    ends = []
    for t in np.linspace(low, high, parts + 1):
        knot = knots[np.argmin(np.abs(knots - t))]
        ends.append(float(knot if abs(knot - t) < 1e-9 * (high - low) else t))
    return [curve.restricted(pair) for pair in pairwise(ends)]


def _same_conic(first: CurveRecord, second: CurveRecord) -> bool:
    size = max(first.sizes)
    same_centre = np.allclose(first.frame[0], second.frame[0], rtol=0, atol=FLAT * size)
    same_axes = first.kind == CIRCLE or np.allclose(abs(first.frame), abs(second.frame))
    return bool(same_centre and same_axes and np.allclose(first.sizes, second.sizes, rtol=FLAT))


def _accepted(face: BrepFace, surfaces: list[Nurbs]) -> list[Nurbs] | None:
    """The patches, turned to the face's normal, if none folds or has a vanishing angle."""
    direction = normal(face)
    turned = [s if _area_elements(s, direction).mean() > 0 else s.swapped() for s in surfaces]
    regular = all(_area_elements(s, direction).min() > SHARPEST for s in turned)
    return turned if regular else None


def _area_elements(surface: Nurbs, direction: Array) -> Array:
    """Sine of the angle between parameter lines, on a grid that holds corners and edges."""
    u, v = (
        np.concatenate([np.linspace(a, b, 9) for a, b in pairwise(surface.breaks(d))])
        for d in (0, 1)
    )
    tangents = surface.derivatives(1, *np.meshgrid(u, v, indexing="ij"))
    along_u, along_v = tangents[1, 0], tangents[0, 1]
    area = np.einsum("i...,i...->...", np.cross(along_u, along_v, axis=0), direction)
    lengths = np.linalg.norm(along_u, axis=0) * np.linalg.norm(along_v, axis=0)
    return area / np.where(lengths > 0, lengths, np.inf)
