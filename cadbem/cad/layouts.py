"""A face of the CAD model as NURBS patches: the cascade of ways to lay patches out.

Each way takes a face and returns its patches with ∂u × ∂v in the surface's own direction, or
None where it does not apply. A way for trimmed faces joins `WAYS` as the last one.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from cadbem.cad.brep import BrepFace
from cadbem.cad.coons import coons_patch, ring_patches, round_patches, star_patches
from cadbem.cad.face_geometry import (
    FLAT,
    located,
    parameter_box,
    parameter_curves,
    points_on,
    sampled,
    shape_of,
)
from cadbem.cad.loops import SHARPEST, conic_loop, loop_edges, loop_sides, normal
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


def planar_four_sided(face: BrepFace) -> list[Nurbs] | None:
    """A plane face with one loop of four sides."""
    sides = loop_sides(face)
    if len(sides) != 4 or len(face.loops) != 1:
        return None
    return _accepted(face, [coons_patch(sides)])


def planar_round(face: BrepFace) -> list[Nurbs] | None:
    """A plane face with one, two or four sides that may meet smoothly, like an oval or a lens."""
    rim = _rim(face, 0)
    return _accepted(face, round_patches(rim)) if len(rim) == 4 and len(face.loops) == 1 else None


def planar_star(face: BrepFace) -> list[Nurbs] | None:
    """A plane face with one loop of few sides that a point in the middle sees all of."""
    sides = loop_sides(face)
    if not 3 <= len(sides) <= MOST_SIDES or len(face.loops) != 1:
        return None
    return _accepted(face, star_patches([_cut(side, 2) for side in sides]))


def planar_ring(face: BrepFace) -> list[Nurbs] | None:
    """A plane face with one hole, a circle or an ellipse: a patch for each side of the border."""
    if len(face.loops) != 2:
        return None
    sizes = [np.ptp(np.concatenate([points_on(use) for use in loop]), axis=0).max()
             for loop in face.loops if all(use.curve for use in loop)]  # fmt: skip
    if len(sizes) != 2:
        return None
    hole = conic_loop(face, int(np.argmin(sizes)))
    rim = _rim(face, int(np.argmax(sizes)))
    if hole is None or not rim:
        return None
    angles = np.unwrap([hole.angle(curve.points[0]) for curve in [*rim, rim[0]]])
    if abs(abs(angles[-1] - angles[0]) - 2 * np.pi) > 1e-6:
        return None
    return _accepted(face, ring_patches(rim, [hole.arc(*ends) for ends in pairwise(angles)]))


WAYS = (
    whole_rectangle, planar_four_sided, planar_round, planar_star, planar_ring
)  # fmt: skip


def _rim(face: BrepFace, loop: int) -> list[Nurbs]:
    """A plane face's loop as a few curves, four if it has one, two or four sides."""
    conic = conic_loop(face, loop)
    if conic is not None:
        angles = conic.start + np.pi / 2 * np.arange(5)
        return [conic.arc(*ends) for ends in pairwise(angles)]
    sides = loop_edges(face, loop)
    if len(sides) not in (1, 2, 4):
        sides = loop_sides(face, loop)
    if not sides:
        return []
    parts = [1] * len(sides) if len(sides) > 2 else [4 // len(sides)] * len(sides)
    straight = [len(side.points) == 2 for side in sides]
    if len(sides) == 2 and any(straight):  # as in half a disk
        parts = [1, 3] if straight[0] else [3, 1]
    return [piece for side, n in zip(sides, parts, strict=True) for piece in _cut(side, n)]


def _cut(curve: Nurbs, parts: int) -> list[Nurbs]:
    """Equal parts of the parameter's range, at a knot where one is there up to rounding."""
    low, high = curve.domain[0]
    knots = curve.breaks(0)
    ends = []
    for t in np.linspace(low, high, parts + 1):
        knot = knots[np.argmin(np.abs(knots - t))]
        ends.append(float(knot if abs(knot - t) < 1e-9 * (high - low) else t))
    return [curve.restricted(pair) for pair in pairwise(ends)]


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
