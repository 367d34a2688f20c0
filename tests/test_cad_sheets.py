"""Sheets that lie on faces of a solid and name them."""

import re
from math import pi
from pathlib import Path

import gmsh
import pytest
from drawn import exported

from cadbem.boundary import Boundary
from cadbem.cad import read_cad
from cadbem.errors import CadWarning

occ = gmsh.model.occ


def test_named_sheets_name_the_faces_that_they_lie_on(folder: Path):
    """A pipe of radius 1, 3 long, turned by half a radian, as is a disc on its end; another sheet
    lies beside it. Names stand on the shell, on its model and on the product."""
    pipe = [(3, occ.addCylinder(0, 0, 0, 3, 0, 0, 1))]
    disc = occ.addDisk(0, 0, 0, 1, 1)
    occ.rotate([(2, disc)], 0, 0, 0, 0, 1, 0, pi / 2)
    aside = occ.addRectangle(0, 0, 5, 1, 1)
    occ.rotate([*pipe, (2, disc), (2, aside)], 0, 0, 0, 0, 0, 1, 0.5)
    path = exported(folder / "pipe.step")
    text = path.read_text()
    for word in ("OPEN_SHELL", "SHELL_BASED_SURFACE_MODEL", "PRODUCT"):
        if word == "PRODUCT":
            named_text = re.sub(
                r"PRODUCT\('Open CASCADE STEP translator [\d. ]+\.2'", "PRODUCT('inlet'", text
            )
        else:
            named_text = text.replace(f"{word}(''", f"{word}('inlet'", 1)
        assert named_text != text
        path.write_text(named_text)
        with pytest.warns(CadWarning, match="1 face bounds no volume"):
            boundary = read_cad(path)
        assert boundary.names == ("", "inlet")
        caps = tuple(boundary.patches[k] for k in boundary.select("inlet"))
        assert Boundary(caps).area() == pytest.approx(pi)
        assert read_cad(path, names="layers").names == ("",)


def test_sheets_that_name_no_face_are_said(folder: Path):
    """A square on a part of a box's side."""
    occ.addBox(0, 0, 0, 2, 2, 2)
    occ.addRectangle(0.5, 0.5, 2, 1, 1)
    path = exported(folder / "part.step")
    path.write_text(path.read_text().replace("OPEN_SHELL(''", "OPEN_SHELL('probe'", 1))
    with pytest.warns(CadWarning, match="left out 'probe', which names no face"):
        assert read_cad(path).volume() == pytest.approx(8)
