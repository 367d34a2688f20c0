"""Consistency of vertices, edges and faces of a file.

A vertex, an edge's curve, its curve in the face's parameters and the face's surface hold the same
geometry more than once: if a digit of one of them is wrong, it contradicts the others.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from cadbem.cad.faces.evaluate import KernelSurface, curve_point
from cadbem.cad.faces.face_geometry import REMEMBERED, parameter_box, real_uses, size_of
from cadbem.cad.kernel.brep import BrepFace, EdgeUse
from cadbem.cad.kernel.brep_geometry import PLANE
from cadbem.cad.text.unit import Unit
from cadbem.errors import CadError
from cadbem.spline.basis import Array

SAMPLES = 9
ROUNDING = 1e-8  # misfit, per size of the model, that is one of digits
LOOSE = 1e-6  # misfit, per size of the model, that is warned of
WRONG = 1e-3  # ... and that is refused; sloppy but honest files reach 1e-4


def contradictions(
    file: str, unit: Unit, faces: tuple[BrepFace, ...]
) -> tuple[list[str], list[str]]:
    """Lines to warn with and lines to refuse the model with: one in one of them, or none."""
    misfits = [misfit(face) for face in faces]
    size = size_of(*faces)
    worst = max(misfits)
    if worst <= LOOSE * size:
        return [], []
    face = faces[misfits.index(worst)]
    line = (
        f"{file}: edges and vertices of face {face.number} ({face.surface.kind}) are up to "
        f"{worst / unit.millimetres:.2g} {unit.name} off each other or off the face; "
    )
    if worst <= WRONG * size:
        return [f"{line}results are no more exact than that"], []
    return [], [f"{line}the file is damaged, export it again"]


def sewing_gaps(file: str, unit: Unit, faces: tuple[BrepFace, ...]) -> list[str]:
    """A line if faces that were sewn lie further apart than the file's digits explain."""
    worst = max(misfit(face) for face in faces)
    size = size_of(*faces)
    if not ROUNDING * size < worst <= LOOSE * size:
        return []
    return [f"{file}: healed: faces {worst / unit.millimetres:.1g} {unit.name} apart were sewn"]


@lru_cache(maxsize=REMEMBERED)
def misfit(face: BrepFace) -> float:
    """Largest distance of a vertex from the end of its edge, and of an edge from the face; mm."""
    box = parameter_box(face)
    surface = None if box is None else KernelSurface(face.surface, *box, face.matrix)
    return max((_misfit(face, surface, use) for use in real_uses(face)), default=0.0)


def _misfit(face: BrepFace, surface: KernelSurface | None, use: EdgeUse) -> float:
    t = np.linspace(*use.interval, SAMPLES)
    assert use.curve is not None
    try:
        turn, shift = use.matrix[:3, :3], use.matrix[:3, 3:]
        points = turn @ curve_point(use.curve, t)[0] + shift
        off_vertices = np.linalg.norm(points[:, [0, -1]].T - use.ends, axis=1).max()
        return float(max(off_vertices, _off_surface(face, surface, use, points, t)))
    except CadError:  # an offset curve: the kernel alone knows what it is
        return 0.0


def _off_surface(
    face: BrepFace, surface: KernelSurface | None, use: EdgeUse, points: Array, t: Array
) -> float:
    if face.surface.kind == PLANE:  # planes may lack parameter curves
        origin, _, x, y = face.surface.frame
        normal = face.matrix[:3, :3] @ np.cross(x, y)
        offset = normal @ (face.matrix[:3, :3] @ origin + face.matrix[:3, 3])
        return float(np.abs(normal @ points - offset).max() / np.linalg.norm(normal))
    if surface is None:
        return 0.0
    gaps = []
    for curve in use.parameter_curves:  # a seam has two
        there = surface.points(*curve_point(curve, t)[0])
        gaps.append(float(np.linalg.norm(there - points, axis=0).max()))
    return min(gaps, default=0.0)
