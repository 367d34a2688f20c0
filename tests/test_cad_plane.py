"""read_outline: plane regions from sketches and from cuts, areas and lengths in closed form.

A region's area is `volume()` of its boundary, positive only if the fluid is to the right of all
curves; its perimeter is `area()`.
"""

import re
from collections import Counter
from collections.abc import Callable, Iterator
from math import pi, sqrt
from pathlib import Path

import gmsh
import numpy as np
import pytest

from cadbem.boundary import Boundary
from cadbem.cad import read_outline
from cadbem.errors import CadError, InputError
from cadbem.problems.conditions import Inflow, NoSlip, Pressure
from cadbem.problems.stokes import StokesProblem
from cadbem.quadrature import Quadrature

GEOMETRIES = Path(__file__).parents[1] / "geometries"
SUFFIXES = (".step", ".igs")
occ = gmsh.model.occ


@pytest.fixture
def drawn(tmp_path: Path) -> Iterator[Callable[..., Path]]:
    """Writes what a function draws with gmsh."""

    def draw(author: Callable[[], object], suffix: str = ".step") -> Path:
        author()
        occ.synchronize()
        path = tmp_path / f"{author.__name__}{suffix}"
        gmsh.write(str(path))
        return path

    gmsh.initialize(interruptible=False, readConfigFiles=False)
    gmsh.option.setNumber("General.Terminal", 0)
    yield draw
    gmsh.finalize()


def stadium(z: float = 0.0) -> list[int]:
    """Two straight sides, 3 long, and four quarters of circles of radius 1."""
    places = [(0, -1), (3, -1), (4, 0), (3, 1), (0, 1), (-1, 0)]
    points = [occ.addPoint(*place, z) for place in places]
    middles = [occ.addPoint(x, 0, z) for x in (0, 3)]
    lower, upper = occ.addLine(points[0], points[1]), occ.addLine(points[3], points[4])
    around = ((1, 1, 2), (2, 1, 3), (4, 0, 5), (5, 0, 0))
    arcs = [occ.addCircleArc(points[a], middles[c], points[b]) for a, c, b in around]
    occ.remove([(0, middle) for middle in middles])
    return [lower, *arcs[:2], upper, *arcs[2:]]


def stadium_with_a_hole() -> None:
    hole = occ.addCurveLoop([occ.addCircle(1, 0, 0, 0.5)])
    occ.addPlaneSurface([occ.addCurveLoop(stadium()), hole])


def wires() -> None:
    """No faces: a stadium, a hole, and an island in the hole."""
    stadium(2.0)
    occ.addCircle(1.5, 0, 2, 0.75)
    occ.addCircle(1.5, 0, 2, 0.25)


def two_squares() -> None:
    """Side by side: their common edge is inside."""
    occ.addRectangle(0, 0, 0, 1, 1)
    occ.addRectangle(1, 0, 0, 2, 1)


def upright() -> None:
    """A rectangle in a plane x = 3, with a Bézier side z = 1 + 4 y (1 - y) / 2 above 0 < y < 1."""
    places = [(3, 0, 1), (3, 0, 0), (3, 1, 0), (3, 1, 1)]
    points = [occ.addPoint(*place) for place in places]
    top = occ.addBezier([points[3], occ.addPoint(3, 0.5, 2), points[0]])
    sides = [occ.addLine(points[k], points[k + 1]) for k in range(3)]
    occ.addPlaneSurface([occ.addCurveLoop([*sides, top])])


STADIUM = (6 + pi, 6 + 2 * pi)
# ∫ sqrt(1 + s²) dy along the parabola z = 1 + 2 y (1 - y) of slope s = 2 - 4y, -2 < s < 2:
# (1/4) [s sqrt(1 + s²) + asinh s] from 0 to 2, twice over two
PARABOLA = (2 * sqrt(5) + np.arcsinh(2)) / 4


@pytest.mark.parametrize("suffix", SUFFIXES)
@pytest.mark.parametrize(
    ("author", "area", "length", "pieces"),
    [
        (stadium_with_a_hole, STADIUM[0] - pi / 4, STADIUM[1] + pi, 6 + 4),
        (two_squares, 3, 8, 6),
        (upright, 1 + 2 / 6, 3 + PARABOLA, 4),
    ],
)
def test_sketches(drawn, author, area: float, length: float, pieces: int, suffix: str) -> None:
    """Holes lower the area; each edge has its number; arcs end after 90 degrees.

    The parabola's area is 2/3 of 1 × 1/2 above the square.
    """
    boundary = read_outline(drawn(author, suffix))
    tolerance = 1e-12 if suffix == ".step" else 1e-10  # IGES holds ten digits
    assert boundary.volume(32) == pytest.approx(area, rel=tolerance)
    assert boundary.area(32) == pytest.approx(length, rel=tolerance)
    assert len(boundary.patches) == pieces
    assert (boundary.dimension, boundary.unit) == (2, "mm")
    numbers = {patch.face for patch in boundary.patches}
    assert len(boundary.named(first=min(numbers)).select("first")) >= 1


