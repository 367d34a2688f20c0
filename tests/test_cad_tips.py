"""Faces whose edges touch at corners of 0°: ports as wide as channels, bell mouths, lunes."""

from math import acos, pi, sqrt
from pathlib import Path

import gmsh
import numpy as np
import pytest
from drawn import exported

from cadbem.cad import read_cad
from cadbem.problems.developed import rim
from cadbem.spline.nurbs import Nurbs

occ = gmsh.model.occ


def test_a_port_as_wide_as_its_channel(folder: Path):
    """A channel of 5 × 0.8 × 0.3 with a round port of radius 0.4 and height 1 on its top, which
    touches both of its edges: V = 1.2 + 0.16 π; the port adds its wall, 0.8 π, to the area."""
    channel = [(3, occ.addBox(0, -0.4, 0, 5, 0.8, 0.3))]
    occ.fuse(channel, [(3, occ.addCylinder(2, 0, 0.3, 0, 0, 1, 0.4))])
    boundary = read_cad(exported(folder / "port.step"))
    assert boundary.volume() == pytest.approx(1.2 + 0.16 * pi, rel=1e-8)
    assert boundary.area() == pytest.approx(2 * (4 + 1.5 + 0.24) + 0.8 * pi, rel=1e-8)


@pytest.mark.parametrize("suffix", [".step", ".igs"])
def test_a_half_bell_mouth(folder: Path, suffix: str):
    """A channel of 2 × 1 × 0.5 that opens by a quarter round of r = 2 on one side: it adds the
    corner r² (1 - π/4) and the strip r × 1 to the plan, whose perimeter is 2 + 1 + 2 + 2 + 3 + π.
    """
    p = [occ.addPoint(x, y, 0) for x, y in ((-2, 0), (2, 0), (2, 3), (0, 1), (-2, 1), (0, 3))]
    lines = [
        occ.addLine(p[0], p[1]), occ.addLine(p[1], p[2]), occ.addCircleArc(p[2], p[5], p[3]),
        occ.addLine(p[3], p[4]), occ.addLine(p[4], p[0]),
    ]  # fmt: skip
    occ.extrude([(2, occ.addPlaneSurface([occ.addCurveLoop(lines)]))], 0, 0, 0.5)
    plan = 4 + 4 * (1 - pi / 4)
    boundary = read_cad(exported(folder / f"bell{suffix}"))
    assert boundary.volume() == pytest.approx(0.5 * plan, rel=1e-8)
    assert boundary.area() == pytest.approx(2 * plan + 0.5 * (4 + 3 + 2 + 1 + pi), rel=1e-8)


@pytest.mark.parametrize("step", [0.12, 2e-3])
def test_bores_out_of_line(folder: Path, step: float):
    """Two bores of r = 0.5 and length 1 that meet out of line by e: V = 2 π r². At the joint each
    has the disc less the lens 2 r² acos(e/2r) - (e/2) sqrt(4 r² - e²) open."""
    lower = [(3, occ.addCylinder(0, 0, 0, 0, 0, 1, 0.5))]
    occ.fuse(lower, [(3, occ.addCylinder(step, 0, 1, 0, 0, 1, 0.5))])
    lens = 0.5 * acos(step) - step / 2 * sqrt(1 - step**2)
    boundary = read_cad(exported(folder / "bores.step"))
    assert boundary.volume() == pytest.approx(0.5 * pi, rel=1e-6)
    assert boundary.area() == pytest.approx(2 * pi + 0.5 * pi + 2 * (pi / 4 - lens), rel=1e-6)


def test_a_wedge_with_many_edges_on_one_side(folder: Path):
    """A prism over a wedge of 7.1° whose long side has kinks of half a degree: V is the area of
    the polygon by the shoelace rule, times the height of 1."""
    below = [(2 * k, -0.01 * k * (4 - k)) for k in range(4)]
    points = [*below, (8, 0), (8, 1)]
    corners = [occ.addPoint(x, y, 0) for x, y in points]
    lines = [occ.addLine(corners[k - 1], corners[k]) for k in range(len(points))]
    occ.extrude([(2, occ.addPlaneSurface([occ.addCurveLoop(lines)]))], 0, 0, 1)
    pairs = zip(points, points[1:] + points[:1], strict=True)
    area = 0.5 * sum(a[0] * b[1] - a[1] * b[0] for a, b in pairs)
    boundary = read_cad(exported(folder / "wedge.step"))
    assert boundary.volume() == pytest.approx(area, rel=1e-9)


