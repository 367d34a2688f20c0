"""write_patches: what is read back is what was written, net for net; the kernel finds it valid."""

import re
from collections.abc import Iterator
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import gmsh
import numpy as np
import pytest

from cadbem.boundary import Boundary, Patch
from cadbem.cad import read_cad, write_patches
from cadbem.cad.body.shells import find_shells
from cadbem.cad.kernel.brep import read_brep
from cadbem.errors import CadError
from cadbem.post import bezier_grid
from cadbem.spline.nurbs import Nurbs
from cadbem.spline.outlines import circle
from cadbem.spline.shapes import box, sphere, sphere_octants

GEOMETRIES = Path(__file__).parents[1] / "geometries"
SUFFIXES = (".step", ".igs")
DRAWINGS = sorted(path.stem for path in GEOMETRIES.glob("*.step"))
occ = gmsh.model.occ


@pytest.fixture
def kernel() -> Iterator[None]:
    gmsh.initialize(interruptible=False, readConfigFiles=False)
    gmsh.option.setNumber("General.Terminal", 0)
    yield
    gmsh.finalize()


def named(surfaces: tuple[Nurbs, ...] | list[Nurbs], unit: str = "mm") -> Boundary:
    """One name a patch, so that a mix-up shows."""
    return Boundary(tuple(Patch(s, f"f {k}", k + 1) for k, s in enumerate(surfaces)), "", unit)


def assert_same(found: Boundary, written: Boundary) -> None:
    """The same patches, in any order: nets to 1e-12 of the size, knots, weights, names."""
    size = float(np.ptp(written.bounds(), axis=0).max())
    left = list(found.patches)
    assert found.unit == written.unit and len(left) == len(written.patches)
    for patch in written.patches:
        own = patch.surface
        alike = [p for p in left if p.surface.points.shape == own.points.shape]
        match = min(alike, key=lambda p: np.abs(p.surface.points - own.points).max())
        left.remove(match)
        other = match.surface
        np.testing.assert_allclose(other.points, own.points, rtol=0, atol=1e-12 * size)
        ratio = other.weights / own.weights
        np.testing.assert_allclose(ratio, ratio.flat[0], rtol=1e-12)
        assert (other.degrees, match.name) == (own.degrees, patch.name)
        assert all(np.array_equal(a, b) for a, b in zip(other.knots, own.knots, strict=True))


def returned(boundary: Boundary, path: Path, fluid: str = "solid") -> Boundary:
    return read_cad(write_patches(path, boundary), fluid=fluid)


@pytest.mark.parametrize("suffix", SUFFIXES)
@pytest.mark.parametrize(
    "drawing",
    [name if name in ("constriction", "round_pipe") else pytest.param(name, marks=pytest.mark.long)
     for name in DRAWINGS],
)  # fmt: skip
def test_drawings(tmp_path: Path, drawing: str, suffix: str) -> None:
    """As read; and with degree 3, more knots, and edges whose knots differ on both sides."""
    boundary = read_cad(GEOMETRIES / f"{drawing}.step")
    assert_same(returned(boundary, tmp_path / f"a{suffix}"), boundary)
    size = float(np.ptp(boundary.bounds(), axis=0).max())
    richer = boundary.elevated(3).refined(size=(size / 7, size / 9, size / 5)).graded(1)
    assert_same(returned(richer, tmp_path / f"b{suffix}"), richer)


def a_sphere() -> None:
    occ.addSphere(1, 2, 3, 0.7)


def a_cylinder() -> None:
    occ.addCylinder(1, 2, 3, 0.3, -0.4, 1.2, 0.7)


def a_torus() -> None:
    occ.addTorus(0, 1, 0, 3, 1)


@pytest.mark.parametrize(
    ("author", "suffix"),
    [(a_cylinder, ".step"), (a_cylinder, ".igs"), (a_torus, ".step"), (a_torus, ".igs"),
     (a_sphere, ".step")],
)  # fmt: skip
def test_round_solids(tmp_path: Path, kernel: None, author, suffix: str) -> None:
    """A sphere's octants have poles, edges that are points, which STEP loops leave out."""
    author()
    occ.synchronize()
    gmsh.write(str(tmp_path / "drawn.step"))
    boundary = read_cad(tmp_path / "drawn.step")
    boundary = replace(boundary, patches=named([p.surface for p in boundary.patches]).patches)
    assert_same(returned(boundary, tmp_path / f"a{suffix}"), boundary)


@pytest.mark.parametrize("suffix", SUFFIXES)
@pytest.mark.parametrize(("unit", "radius"), [("um", 100.0), ("m", 1e-3), ("inch", 0.01)])
def test_units(tmp_path: Path, suffix: str, unit: str, radius: float) -> None:
    ball = named(sphere(radius, (radius / 3, 0, 0), inwards=True), unit)
    assert_same(returned(ball, tmp_path / f"ball{suffix}"), ball)
    bare = named(sphere(1.0, inwards=True), "")
    assert_same(returned(bare, tmp_path / f"bare{suffix}"), replace(bare, unit="mm"))


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_a_corner_within_a_neighbours_edge(tmp_path: Path, suffix: str) -> None:
    """A box with one side in two halves: three more edges than the twelve of a box, each of
    which two patches share, once in each direction."""
    *sides, last = box((0, 0, 0), (1, 2, 3))
    (u0, u1), v = last.domain
    halves = [last.restricted(ends, v) for ends in pairwise((u0, 0.5 * (u0 + u1), u1))]
    boundary = named([*sides, *halves])
    shells = find_shells(boundary)
    assert len(shells.corners) == 10 and len(shells.edges) == 15
    assert shells.is_closed(range(7))
    assert_same(returned(boundary, tmp_path / f"box{suffix}"), boundary)


