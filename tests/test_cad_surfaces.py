"""Patches made from the kernel's records against the kernel's own evaluation, and closed forms.

Solids are authored with gmsh's OpenCASCADE and recorded as `.brep` text; nothing is read back
through STEP, so only rounding remains.
"""

from itertools import pairwise
from math import cos, pi, sin, sqrt
from pathlib import Path

import gmsh
import numpy as np
import pytest

from cadbem.boundary import Boundary, Patch
from cadbem.cad.kernel.brep import read_brep
from cadbem.cad.layout.coons import coons_patch, segment
from cadbem.cad.layout.face_patches import face_patches
from cadbem.errors import CadError
from cadbem.spline.nurbs import Nurbs

occ = gmsh.model.occ


def patches_of(record: Path) -> Boundary:
    occ.synchronize()
    gmsh.write(str(record))
    faces = read_brep(record.read_text())
    return Boundary(tuple(Patch(s, "", f.number) for f in faces for s in face_patches(f).surfaces))


def box():
    occ.addBox(1, 2, 3, 4, 5, 6)


def cylinder():
    occ.addCylinder(1, 2, 3, 0.3, -0.4, 1.2, 0.7)


def cone():
    occ.addCone(0, 0, 1, 0, 3, 0, 2.0, 0.5)


def sphere():
    occ.addSphere(1, -1, 2, 1.5)


def torus():
    occ.addTorus(0, 1, 0, 3, 1, zAxis=[0, 1, 1])


def wavy_line(*lines: tuple[float, float, float]) -> int:
    return occ.addBSpline([occ.addPoint(*point) for point in lines])


def revolved_spline():
    """A solid of revolution: wavy outside, ends flat."""
    rim = wavy_line((1, 0, 0), (1.4, 0, 0.7), (0.8, 0, 1.4), (1.1, 0, 2))
    occ.revolve([(1, rim)], 0, 0, 0, 0, 0, 1, 2.5)


def extruded_spline():
    wall = wavy_line((0, 0, 0), (1, 0.5, 0), (2, -0.5, 0), (3, 0, 0), (4, 1, 0))
    occ.extrude([(1, wall)], 0.2, 0.1, 2)


def closed_periodic_spline():
    """A periodic B-spline curve, extruded: its surface has no end in u."""
    corners = [occ.addPoint(2 * cos(t), sin(t), 0.1 * t) for t in np.arange(6) * pi / 3]
    occ.extrude([(1, occ.addBSpline([*corners, corners[0]]))], 0, 0, 1)


def bspline_face():
    heights = np.random.default_rng(5).random((4, 4))
    points = [occ.addPoint(i, j, heights[i, j]) for j in range(4) for i in range(4)]
    weights = (1 + heights.ravel()).tolist()
    occ.addBSplineSurface(points, 4, degreeU=3, degreeV=2, weights=weights)


def bezier_face():
    points = [occ.addPoint(i, j, i * j * (2 - i)) for j in range(3) for i in range(4)]
    occ.addBezierSurface(points, 4)


def sheared_box():
    occ.affineTransform(
        [(3, occ.addBox(0, 0, 0, 1, 1, 1))], [1, 0.2, 0, 3, 0, 1, 0.4, 0, 0.1, 0, 2, 1]
    )


@pytest.mark.parametrize(
    "author",
    [box, cylinder, cone, sphere, torus, revolved_spline, extruded_spline, closed_periodic_spline,
     bspline_face, bezier_face, sheared_box],
)  # fmt: skip
def test_patches_lie_on_the_kernels_surfaces(record: Path, author):
    """Points of every patch are where the kernel puts the same parameters."""
    author()
    boundary = patches_of(record)
    low, high = boundary.bounds()
    size = np.linalg.norm(high - low)
    for patch in boundary.patches:
        grid = np.meshgrid(*[np.linspace(a, b, 6) for a, b in patch.surface.domain])
        points = patch.surface.evaluate(*grid).reshape(3, -1).T
        gaps = [kernel_distance(tag, points) for _, tag in gmsh.model.getEntities(2)]
        assert min(gap.max() for gap in gaps) < 1e-12 * size


def kernel_distance(tag: int, points: np.ndarray) -> np.ndarray:
    """Distance of points from the kernel's surface."""
    there = np.reshape(gmsh.model.getClosestPoint(2, tag, points.ravel())[0], (-1, 3))
    return np.linalg.norm(there - points, axis=1)


SLANT = sqrt(3**2 + 1.5**2)


