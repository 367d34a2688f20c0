"""Sheets: faces that belong to no solid. A named one that lies on a face of the fluid names it, as
programs for flows mark inlets."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from cadbem.cad.faces.face_geometry import edge_points, real_uses, size_of, world_curve
from cadbem.cad.kernel.brep import BrepFace
from cadbem.errors import CadError
from cadbem.spline.basis import Array
from cadbem.spline.project import closest_point

SAME = 1e-5  # distance, per size of the face, within which edges are the same


def names_by_sheets(
    faces: Sequence[BrepFace], sheets: Sequence[BrepFace], names: dict[int, str]
) -> tuple[dict[int, str], list[BrepFace]]:
    """Names of faces by number, and sheets that give none; `names` are those of the sheets."""
    called: dict[int, str] = {}
    left = []
    for sheet in sheets:
        name = names.get(sheet.number, "")
        under = [face for face in faces if name and _coincide(face, sheet)]
        called |= {face.number: name for face in under}
        left += [] if under else [sheet]
    return called, left


def _coincide(face: BrepFace, sheet: BrepFace) -> bool:
    """Whether both have the same edges, however these are divided, on the same side of them."""
    near = SAME * size_of(face)
    points, others = edge_points(face), edge_points(sheet)
    boxes = [np.stack([p.min(axis=0), p.max(axis=0)]) for p in (points, others)]
    if np.abs(boxes[0] - boxes[1]).max() > near:
        return False
    return _all_on(points, sheet, near) and _all_on(others, face, near)


def _all_on(points: Array, face: BrepFace, near: float) -> bool:
    """Whether points (n, 3) lie on edges of a face."""
    try:
        curves = [world_curve(use) for use in real_uses(face)]
    except CadError:
        return False
    gaps = [[closest_point(curve, p)[1] for p in points] for curve in curves if curve is not None]
    return bool(np.min(gaps, axis=0).max() < near)
