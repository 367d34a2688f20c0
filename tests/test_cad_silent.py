"""What was once read wrongly without a word: lost bodies, misplaced parts, crossings, rooms."""

from dataclasses import replace
from math import pi
from pathlib import Path

import gmsh
import numpy as np
import pytest
from drawn import exported

from cadbem.cad import read_cad
from cadbem.cad.body.model import open_model
from cadbem.cad.body.witness import disagreements
from cadbem.cad.faces.curves import spline_nurbs
from cadbem.cad.kernel.brep import _read_locations
from cadbem.cad.kernel.brep_geometry import SplineRecord, Tokens
from cadbem.errors import CadError

occ = gmsh.model.occ


@pytest.mark.parametrize(
    ("draw", "volume", "area"),
    [
        (lambda: occ.addSphere(3, 1, 1, 0.6), 4 / 3 * pi * 0.216, 4 * pi * 0.36),
        (lambda: occ.addCylinder(2, 1, 1, 2, 0, 0, 0.3), pi * 0.18, pi * (1.2 + 0.18)),
        (lambda: occ.addCone(2, 1, 1, 2, 0, 0, 0.5, 0), pi / 6, pi * (0.25 + 0.5 * 4.25**0.5)),
    ],
)
def test_closed_curved_bodies_of_iges_files_stay(folder: Path, draw, volume: float, area: float):
    """A box 6 × 2 × 2 (V = 24, A = 56) round a ball (V = 4/3 π r³, A = 4 π r²), a rod (π r² l,
    2 π r l + 2 π r²) and a cone (π r² l / 3, π r² + π r s)."""
    occ.cut([(3, occ.addBox(0, 0, 0, 6, 2, 2))], [(3, draw())])
    boundary = read_cad(exported(folder / "free.igs"), fluid="material")
    assert boundary.volume() == pytest.approx(24 - volume, rel=1e-6)
    assert boundary.area() == pytest.approx(56 + area, rel=1e-6)


def test_two_bodies_of_an_iges_file_are_asked_about(folder: Path):
    """1 × 1 × 2 and 1 × 1 × 3: each is read by its number."""
    occ.addBox(0, 0, 0, 1, 1, 2)
    occ.addBox(4, 0, 0, 1, 1, 3)
    path = exported(folder / "two.igs")
    with pytest.raises(CadError, match="2 solids.*which is the fluid"):
        read_cad(path)
    volumes = sorted(read_cad(path, fluid=k).volume() for k in (1, 2))
    assert volumes == pytest.approx([2, 3], rel=1e-9)


def test_a_doubled_face_of_an_iges_file_is_left_out_and_said(folder: Path):
    """2 × 1 × 1 and its end x = 2 once more: V = 2, A = 10."""
    occ.addBox(0, 0, 0, 2, 1, 1)
    points = [occ.addPoint(2, y, z) for y, z in ((0, 0), (1, 0), (1, 1), (0, 1))]
    lines = [occ.addLine(points[k - 1], points[k]) for k in range(4)]
    occ.addPlaneSurface([occ.addCurveLoop(lines)])
    with pytest.warns(match="1 face was there twice"):
        boundary = read_cad(exported(folder / "doubled.igs"))
    assert boundary.volume() == pytest.approx(2, rel=1e-9)
    assert boundary.area() == pytest.approx(10, rel=1e-9)


def test_locations_in_locations_are_multiplied_in_the_kernels_order():
    """An inner turn by 90° about z with a shift by 5 along z, in an outer turn by 90° about x with
    a shift by 10 along x: (x, y, z) goes to (-y, x, z + 5), and on to (10 - y, -z - 5, x)."""
    inner, outer = "0 -1 0 0  1 0 0 0  0 0 1 5", "1 0 0 10  0 0 -1 0  0 1 0 0"
    words = f"Locations 3  1 {inner}  1 {outer}  2 1 1 2 1 0".split()
    composed = _read_locations(Tokens(words))[3]
    assert np.allclose(composed @ [3, 1, 2, 1], [9, -7, 3, 1])


