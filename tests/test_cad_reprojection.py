"""Parameter curves that are off edges which lie on their face."""

from dataclasses import replace
from math import pi
from pathlib import Path

import gmsh
import numpy as np
import pytest

from cadbem.boundary import Boundary, Patch
from cadbem.cad.faces.consistency import misfit
from cadbem.cad.faces.flux import face_area
from cadbem.cad.faces.reprojection import reprojected
from cadbem.cad.faces.wraps import moved
from cadbem.cad.kernel.brep import BrepFace, EdgeUse, read_brep
from cadbem.cad.layout.face_patches import face_patches

occ = gmsh.model.occ


def pierced_wall(record: Path) -> BrepFace:
    """The wall of a cylinder of radius 1 and height 3 with a square hole of 0.8 in its side."""
    hole = [(3, occ.addBox(-2, -0.4, 1, 2, 0.8, 0.8))]
    occ.cut([(3, occ.addCylinder(0, 0, 0, 0, 0, 3, 1))], hole)
    occ.synchronize()
    gmsh.write(str(record))
    faces = read_brep(record.read_text())
    return max((f for f in faces if f.surface.kind == "cylinder"), key=lambda f: len(f.loops))


AREA = 6 * pi - 0.8 * 2 * np.arcsin(0.4)  # an arc of 0.8 chord, as high as the hole


def spoiled(face: BrepFace, change) -> BrepFace:
    return replace(face, loops=tuple(tuple(map(change, loop)) for loop in face.loops))


def shifted(use: EdgeUse) -> EdgeUse:
    """With its parameter curve moved by a hundredth, unless it is a seam."""
    if len(use.parameter_curves) != 1:
        return use
    return replace(use, parameter_curves=(moved(use.parameter_curves[0], np.array([0.01, 0.0])),))


def test_curves_are_projected_to_the_face_anew(record: Path):
    face = pierced_wall(record)
    assert face_area(face) == pytest.approx(AREA, rel=1e-8)
    bad = spoiled(face, shifted)
    assert misfit(bad) > 5e-3
    (good,), count = reprojected([bad])
    assert count == sum(len(use.parameter_curves) == 1 for loop in face.loops for use in loop)
    assert misfit(good) < 1e-8
    patches = Boundary(tuple(Patch(surface) for surface in face_patches(good).surfaces))
    assert patches.area() == pytest.approx(AREA, rel=1e-6)


def test_what_fits_or_lies_elsewhere_is_left(record: Path):
    """Faces without fault stay the same values; an edge that is off the face keeps its curve."""
    face = pierced_wall(record)
    (same,), count = reprojected([face])
    assert same is face and count == 0
    matrix = np.eye(4)
    matrix[0, 3] = 0.01

    def lifted(use: EdgeUse) -> EdgeUse:
        return replace(shifted(use), matrix=matrix @ use.matrix)

    hole = replace(face, loops=tuple(tuple(map(lifted, loop)) for loop in face.loops[1:]))
    (left,), count = reprojected([hole])
    assert left is hole and count == 0
