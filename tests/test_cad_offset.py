"""Faces on offset surfaces, basis + d n: as the kernel writes them, and put into its record.

`n` is the unit vector along ∂u × ∂v of the basis.
"""

from math import cos, pi, sin, sqrt
from pathlib import Path

import gmsh
import numpy as np
import pytest
from scipy.integrate import quad

from cadbem.boundary import Boundary, Patch
from cadbem.cad import inspect_cad
from cadbem.cad.kernel.brep import BrepFace, read_brep
from cadbem.cad.layout.face_patches import face_patches

occ = gmsh.model.occ


def recorded(record: Path, line: str = "", basis: str = "", distance: float = 0) -> list[BrepFace]:
    """The model's faces; a surface's line becomes the offset of another."""
    occ.synchronize()
    gmsh.write(str(record))
    head, title, surfaces = record.read_text().partition("\nSurfaces ")
    assert line in surfaces
    changed = surfaces.replace(line, f"\n11 {distance}{basis}", 1) if line else surfaces
    return read_brep(head + title + changed)


def offset_face(faces: list[BrepFace]) -> BrepFace:
    (face,) = [face for face in faces if face.surface.kind == "offset"]
    return face


def points_of(face: BrepFace, tolerance: float) -> np.ndarray:
    """Points (3, n) of the face's patches, corners and edges among them."""
    patches = face_patches(face, tolerance).surfaces
    grids = [np.meshgrid(*[np.linspace(*ends, 9) for ends in p.domain]) for p in patches]
    found = [p.evaluate(*g).reshape(3, -1) for p, g in zip(patches, grids, strict=True)]
    return np.concatenate(found, axis=1)


def drilled_quarter() -> None:
    """A quarter of a cylinder of radius 1.5 and height 3, with a hole of radius 0.8 through the
    middle of its wall."""
    hole = occ.addCylinder(0, 0, 1.5, 4, 4, 0, 0.8)
    occ.cut([(3, occ.addCylinder(0, 0, 0, 0, 0, 3, 1.5, angle=pi / 2))], [(3, hole)])


CYLINDER = "\n2 0 0 0 0 0 1 1 0 -0 -0 1 0 {}\n"


@pytest.mark.parametrize("tolerance", [1e-4, 1e-7])
@pytest.mark.parametrize(("radius", "distance"), [(1.0, 0.5), (2.0, -0.5)])
def test_the_offset_of_a_cylinder_is_one(
    record: Path, radius: float, distance: float, tolerance: float
):
    """Radius 1.5 as 1 + 0.5 and as 2 - 0.5, with a hole: points are 1.5 from the axis within the
    tolerance times the height, and not in the hole, |z - 1.5| and |x - y| / sqrt 2 its axes."""
    drilled_quarter()
    basis = CYLINDER.format(f"{radius:g}")
    face = offset_face(recorded(record, CYLINDER.format("1.5"), basis, distance))
    x, y, z = points_of(face, tolerance)
    assert np.hypot(x, y) == pytest.approx(1.5, abs=3 * tolerance)
    assert np.hypot((x - y) / sqrt(2), z - 1.5).min() > 0.8 - 3 * tolerance - 1e-6


def test_an_offset_has_the_area_of_what_it_is(record: Path):
    """The drilled wall: 1.5 π / 2 × 3 less the hole's shadow. At an angle t from the
    middle of the wall the hole is 2 sqrt(0.64 - (1.5 sin t)²) high; 1.5 sin t = 0.8 sin w."""
    drilled_quarter()
    face = offset_face(recorded(record, CYLINDER.format("1.5"), CYLINDER.format("1"), 0.5))
    patches = Boundary(tuple(map(Patch, face_patches(face, 1e-7).surfaces)))
    hole = 4 * quad(lambda w: (0.8 * cos(w)) ** 2 / sqrt(1 - (0.8 / 1.5 * sin(w)) ** 2), 0, pi / 2,
                    epsabs=1e-14)[0]  # fmt: skip
    assert patches.area() == pytest.approx(1.5 * pi / 2 * 3 - hole, rel=1e-6)


def test_an_offset_that_fills_a_rectangle(record: Path):
    """A quarter pipe's wall of radius 1.5 and height 3 as the offset of one of radius 1."""
    occ.addCylinder(0, 0, 0, 0, 0, 3, 1.5, angle=pi / 2)
    face = offset_face(recorded(record, CYLINDER.format("1.5"), CYLINDER.format("1"), 0.5))
    x, y, _ = points_of(face, 1e-7)
    assert np.hypot(x, y) == pytest.approx(1.5, abs=3e-7)
    patches = Boundary(tuple(map(Patch, face_patches(face, 1e-7).surfaces)))
    assert patches.area() == pytest.approx(1.5 * pi / 2 * 3, rel=1e-6)


def thickened(radius: float) -> int:
    """A box under a wavy wall, its faces made 0.2 thick but for the bottom; drilled through the
    wavy wall if there is a radius. Returns the wavy face as it was before."""
    points = [occ.addPoint(*p, 0) for p in ((0, 0), (1, 0.5), (2, -0.5), (3, 0.2))]
    far = [occ.addPoint(3, 3, 0), occ.addPoint(0, 3, 0)]
    wavy = occ.addBSpline(points)
    sides = [occ.addLine(a, b) for a, b in ((points[-1], far[0]), far, (far[1], points[0]))]
    made = occ.extrude([(2, occ.addPlaneSurface([occ.addCurveLoop([wavy, *sides])]))], 0, 0, 2)
    walls = [tag for dim, tag in made if dim == 2]
    (solid,) = occ.addThickSolid(1, walls[:1], 0.2)
    if radius:
        occ.cut([solid], [(3, occ.addCylinder(1.5, -2, 1, 0, 4, 0, radius))])
    return walls[1]


@pytest.mark.parametrize("radius", [0.0, 0.7])
def test_the_kernels_offset_of_a_spline(record: Path, radius: float):
    """Every point of the patches is 0.2 from the wavy wall, along its normal there."""
    basis = thickened(radius)
    face = offset_face(recorded(record))
    points = points_of(face, 1e-6).T
    there, parameters = gmsh.model.getClosestPoint(2, basis, points.ravel())
    steps = points - np.reshape(there, (-1, 3))
    normals = np.reshape(gmsh.model.getNormal(basis, parameters), (-1, 3))
    assert np.linalg.norm(steps, axis=1) == pytest.approx(0.2, abs=3e-6)
    assert np.abs((steps * normals).sum(axis=1)) == pytest.approx(0.2, abs=3e-6)


def test_an_offset_surface_from_step(record: Path):
    """The drilled solid as a file: its offset face is one, with an area that agrees with the
    integral over the kernel's surface."""
    thickened(0.7)
    path = record.with_suffix(".step")
    occ.synchronize()
    gmsh.write(str(path))
    assert "OFFSET_SURFACE" in path.read_text()
    (wall,) = [face for face in inspect_cad(path, fluid=2).faces if face.kind == "offset"]
    assert wall.problem == ""
    assert wall.deviation < 1e-6 * 3.5
    assert wall.area == pytest.approx(wall.exact_area, rel=1e-6)