def test_coordinates_of_an_upright_sketch(drawn) -> None:
    """The plane x = 3 has the coordinates y and z; the control point of the parabola is at 2."""
    low, high = read_outline(drawn(upright)).bounds()
    assert low == pytest.approx([0, 0], abs=1e-12)
    assert high == pytest.approx([1, 2], rel=1e-12)


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_wires(drawn, suffix: str) -> None:
    """Without faces: the ring between stadium and hole is a region, and so is the island."""
    path = drawn(wires, suffix)
    tolerance = 1e-12 if suffix == ".step" else 1e-9
    ring, island = (read_outline(path, region=k) for k in (1, 2))
    assert ring.volume() == pytest.approx(STADIUM[0] - pi * 0.75**2, rel=tolerance)
    assert island.volume() == pytest.approx(pi / 16, rel=tolerance)
    with pytest.raises(CadError, match=r"2 regions \(1 of area 7.374 .* 2 of area 0.1963 about"):
        read_outline(path)


def test_polygon_in_one_curve(drawn) -> None:
    """A triangle drawn as one spline of degree 1 is cut at its kinks."""

    def triangle() -> None:
        corners = [occ.addPoint(*place, 0) for place in ((0, 0), (3, 0), (0, 4))]
        sides = [occ.addBSpline([corners[0], corners[1], corners[2]], degree=1),
                 occ.addLine(corners[2], corners[0])]  # fmt: skip
        occ.addPlaneSurface([occ.addCurveLoop(sides)])

    boundary = read_outline(drawn(triangle))
    assert len(boundary.patches) == 3
    assert boundary.volume() == pytest.approx(6, rel=1e-13)
    assert boundary.area() == pytest.approx(12, rel=1e-13)


# Area, perimeter and number of pieces of each name. Round pipe: radius 1, length 6. Bent pipe:
# straight lengths of 4 in all, and a quarter turn of radius 3; walls of radius 2 and 4.
CUTS = [
    ("y_junction", {}, 92, 4 + 4 + 4 + 2 * (6 + 10 - 2 * sqrt(2) + 8),
     {"inlet_a": 1, "inlet_b": 1, "outlet": 2, "walls": 6}),
    ("y_junction", {"point": (0, 0, 0)}, 92, 4 + 4 + 4 + 2 * (6 + 10 - 2 * sqrt(2) + 8),
     {"inlet_a": 1, "inlet_b": 1, "outlet": 2, "walls": 6}),
    ("square_channel", {}, 2, 6, {"inlet": 1, "outlet": 1, "walls": 2}),
    ("round_pipe", {"normal": (0, 1, 0)}, 12, 16, {"inlet": 3, "outlet": 3, "walls": 2}),
    ("round_pipe", {"normal": (-2, 0, 0)}, pi, 2 * pi, {"walls": 4}),
    ("bent_pipe", {}, 2 * (4 + 1.5 * pi), 2 * (4 + 1.5 * pi) + 4,
     {"inlet": 3, "outlet": 3, "walls": 6}),
    ("serpentine", {}, 16 + 3 * pi, 2 * (16 + 3 * pi) + 2,
     {"inlet": 1, "outlet": 1, "walls": 20}),
]  # fmt: skip


@pytest.mark.parametrize(("drawing", "plane", "area", "length", "pieces"), CUTS)
def test_cuts(drawing: str, plane: dict, area: float, length: float, pieces: dict) -> None:
    """Lines and circles of the kernel; names of the faces; a plane in a face of the solid too."""
    boundary = read_outline(GEOMETRIES / f"{drawing}.step", **plane)
    assert boundary.volume() == pytest.approx(area, rel=1e-12)
    assert boundary.area() == pytest.approx(length, rel=1e-12)
    assert Counter(patch.name for patch in boundary.patches) == pieces


def test_an_oblique_cut() -> None:
    """A pipe of radius 1 at 45 degrees: an ellipse of semi-axes √2 and 1, area π √2."""
    boundary = read_outline(GEOMETRIES / "round_pipe.step", normal=(1, 1, 0))
    assert boundary.volume() == pytest.approx(pi * sqrt(2), rel=1e-12)
    spans = np.ptp(boundary.quadrature(32)[0].position, axis=1)
    assert spans == pytest.approx([2 * sqrt(2), 2], rel=1e-3)