def test_a_cavity_and_a_body(tmp_path: Path) -> None:
    """Fluid between a box and a ball, and a ball on its own: its space is what a file holds."""
    shell = (*sphere_octants(2.0, inwards=True), *sphere(1.0))
    assert_same(returned(named(shell), tmp_path / "shell.step", "material"), named(shell))
    ball = returned(named(sphere(1.0)), tmp_path / "ball.step")
    assert ball.volume() == pytest.approx(4 * np.pi / 3, rel=1e-12)


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_what_does_not_close(tmp_path: Path, kernel: None, suffix: str) -> None:
    """Two sides of a box and half a sphere with poles, through the kernel's own record."""
    boundary = named([*box((0, 0, 0), (1, 1 / 3, 2))[::3], *sphere_octants(5.0)[::2]]).elevated(3)
    path = write_patches(tmp_path / f"open{suffix}", boundary)
    with pytest.raises(CadError, match="leave openings"):
        read_cad(path)
    occ.importShapes(str(path), highestDimOnly=False)
    occ.synchronize()
    gmsh.write(str(tmp_path / "open.brep"))
    faces = read_brep((tmp_path / "open.brep").read_text())
    assert len(faces) == 6
    for face, patch in zip(faces, boundary.patches, strict=True):
        spline = face.surface.spline
        assert spline is not None
        points = spline.points @ face.matrix[:3, :3].T + face.matrix[:3, 3]
        np.testing.assert_allclose(points, patch.surface.points, rtol=0, atol=1e-12 * 5)
        np.testing.assert_allclose(spline.weights, patch.surface.weights, rtol=1e-13)
        assert all(map(np.array_equal, spline.knots, patch.surface.knots))


def test_the_kernel_finds_one_valid_solid(tmp_path: Path, kernel: None) -> None:
    """A box's volume 6 and area 22 by gmsh's own integrals, edges shared by two faces each."""
    write_patches(tmp_path / "box.step", named(box((0, 0, 0), (1, 2, 3))).elevated(2).refined(3))
    gmsh.open(str(tmp_path / "box.step"))
    [solid] = gmsh.model.getEntities(3)
    faces = gmsh.model.getEntities(2)
    assert occ.getMass(*solid) == pytest.approx(6, rel=1e-12)
    assert sum(occ.getMass(*face) for face in faces) == pytest.approx(22, rel=1e-12)
    assert (len(faces), len(gmsh.model.getEntities(1)), len(gmsh.model.getEntities(0))) == (
        6,
        12,
        8,
    )


def test_digits_and_names_in_the_text(tmp_path: Path) -> None:
    """17 digits; apostrophes doubled; characters beyond ASCII as code points; same bytes."""
    boundary = named(box((0, 0, 0), (1 / 3, 1e-5, 2e-4 / 3)))
    patches = [
        replace(p, name=n) for p, n in zip(boundary.patches, ["it's", "Einlaß"], strict=False)
    ]
    boundary = replace(boundary, patches=(*patches, *boundary.patches[2:]))
    path = write_patches(tmp_path / "box.step", boundary)
    text = path.read_text()
    assert "(0.3333333333333333,1.E-05,6.666666666666667E-05)" in text
    assert "ADVANCED_FACE('it''s'" in text and r"ADVANCED_FACE('Einla\X2\00DF\X0\'" in text
    write_patches(path, boundary, overwrite=True)
    assert path.read_text() == text
    lines = write_patches(tmp_path / "box.igs", named(box())).read_text().splitlines()
    assert {len(line) for line in lines} == {80}


@pytest.mark.parametrize(
    ("file", "boundary", "message"),
    [
        ("box.brep", named(box()), "box.brep: unknown ending '.brep'"),
        ("old.step", named(box()), "the file is there already"),
        ("box.step", named(box(), "ell"), "the unit 'ell' cannot be written; use one of m, mm"),
        ("box.igs", named(box(), "nm"), "the unit 'nm' is none of IGES's"),
        ("disk.step", Boundary(tuple(Patch(c) for c in circle())), "plane curves"),
        ("box.igs", named(box()).named(left_inlet=1), "'left_inlet' does not fit IGES's labels"),
        ("box.igs", named(box()).named(Öffnung=1), "'Öffnung' does not fit"),
    ],
)
def test_what_cannot_be_written(
    tmp_path: Path, file: str, boundary: Boundary, message: str
) -> None:
    (tmp_path / "old.step").write_text("mine")
    with pytest.raises(CadError, match=re.escape(message)):
        write_patches(tmp_path / file, boundary)
    assert (tmp_path / "old.step").read_text() == "mine"
    assert list(tmp_path.iterdir()) == [tmp_path / "old.step"]


@pytest.mark.parametrize("shape", [sphere, sphere_octants])
def test_vtk_cells_of_a_ball(shape) -> None:
    """All points that VTK draws on the Bézier cells are 2 from the centre, in single precision."""
    boundary = named(shape(2.0, (1, 0, 0))).refined(2)
    grid = bezier_grid(boundary)
    points = grid.extract_surface(algorithm="dataset_surface", nonlinear_subdivision=4).points
    assert len(points) > 5000
    assert np.linalg.norm(points - [1, 0, 0], axis=1) == pytest.approx(2, abs=4e-7)
