"""The CAD kernel as a witness: its own triangles must lie where the patches of each face lie."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.spatial import cKDTree

from cadbem.boundary import Boundary
from cadbem.cad.body.model import CadModel
from cadbem.cad.faces.face_geometry import size_of

COARSE = 0.03  # share of an area or volume by which the kernel's own may be off
ORDER = 6  # Gauss points a direction and element


def disagreements(model: CadModel, boundary: Boundary) -> list[str]:
    """Lines to warn with if area or place of a face, or the volume, are not those that the kernel
    has. Its triangles are coarse, and so is the comparison: it finds what is lost or misplaced."""
    lines = _misplaced(model, boundary)
    expected = sum(model.kernel.volumes[number - 1] for number in model.bodies)
    volume = boundary.volume() * model.unit.millimetres**3
    if model.bodies and abs(volume - expected) > COARSE * expected:
        lines.append(
            f"{model.file}: the patches enclose {volume / expected:.4g} times the volume that the "
            "CAD kernel finds; compare with the CAD program, and export again in the other format"
        )
    return lines


def _misplaced(model: CadModel, boundary: Boundary) -> list[str]:
    measures = np.reshape(model.kernel.measures, (-1, 4))
    known = [face for face in model.faces if face.number not in model.caps]
    if not len(measures) or not known:
        return []
    tree, scale = cKDTree(measures[:, 1:]), model.unit.millimetres
    groups: dict[int, list[int]] = {}
    for index, patch in enumerate(boundary.patches):
        groups.setdefault(patch.face, []).append(index)
    wrong = []
    for face in known:
        area, middle = _measure(boundary, groups[face.number])
        near = tree.query_ball_point(scale * middle, COARSE * size_of(face))
        areas = measures[near, 0]
        if not (np.abs(areas - scale**2 * area) <= COARSE * areas).any():
            wrong.append(face)
    if not wrong:
        return []
    return [
        f"{model.file}: {len(wrong)} faces are not where the CAD kernel has them, the first is "
        f"{model.label(wrong[0])}; compare with the CAD program, and export in the other format"
    ]


def _measure(boundary: Boundary, indices: Sequence[int]) -> tuple[float, np.ndarray]:
    """Area and middle (3,) of patches."""
    points, weights = Boundary(tuple(boundary.patches[k] for k in indices)).quadrature(ORDER)
    area = float(weights.sum())
    return area, points.position @ weights / area
