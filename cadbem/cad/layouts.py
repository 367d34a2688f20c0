"""A face of the CAD model as NURBS patches.

A face that fills a rectangle of its surface's parameters is that piece of the surface, exactly.
Any other face is spread out in the plane, divided into four-sided parts there, and each part
becomes a patch: exact for plane faces, within a tolerance for others.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cadbem.cad.brep import BrepFace
from cadbem.cad.charts import chart_of
from cadbem.cad.face_geometry import (
    FLAT,
    edge_points,
    located,
    parameter_box,
    parameter_curves,
    sampled,
    shape_of,
)
from cadbem.cad.partition import divided
from cadbem.cad.quality import worst_angle
from cadbem.cad.surfaces import smooth_pieces, surface_nurbs
from cadbem.errors import CadError
from cadbem.spline.nurbs import Nurbs

TOLERANCE = 1e-6  # deviation from a curved trimmed face, per size of the face
SHARPEST = 0.02  # angle (radians) between parameter lines at which a patch is folded


@dataclass(frozen=True, eq=False)
class Covering:
    """Smooth patches that cover a face, their normals pointing into the solid.

    `deviation` (mm) is the largest distance measured between patches and the face at equal
    parameters, 0 where the patches are pieces of the face's own surface or exact in its plane.
    """

    surfaces: tuple[Nurbs, ...]
    deviation: float


def face_patches(face: BrepFace, tolerance: float = TOLERANCE) -> Covering:
    """Patches of a face; `tolerance` is the deviation allowed per size of the face.

    Raises CadError, saying what the face is like, if there is no way to lay patches.
    """
    try:
        pieces = _rectangle(face) or _parts(face, tolerance)
    except ValueError:  # weights vanish: edges bend too much
        pieces = None
    if not pieces:
        raise CadError(shape_of(face))
    surfaces = [smooth for surface, _ in pieces for smooth in smooth_pieces(surface)]
    if face.outward > 0:
        surfaces = [surface.swapped() for surface in surfaces]
    return Covering(tuple(surfaces), max(deviation for _, deviation in pieces))


def _rectangle(face: BrepFace) -> list[tuple[Nurbs, float]] | None:
    """The face fills a rectangle of its surface's parameters."""
    box = parameter_box(face)
    if box is None or len(face.loops) != 1 or face.surface.basis is not None:
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
    return [(located(surface_nurbs(face.surface, *box), face), 0.0)]


def _parts(face: BrepFace, tolerance: float) -> list[tuple[Nurbs, float]] | None:
    chart = chart_of(face)
    parts = divided(chart.region) if chart else None
    if chart is None or parts is None:
        return None
    size = float(np.ptp(edge_points(face), axis=0).max())
    pieces = [piece for part in parts for piece in chart.pieces(part, tolerance * size)]
    return pieces if all(_is_regular(patch) for patch, _ in pieces) else None


def _is_regular(patch: Nurbs) -> bool:
    return worst_angle(patch) > SHARPEST