def test_a_triangle_on_a_curved_wall(folder: Path):
    """The wedge cut off a cylinder (r = 1, along z) by the plane z = h y / r over y > 0, h = 0.2:
    its wall has corners below 15°. V = 2 h r² / 3, and the wall has the area 2 h r. Its half
    x > 0 is read: V = h r² / 3, with a quarter disc below, one tilted above, the wall h r, and the
    triangle r h / 2 at x = 0."""
    half = occ.intersect(
        [(3, occ.addCylinder(0, 0, 0, 0, 0, 1, 1))], [(3, occ.addBox(0, 0, 0, 1, 1, 1))]
    )[0]
    low = [occ.addPoint(*p) for p in ((-1, -1, -0.2), (3, -1, -0.2), (3, 3, 0.6), (-1, 3, 0.6))]
    sides = [occ.addLine(low[k - 1], low[k]) for k in range(4)]
    slope = occ.addPlaneSurface([occ.addCurveLoop(sides)])
    top = occ.extrude([(2, slope)], 0, 0, 3)[1]
    occ.cut(half, [top])
    boundary = read_cad(exported(folder / "ungula.step"))
    assert boundary.volume() == pytest.approx(0.2 / 3, rel=1e-6)
    assert boundary.area() == pytest.approx(pi / 4 * (1 + sqrt(1.04)) + 0.2 + 0.1, rel=1e-6)


def test_a_pole_is_no_edge_of_an_opening():
    """A triangle as a patch with one side of length 0: its rim has the sides 3, 4 and 5."""
    corners = np.array([[[0.0, 0], [0, 0]], [[3, 0], [3, 4]]])
    knots = np.array([0.0, 0, 1, 1])
    edges = rim([Nurbs((1, 1), (knots, knots), corners, np.ones((2, 2)))])
    lengths = [np.linalg.norm(np.diff(edge.points, axis=0)) for edge in edges]
    assert sorted(lengths) == pytest.approx([3, 4, 5])


@pytest.mark.parametrize("radius", [0.396, 0.3996, 0.39999])
@pytest.mark.parametrize("turn", [0.0, 0.4, pi / 2])
def test_a_port_almost_as_wide_as_its_channel(folder: Path, radius: float, turn: float):
    """As above, with necks beside the port, wherever the seam of its circle is: V = 1.2 + π r²."""
    port = [(3, occ.addCylinder(2, 0, 0.3, 0, 0, 1, radius))]
    occ.rotate(port, 2, 0, 0, 0, 0, 1, turn)
    occ.fuse([(3, occ.addBox(0, -0.4, 0, 5, 0.8, 0.3))], port)
    boundary = read_cad(exported(folder / "port.step"))
    assert boundary.volume() == pytest.approx(1.2 + pi * radius**2, rel=1e-8)
    assert boundary.area() == pytest.approx(2 * (4 + 1.5 + 0.24) + 2 * pi * radius, rel=1e-8)


@pytest.mark.parametrize("suffix", [".step", ".igs"])
@pytest.mark.parametrize("angle", [0.0, 0.3, pi / 2, 2.0])
def test_a_tee_of_equal_pipes(folder: Path, angle: float, suffix: str):
    """Pipes of r = 1, the main one 5 long, the branch 2 from its axis, in any direction: of the
    branch, half of Steinmetz's solid 16 r³ / 3 is in the main one: V = 5 π + 2 π - 8/3. Both
    branches of the curve in which they meet take as much from both walls: A = 2 π (5 + 2) - 8 +
    3 π, where 16 r² is the area of the solid."""
    main = [(3, occ.addCylinder(-2.5, 0, 0, 5, 0, 0, 1))]
    occ.fuse(main, [(3, occ.addCylinder(0, 0, 0, 0, 2 * np.cos(angle), 2 * np.sin(angle), 1))])
    boundary = read_cad(exported(folder / f"tee{suffix}"))
    assert boundary.volume() == pytest.approx(7 * pi - 8 / 3, rel=1e-6)
    assert boundary.area() == pytest.approx(17 * pi - 8, rel=1e-6)


@pytest.mark.parametrize("c", [2e-2, 1e-3, 1e-5])
def test_short_edges_beside_long_ones(folder: Path, c: float):
    """A prism of height 1 over 4 × 2 with one corner bevelled by c, and over a triangle 3 × 1
    whose tip is cut at c of its height: areas by triangles."""
    for points, plan in (
        ([(0, 0), (4, 0), (4, 2), (c, 2), (0, 2 - c)], 8 - c**2 / 2),
        ([(0, 0), (3, 0), (3, 1 + c), (0, c)], 1.5 + 3 * c),
    ):
        gmsh.clear()
        corners = [occ.addPoint(x, y, 0) for x, y in points]
        lines = [occ.addLine(corners[k - 1], corners[k]) for k in range(len(corners))]
        occ.extrude([(2, occ.addPlaneSurface([occ.addCurveLoop(lines)]))], 0, 0, 1)
        boundary = read_cad(exported(folder / "prism.step"))
        assert boundary.volume() == pytest.approx(plan, rel=1e-9)
        assert len(boundary.patches) < 20
