"""The CAD kernel as a witness: its own triangles must lie where the patches of each face lie."""

from __future__ import annotations

import math

import numpy as np
from scipy.spatial import cKDTree

from cadbem.boundary import Boundary
from cadbem.cad.body.model import CadModel
from cadbem.cad.faces.face_geometry import size_of
from cadbem.points import gauss_measures

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
    places = _places(boundary)
    wrong = []
    for face in known:
        area, middle = places[face.number]
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


def _places(boundary: Boundary) -> dict[int, tuple[float, np.ndarray]]:
    """Area and middle (3,) of each face, by number."""
    position, normal, weights = gauss_measures([p.surface for p in boundary.patches], ORDER)
    sizes = np.linalg.norm(normal, axis=0) * weights
    counts = [ORDER**2 * math.prod(len(p.surface.breaks(d)) - 1 for d in (0, 1))
              for p in boundary.patches]  # fmt: skip
    owner = np.repeat([patch.face for patch in boundary.patches], counts)
    found = {}
    for face in np.unique(owner):
        own = owner == face
        area = float(sizes[own].sum())
        found[int(face)] = area, position[:, own] @ sizes[own] / area
    return found
