"""A face of the CAD model as NURBS patches.

A face that fills a rectangle of its surface's parameters is that piece of the surface, exactly.
Any other face is spread out in the plane, divided into four-sided parts there, and each part
becomes a patch: exact for plane faces, within a tolerance for others.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cadbem.boundary import Boundary, Patch
from cadbem.cad.faces.consistency import misfit
from cadbem.cad.faces.face_geometry import (
    FLAT,
    edge_length,
    located,
    parameter_box,
    parameter_curves,
    sampled,
    size_of,
)
from cadbem.cad.faces.flux import face_area
from cadbem.cad.faces.surfaces import smooth_pieces, surface_nurbs
from cadbem.cad.kernel.brep import BrepFace
from cadbem.cad.layout.charts import chart_of
from cadbem.cad.layout.partition import divided
from cadbem.cad.layout.parts import Part
from cadbem.cad.layout.quality import worst_angle
from cadbem.errors import CadError
from cadbem.spline.nurbs import Nurbs

TOLERANCE = 1e-6  # deviation from a curved trimmed face, per size of the face
UNCOVERED = 1e-5  # share of the area by which patches may miss it: what quadrature is sure of
ORDER = 12
REMEDY = "split it into simpler faces in your CAD program"
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

    Raises CadError, saying why and what helps, if there is no way to lay patches within it.
    """
    try:
        whole = _rectangle(face)
        pieces = [(whole, 0.0)] if whole else _parts(face, tolerance)
    except ValueError:  # weights vanish: edges bend too much
        raise CadError(f"its edges bend too much; {REMEDY}") from None
    surfaces = [smooth for surface, _ in pieces for smooth in smooth_pieces(surface)]
    if face.outward > 0:
        surfaces = [surface.swapped() for surface in surfaces]
    covering = Covering(tuple(surfaces), max(deviation for _, deviation in pieces))
    if not whole:
        _check(face, covering, tolerance)
    return covering


def _rectangle(face: BrepFace) -> Nurbs | None:
    """The face as a piece of its surface, if it fills a rectangle of the surface's parameters."""
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
    return located(surface_nurbs(face.surface, *box), face)


def _parts(face: BrepFace, tolerance: float) -> list[tuple[Nurbs, float]]:
    chart = chart_of(face)
    if chart is None:
        raise CadError("its edges do not close in its surface's parameters; export it again")
    parts: list[Part] = []
    for region in chart.regions:
        found = divided(region)
        if found is None:
            raise CadError(f"no way was found to divide it into well-shaped patches; {REMEDY}")
        parts += found
    allowed = tolerance * size_of(face)
    pieces = [piece for part in parts for piece in chart.pieces(part, allowed)]
    if allowed < misfit(face) < max(deviation for _, deviation in pieces):
        # edges that contradict the face are rough: more spans would follow their noise
        pieces = [piece for part in parts for piece in chart.pieces(part, misfit(face))]
    return pieces


def _allowed(face: BrepFace, tolerance: float) -> float:
    """Deviation (mm) allowed: no less than by how much the face's own edges contradict it."""
    return max(tolerance * size_of(face), misfit(face))


def _check(face: BrepFace, covering: Covering, tolerance: float) -> None:
    """Raises CadError if patches fold, stray from the face or do not cover it once."""
    allowed = _allowed(face, tolerance)
    if covering.deviation > allowed:
        raise CadError(
            f"patches would deviate from it by {covering.deviation / size_of(face):.1e} of its "
            f"size, more than the tolerance {tolerance:g}; allow more with tolerance, or {REMEDY}"
        )
    if min(worst_angle(surface) for surface in covering.surfaces) < SHARPEST:
        raise CadError(f"patches would fold; {REMEDY}")
    patches = Boundary(tuple(Patch(surface) for surface in covering.surfaces))
    area, expected = patches.area(ORDER), face_area(face)
    if abs(area - expected) > UNCOVERED * expected + allowed * edge_length(face):
        raise CadError(f"patches would cover {area / expected:.7f} of its area; {REMEDY}")