@pytest.mark.parametrize(
    ("author", "area", "volume"),
    [
        (box, 148, 120),
        (cylinder, 2 * pi * 0.7 * (0.7 + 1.3), pi * 0.49 * 1.3),
        (cone, pi * (2.5 * SLANT + 4.25), pi * (4 + 1 + 0.25)),
        (sphere, 9 * pi, 4.5 * pi),
        (torus, 12 * pi**2, 6 * pi**2),
    ],
)
def test_closed_forms(record: Path, author, area: float, volume: float):
    """Cone: π (R + r) s with slant s, and π h (R² + R r + r²) / 3; torus 4 π² R r, 2 π² R r²."""
    author()
    boundary = patches_of(record)
    assert boundary.area() == pytest.approx(area, rel=1e-12)
    assert boundary.volume() == pytest.approx(volume, rel=1e-12)


def test_closed_surfaces_are_cut_at_right_angles(record: Path):
    """A torus has no edge: 4 × 4 pieces; a cylinder's wall has 4 and each end 5."""
    torus()
    assert len(patches_of(record).patches) == 16
    gmsh.clear()
    cylinder()
    assert len(patches_of(record).patches) == 14


def plane_face(*corners: tuple[float, float]) -> None:
    points = [occ.addPoint(x, y, 0) for x, y in corners]
    lines = [occ.addLine(a, b) for a, b in pairwise([*points, points[0]])]
    occ.addPlaneSurface([occ.addCurveLoop(lines)])


def ring_sector() -> None:
    """Radii 1 and 2, 50° wide, turned so that no side runs along an axis."""
    centre = occ.addPoint(0, 0, 0)
    a, b = 0.3, 0.3 + 5 * pi / 18
    corners = [occ.addPoint(r * cos(t), r * sin(t), 0) for r, t in [(1, a), (2, a), (2, b), (1, b)]]
    sides = [
        occ.addLine(corners[0], corners[1]),
        occ.addCircleArc(corners[1], centre, corners[2]),
        occ.addLine(corners[2], corners[3]),
        occ.addCircleArc(corners[3], centre, corners[0]),
    ]
    occ.addPlaneSurface([occ.addCurveLoop(sides)])


def lens() -> None:
    occ.addDisk(0, 0, 0, 1, 1)
    occ.addDisk(0.8, 0, 0, 1, 1)
    occ.intersect([(2, 1)], [(2, 2)])


def stadium() -> None:
    """4 long between half disks of radius 1/2; the border has no corner."""
    ends = [occ.addDisk(x, 0.5, 0, 0.5, 0.5) for x in (0, 4)]
    occ.fuse([(2, occ.addRectangle(0, 0, 0, 4, 1))], [(2, end) for end in ends])


def conic_section(tilt: float) -> None:
    """The cone z = r < 2 cut by the plane x = 1 (a hyperbola: 2 - sqrt(1 + y²) integrated), or by
    z = x + 1 (a parabola: y² < 2 x + 1 times sqrt 2)."""
    cone = occ.addCone(0, 0, 0, 0, 0, 2, 0, 2)
    plate = occ.addRectangle(-5, -5, 0, 10, 10)
    occ.rotate([(2, plate)], 0, 0, 0, 0, 1, 0, pi / 2 if tilt == 0 else tilt)
    occ.translate([(2, plate)], 1 if tilt == 0 else 0, 0, 0 if tilt == 0 else 1)
    occ.intersect([(3, cone)], [(2, plate)])
    occ.synchronize()
    occ.remove([e for e in occ.getEntities(3)], recursive=True)


def pillar() -> None:
    """A plate of 4 × 3 with an elliptic hole that is neither centred nor aligned."""
    hole = occ.addDisk(0, 0, 0, 0.7, 0.4)
    occ.rotate([(2, hole)], 0, 0, 0, 0, 0, 1, 0.6)
    occ.cut([(2, occ.addRectangle(-2, -1.2, 0, 4, 3))], [(2, hole)])


def washer() -> None:
    occ.cut([(2, occ.addDisk(0, 0, 0, 2, 2))], [(2, occ.addDisk(0.3, 0, 0, 0.5, 0.5))])


LENS = 2 * np.arccos(0.4) - 0.4 * sqrt(4 - 0.64)  # two unit circles, centres 0.8 apart


