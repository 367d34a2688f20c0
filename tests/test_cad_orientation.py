"""Normals of closed shells come out right, and faces that bound nothing are left out."""

import re
from collections.abc import Callable
from dataclasses import replace
from math import pi
from pathlib import Path

import gmsh
import numpy as np
import pytest
from drawn import exported

from cadbem.cad import read_cad
from cadbem.cad.body.model import open_model
from cadbem.cad.body.orientation import enclosed, shells_of
from cadbem.cad.kernel.brep import BrepFace, read_brep
from cadbem.errors import CadWarning

occ = gmsh.model.occ


def hollow_box():
    """3 × 3 × 3 with a closed cavity of 1 × 1 × 1 about (1.5, 1.5, 1.5)."""
    occ.cut([(3, occ.addBox(0, 0, 0, 3, 3, 3))], [(3, occ.addBox(1, 1, 1, 1, 1, 1))])


def cone():
    occ.addCone(0, 0, 0, 0, 0, 3, 2, 0)


def holed_plate():
    occ.cut([(3, occ.addBox(0, 0, 0, 4, 4, 1))], [(3, occ.addCylinder(2, 2, 0, 0, 0, 1, 1))])


def ball():
    occ.addSphere(1, 2, 3, 2)


def dented_torus():
    occ.fuse([(3, occ.addTorus(0, 0, 0, 3, 1))], [(3, occ.addCylinder(0, 0, -1, 0, 0, 2, 3))])


SOLIDS = [
    (cone, pi * 4),  # π r² h / 3
    (holed_plate, 16 - pi),
    (ball, pi * 32 / 3),
    (hollow_box, 26),
    # cylinder 2 π R² r and the outer half of the torus, π² r² R + (4/3) π r³ (Pappus)
    (dented_torus, 18 * pi + 3 * pi**2 + 4 * pi / 3),
]


@pytest.mark.parametrize(("author", "size"), SOLIDS)
@pytest.mark.parametrize("mirrored", [False, True])
def test_normals_come_out_right(
    folder: Path, author: Callable[[], None], size: float, mirrored: bool
):
    """The volume is positive if normals point out of the material; mirroring does not change it."""
    author()
    if mirrored:
        occ.mirror(occ.getEntities(3), 1, 2, 3, 4)
    path = exported(folder / "solid.step")
    assert enclosed(open_model(path, 60.0, fluid="material").faces) == pytest.approx(size, rel=1e-8)


def mirrored_record(path: Path) -> tuple[list[BrepFace], list[BrepFace]]:
    """Faces of a `.brep` record as it is, and with a location that mirrors in x at its root."""
    text = path.read_text()
    mirror = "1\n-1 0 0 0\n0 1 0 0\n0 0 1 0\n"
    count = int(re.search(r"Locations (\d+)", text)[1])  # type: ignore[index]
    found = text.replace(f"Locations {count}\n", f"Locations {count + 1}\n")
    position = found.index("Curve2ds")
    found = f"{found[:position]}{mirror}{found[position:]}"
    head, _, tail = found.rpartition("+1 ")
    return read_brep(text), read_brep(f"{head}+1 {tail.replace('0', str(count + 1), 1)}")


def test_a_location_that_mirrors_changes_no_volume(folder: Path):
    """A wedge with corners x = 0 ... 3 mirrored by its location: corners at -3 ... 0, V = 8."""
    points = [occ.addPoint(x, y, 0) for x, y in ((0, 0), (3, 0), (1, 2), (0, 2))]
    lines = [occ.addLine(points[i - 1], points[i]) for i in range(4)]
    occ.extrude([(2, occ.addPlaneSurface([occ.addCurveLoop(lines)]))], 0, 0, 2)
    plain, mirrored = mirrored_record(exported(folder / "wedge.brep"))
    ends = np.concatenate([use.ends for f in mirrored for loop in f.loops for use in loop])
    assert ends[:, 0].min() == pytest.approx(-3)
    for faces in (plain, mirrored):
        (shell,) = shells_of(faces)
        assert shell.volume == pytest.approx(8, rel=1e-12)


def test_faces_turned_at_random_are_turned_alike(folder: Path):
    """Whatever side the faces of a hollow box face at first, they enclose 27 - 1."""
    hollow_box()
    model = open_model(exported(folder / "hollow.step"), 60.0, fluid="material")
    random = np.random.default_rng(5)
    for _ in range(3):
        signs = random.choice([-1, 1], size=12)
        turned = [
            replace(f, outward=f.outward * int(s)) for f, s in zip(model.faces, signs, strict=True)
        ]
        outer, inner = shells_of(turned)
        assert outer.volume == pytest.approx(27, rel=1e-12)
        assert inner.volume == pytest.approx(-1, rel=1e-12)


def sheet_beside():
    occ.addRectangle(0.2, 0.2, 0.5, 0.4, 0.4)


def sheet_crossing():
    """A sheet that the solid's shell knows: the kernel calls it internal."""
    occ.fragment([(3, 1)], [(2, occ.addRectangle(0.2, 0.2, 0.5, 0.4, 0.4))])


def test_a_sheet_in_the_fluid_is_left_out_with_a_warning(folder: Path):
    occ.addBox(0, 0, 0, 1, 1, 1)
    sheet_beside()
    with pytest.warns(CadWarning, match=r"1 face bounds no volume.*\[0.4, 0.4, 0.5\] mm: left out"):
        boundary = read_cad(exported(folder / "sheet.step"))
    assert boundary.volume() == pytest.approx(1, rel=1e-12)
    assert len(boundary.patches) == 6


def test_internal_faces_of_a_record_bound_nothing(folder: Path):
    """The record's solid has six sides and, in a shell of its own, the sheet as internal face."""
    occ.addBox(0, 0, 0, 1, 1, 1)
    sheet_crossing()
    faces = read_brep(exported(folder / "sheet.brep").read_text())
    solid = [face for face in faces if face.solid]
    assert sorted(face.outward != 0 for face in solid) == [False] + [True] * 6