def test_an_interval_that_begins_before_the_first_knot():
    """A line from (0, 0) to (2, 0) over [1, 3]: from 1 - 4e-9 to 2 it runs to (1, 0)."""
    record = SplineRecord((1,), (np.array([1.0, 1, 3, 3]),), np.array([[0.0, 0], [2, 0]]),
                          np.ones(2), (False,))  # fmt: skip
    points = spline_nurbs(record, ((1 - 4e-9, 2.0),)).points
    assert np.allclose(points, [[0, 0], [1, 0]], atol=1e-8)
    with pytest.raises(CadError, match="outside the curve"):
        spline_nurbs(record, ((4.0, 5.0),))


def test_a_tube_through_itself_is_refused_with_the_place(folder: Path):
    """Radius 0.25 along a spline that comes back across its first part, near z = 0."""
    path = [(0, 0, 0), (5, 0, 0), (7, 2, 0), (5, 4, 0), (2.5, 2, 0), (5, -2, 0)]
    spine = occ.addWire([occ.addBSpline([occ.addPoint(*point) for point in path])])
    disc = [(2, occ.addDisk(0, 0, 0, 0.25, 0.25, zAxis=[1, 0, 0]))]
    occ.addPipe(disc, spine, "Frenet")
    occ.remove(disc)
    with pytest.raises(CadError, match=r"face \d crosses itself at \["):
        read_cad(exported(folder / "tube.step"))


def test_walls_that_cross_are_refused_with_the_place(folder: Path):
    """A quadrilateral whose sides (0, 0)-(3, 2) and (3, 0)-(0, 1) cross where 2 x / 3 = 1 - x / 3,
    at (1, 2/3)."""
    points = [occ.addPoint(x, y, 0) for x, y in ((0, 0), (3, 2), (3, 0), (0, 1))]
    lines = [occ.addLine(points[k], points[(k + 1) % 4]) for k in range(4)]
    occ.extrude([(2, occ.addPlaneSurface([occ.addCurveLoop(lines)]))], 0, 0, 1)
    with pytest.raises(CadError, match=r"faces \d and \d cross at \[1, 0.6667, "):
        read_cad(exported(folder / "bow.step"))


def test_the_kernel_is_asked_where_faces_are(folder: Path):
    """No word on a cylinder; faces moved by a tenth, and one half as large again, are noticed."""
    occ.addCylinder(0, 0, 0, 0, 0, 2, 1)
    path = exported(folder / "rod.step")
    model, boundary = open_model(path, 60.0), read_cad(path)
    assert disagreements(model, boundary) == []
    moved = [
        replace(p, surface=replace(p.surface, points=p.surface.points + [0.4, 0, 0]))
        for p in boundary.patches
    ]
    (line,) = disagreements(model, replace(boundary, patches=tuple(moved)))
    assert "3 faces are not where" in line
    larger = [replace(p, surface=replace(p.surface, points=1.02 * p.surface.points))
              for p in boundary.patches]  # fmt: skip
    assert any("1.061 times" in x for x in disagreements(model, replace(
        boundary, patches=tuple(larger))))  # fmt: skip


def test_ports_of_different_height(folder: Path):
    """A bore of 0.4 × 0.4 × 6 (V = 0.96) with two ports of 0.4 × 0.4 that rise from its top at
    z = 1.4 to 3.5 and 4.25, through stubs of 1 × 1 on a block of height 3; plane mouths at the
    stubs' ends. V = 0.96 + 0.16 (2.1 + 2.85) = 1.752."""
    heights = {1: 3.5, 6.6: 4.25}
    block = [(3, occ.addBox(0, 0, 0, 8, 4, 3))]
    stubs = [(3, occ.addBox(x - 0.3, 1.5, 2, 1, 1, z - 2)) for x, z in heights.items()]
    body = occ.fuse(block, stubs)[0]
    bore = [(3, occ.addBox(1, 1.8, 1, 6, 0.4, 0.4))]
    ports = [(3, occ.addBox(x, 1.8, 1.2, 0.4, 0.4, z - 1.2)) for x, z in heights.items()]
    occ.cut(body, occ.fuse(bore, ports)[0])
    boundary = read_cad(exported(folder / "chip.step"), fluid="void")
    assert boundary.volume() == pytest.approx(1.752, rel=1e-9)
    places = [boundary.patches[boundary.select(f"port_{k}")[0]].middle().position[:, 0]
              for k in (1, 2)]  # fmt: skip
    assert np.allclose(places, [[1.2, 2, 3.5], [6.8, 2, 4.25]])