def test_a_spline_wall_is_cut_exactly() -> None:
    """Height 1 and volume 11.2: so is the area of the plan, to rounding, on the wall's own cubic;
    the kernel's fit of the cut has degree 6 and is 1e-9 off."""
    boundary = read_outline(GEOMETRIES / "constriction.step")
    assert boundary.volume() == pytest.approx(11.2, rel=1e-13)
    assert Counter(p.name for p in boundary.patches) == {"inlet": 1, "outlet": 1, "walls": 2}
    assert max(p.surface.degrees for p in boundary.patches) == (3,)


def test_inlets_of_two_branches() -> None:
    """A plane x = 1 cuts both branches of the Y-junction: 2 × 4 each."""
    path = GEOMETRIES / "y_junction.step"
    with pytest.raises(CadError, match=r"2 regions .* choose one with region=1"):
        read_outline(path, point=(1, 0, 0), normal=(1, 0, 0))
    both = [read_outline(path, point=(1, 0, 0), normal=(1, 0, 0), region=k) for k in (1, 2)]
    assert [b.volume() for b in both] == pytest.approx([8, 8], rel=1e-12)
    assert {name for b in both for name in b.names} == {"inlet_a", "inlet_b", "walls"}


def solved(boundary: Boundary, inlets: dict[str, float]):
    conditions = {name: Inflow(mean_velocity=speed) for name, speed in inlets.items()}
    conditions |= {"outlet": Pressure(0.0), "walls": NoSlip()}
    return StokesProblem(boundary, 1.0, conditions, Quadrature(1e-10)).solve()


def test_flow_in_a_plan() -> None:
    """Square channel: plane Poiseuille flow, u = 1.5 U (1 - 4y²/W²), pressure drop 12 μ U L / W²
    = 24 for U = W = 1 and L = 2, which splines of degree 2 hold exactly."""
    plan = read_outline(GEOMETRIES / "square_channel.step").elevated(2).refined(size=0.25)
    solution = solved(plan, {"inlet": 1.0})
    assert solution.mean_pressure("inlet") == pytest.approx(24, rel=1e-9)
    assert solution.velocity_at([[0.0], [0.25]])[:, 0] == pytest.approx([1.125, 0], abs=1e-9)
    assert abs(solution.net_flux()) < 1e-10


def test_flow_in_the_plan_of_a_junction() -> None:
    """Two inlets of width 4 with mean velocity 3: 24 leave by the outlet; by symmetry the mean
    pressures of both inlets are the same."""
    plan = read_outline(GEOMETRIES / "y_junction.step").elevated(2).refined(size=0.7)
    solution = solved(plan, {"inlet_a": 3.0, "inlet_b": 3.0})
    assert abs(solution.net_flux()) < 1e-10
    assert solution.flow_rate("outlet") == pytest.approx(-24, rel=1e-10)
    pressures = [solution.mean_pressure(name) for name in ("inlet_a", "inlet_b")]
    assert pressures[0] == pytest.approx(pressures[1], rel=1e-9)


def open_wire() -> None:
    occ.remove([(1, stadium()[0])])


def bent_wire() -> None:
    corners = [occ.addPoint(*place) for place in ((0, 0, 0), (1, 0, 0), (1, 1, 1), (0, 1, 0))]
    for k in range(4):
        occ.addLine(corners[k - 1], corners[k])


def dome() -> None:
    """Half a sphere's surface: its rim is plane, it is not."""
    occ.addSphere(0, 0, 0, 1, angle1=0)
    occ.remove([(3, 1)])
    occ.synchronize()
    flat = [t for _, t in gmsh.model.getEntities(2) if gmsh.model.getType(2, t) == "Plane"]
    occ.remove([(2, tag) for tag in flat])


@pytest.mark.parametrize(
    ("author", "message"),
    [
        (open_wire, "the wires do not close: 2 open ends, the first at"),
        (bent_wire, "neither a solid to cut nor plane faces nor closed wires in a plane"),
        (dome, "the faces are not plane"),
    ],
)
def test_bad_sketches(drawn, author, message: str) -> None:
    with pytest.raises(CadError, match=message):
        read_outline(drawn(author))


def test_bad_planes(drawn) -> None:
    path = GEOMETRIES / "square_channel.step"
    message = "the plane misses the solid, which reaches from [-1, -0.5, -0.5] mm to [1, 0.5, 0.5]"
    with pytest.raises(CadError, match=re.escape(message)):
        read_outline(path, point=(0, 0, 3))
    with pytest.raises(InputError, match="normal is .*; give a vector that is not 0"):
        read_outline(path, normal=(0, 0, 0))
    with pytest.raises(CadError, match="there is no solid to cut"):
        read_outline(drawn(two_squares), normal=(0, 0, 1))