@pytest.mark.parametrize(
    ("author", "area", "count"),
    [
        (lambda: plane_face((0, 0), (4, 1), (3, 3), (-1, 2)), 9, 1),
        (lambda: plane_face((0, 0), (1, 0), (4, 0), (3, 3), (0, 2)), 9, 1),
        (lambda: plane_face((0, 0), (3, 1), (1, 2)), 2.5, 3),
        (ring_sector, 5 * pi / 18 * 1.5, 1),
        (lambda: occ.addDisk(1, 2, 3, 2, 1), 2 * pi, 5),
        (lens, LENS, 5),
        (stadium, 4 * 1 + pi / 4, None),
        (lambda: conic_section(0), 2 * sqrt(3) - np.arcsinh(sqrt(3)), 6),
        (lambda: conic_section(-pi / 4), 2 * sqrt(6), 6),
        (pillar, 12 - pi * 0.7 * 0.4, None),
        (washer, pi * (4 - 0.25), None),
    ],
)
def test_plane_faces_are_covered_exactly(record: Path, author, area: float, count: int | None):
    """Shoelace, sector and lens formulas; patches stay in the plane and keep smooth inside.
    Counts are upper bounds."""
    author()
    boundary = patches_of(record)
    assert count is None or len(boundary.patches) <= count
    assert boundary.area() == pytest.approx(area, rel=1e-12)
    points = np.concatenate([p.surface.points.reshape(-1, 3) for p in boundary.patches])
    normals = boundary.quadrature()[0].normal
    assert np.ptp(points @ normals[:, 0]) < 2e-15 * np.abs(points).max()
    assert np.allclose(normals, normals[:, :1])


def test_kinks_are_patch_borders(record: Path):
    """A cubic with a triple knot has a corner there: the extruded face becomes two patches."""
    points = [occ.addPoint(x, abs(x), 0) for x in (-3, -2, -1, 0, 1, 2, 3)]
    line = occ.addBSpline(points, degree=3, knots=[0, 1, 2], multiplicities=[4, 3, 4])
    occ.extrude([(1, line)], 0, 0, 1)
    boundary = patches_of(record)
    assert len(boundary.patches) == 2
    assert boundary.area() == pytest.approx(6 * sqrt(2), rel=1e-13)


def test_edges_of_a_wire_may_come_in_any_order(record: Path):
    """The record with two edges of the loop exchanged is the same face."""
    plane_face((0, 0), (4, 1), (3, 3), (-1, 2))
    before = patches_of(record)
    text = record.read_text()
    head, wire, rest = text.partition("Wi\n")
    lines = rest.split("\n")
    index = next(i for i, line in enumerate(lines) if line.count(" 0 ") >= 4)
    pairs = lines[index].removesuffix(" *").split(" 0")[:4]
    lines[index] = " 0".join([pairs[0], pairs[2], pairs[1], pairs[3]]) + " 0 *"
    record.write_text(head + wire + "\n".join(lines))
    face = read_brep(record.read_text())[0]
    after = Boundary(tuple(Patch(s) for s in face_patches(face).surfaces))
    assert after.area() == pytest.approx(before.area(), rel=1e-15)


def test_an_edge_with_unequal_end_weights_fits(record: Path):
    """A quarter circle with weights 1, 1, 2 (NURBS Book, example 7.2) over its chord and a notch:
    the sides (1, 0) ... (0, 1), (0, 1/2), (1/2, 0) enclose π/4 - 1/8."""
    knots = (np.array([0.0, 0, 0, 1, 1, 1]),)
    corners = np.array([[1.0, 0, 0], [1, 1, 0], [0, 1, 0]])
    rim = Nurbs((2,), knots, corners, np.array([1.0, 1.0, 2.0]))
    stops = np.array([[0.0, 1, 0], [0, 0.5, 0], [0.5, 0, 0], [1, 0, 0]])
    patch = coons_patch([rim, *[segment(a, b) for a, b in pairwise(stops)]])
    assert Boundary((Patch(patch),)).area() == pytest.approx(pi / 4 - 1 / 8, rel=1e-12)
    along = patch.evaluate(np.linspace(0, 1, 9), np.zeros(9))
    assert np.allclose(np.hypot(*along[:2]), 1, rtol=1e-15)


def test_an_offset_without_parameter_curves_is_refused_in_words(record: Path):
    """A plane recorded as the offset of a plane: its edges have no place in its parameters."""
    plane_face((0, 0), (4, 0), (4, 3), (0, 3))
    patches_of(record)
    head, surfaces, rest = record.read_text().partition("Surfaces 1\n")
    face = read_brep(f"{head}{surfaces}11 0.5\n{rest}")[0]
    with pytest.raises(CadError, match="edges do not close in its surface's parameters; export"):
        face_patches(face)


def test_a_border_that_crosses_itself_is_refused_in_words(record: Path):
    """A bow tie."""
    plane_face((0, 0), (2, 2), (2, 0), (0, 1.5))
    with pytest.raises(CadError, match="split it into simpler faces"):
        patches_of(record)
