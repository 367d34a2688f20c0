"""The room between mouths that are picked: `between=` of read_cad, and what info says of chips."""

from math import asin, pi, sqrt
from pathlib import Path

import gmsh
import pytest
from drawn import exported

from cadbem.boundary import Boundary
from cadbem.cad import inspect_cad, read_cad
from cadbem.cli import main
from cadbem.errors import CadError

occ = gmsh.model.occ


def turned(profile: list[tuple[float, float]]) -> list[tuple[int, int]]:
    """The solid that a polygon (r, z) leaves when it turns round z."""
    points = [occ.addPoint(r, 0, z) for r, z in profile]
    lines = [occ.addLine(points[k - 1], points[k]) for k in range(len(points))]
    face = occ.addPlaneSurface([occ.addCurveLoop(lines)])
    made = occ.revolve([(2, face)], 0, 0, 0, 0, 0, 1, 2 * pi)
    occ.remove([(2, face)], recursive=True)
    return [entity for entity in made if entity[0] == 3]


def needle():
    """A tube of 0.6 inside and 1 outside, 4 long, whose lower end is a knife edge."""
    turned([(0.3, 0), (0.5, 1), (0.5, 4), (0.3, 4)])


def lipped_tube():
    """The same bore with a full round lip of radius 0.1 at both ends, 4 between their middles."""
    tube = turned([(0.3, 0), (0.5, 0), (0.5, 4), (0.3, 4)])
    occ.fuse(tube, [(3, occ.addTorus(0, 0, z, 0.4, 0.1)) for z in (0, 4)])


def barb():
    """A bore of diameter 1 through a barbed tube of length 3."""
    turned([(0.5, 0), (0.8, 0), (1.2, 0.6), (0.9, 0.6), (0.9, 1.2), (1.2, 1.8), (0.9, 1.8),
            (0.9, 3), (0.5, 3)])  # fmt: skip


LUER = pi * 6 / 3 * (1 + 1.5 + 1.5**2) + pi * 0.16 * 2


def luer():
    """A flanged hub with a cone from radius 1.5 (z = 8) to 1 (z = 2), then a bore of radius 0.4."""
    hub = turned([(0, 0), (2.5, 0), (2.5, 7), (3.5, 7), (3.5, 8), (0, 8)])
    cone = turned([(0, 2), (1, 2), (1.5, 8), (0, 8)])
    occ.cut(hub, [*cone, (3, occ.addCylinder(0, 0, 0, 0, 0, 2, 0.4))])


def block_on_glass():
    """A block 10 × 4 × 3 with a groove 6 × 0.3 × 0.2 in its underside and wells of 0.5 × 0.5
    punched at its ends, on a larger slide: V = 6 · 0.06 + 2 · 0.25 · 3 - 2 · 0.25 · 0.3 · 0.2."""
    groove = [(3, occ.addBox(2, 1.85, 0, 6, 0.3, 0.2))]
    wells = [(3, occ.addBox(x - 0.25, 1.75, 0, 0.5, 0.5, 3)) for x in (2, 8)]
    occ.cut([(3, occ.addBox(0, 0, 0, 10, 4, 3))], groove + wells)
    occ.addBox(-1, -1, -1, 12, 6, 1)


def manifold():
    """Three blocks that touch: a bore of radius 0.5 and length 6 in the first one, a pocket of
    2 × 1.6 × 1.6 with a riser of 1 × 1 × 1.2 in the second, a bore 0.3 × 2 up in the third."""
    bore = [(3, occ.addCylinder(0, 2, 2, 6, 0, 0, 0.5))]
    occ.cut([(3, occ.addBox(0, 0, 0, 6, 4, 4))], bore)
    pocket = [(3, occ.addBox(6, 1.2, 1.2, 2, 1.6, 1.6)), (3, occ.addBox(6.5, 1.5, 2.8, 1, 1, 1.2))]
    occ.cut([(3, occ.addBox(6, 0, 0, 4, 4, 4))], pocket)
    occ.cut([(3, occ.addBox(6, 0, 4, 4, 4, 2))], [(3, occ.addCylinder(7, 2, 4, 0, 0, 2, 0.3))])


def areas(boundary: Boundary) -> dict[str, float]:
    return {
        name: Boundary(tuple(boundary.patches[k] for k in boundary.select(name))).area()
        for name in boundary.names
        if name
    }


@pytest.mark.parametrize("suffix", [".step", ".igs"])
@pytest.mark.parametrize(
    ("draw", "between", "volume", "openings"),
    [
        (needle, ((0, 0, 0), (0, 0, 4)), 0.36 * pi, (0.09 * pi, 0.09 * pi)),
        (lipped_tube, ("mouth 1", "mouth 2"), 0.36 * pi, (0.09 * pi, 0.09 * pi)),
        (barb, ("mouth 1", (0.1, 0, 3)), 0.75 * pi, (pi / 4, pi / 4)),
        (luer, ("mouth 2", "mouth 1"), LUER, (0.16 * pi, 2.25 * pi)),
        (block_on_glass, ("mouth 1", "mouth 2"), 1.83, (0.25, 0.25)),
    ],
)
def test_rooms_between_mouths(folder: Path, draw, between, volume: float, openings, suffix: str):
    """Volumes of cylinders, cones and boxes; the caps are circles and squares, and keep their names
    beside walls."""
    draw()
    boundary = read_cad(exported(folder / f"chip{suffix}"), between=between).named(rest="walls")
    assert boundary.names == ("mouth_1", "mouth_2", "walls")
    assert boundary.volume() == pytest.approx(volume, rel=1e-6)
    caps = areas(boundary)
    assert [caps["mouth_1"], caps["mouth_2"]] == pytest.approx(openings, rel=1e-6)


def test_a_manifold_of_three_solids(folder: Path):
    """1.5 π + 5.12 + 1.2 + 0.18 π, from the first block's side to the third one's top."""
    manifold()
    path = exported(folder / "manifold.step")
    boundary = read_cad(path, between=((0, 2, 2), (7, 2, 6)))
    assert boundary.volume() == pytest.approx(1.68 * pi + 6.32, rel=1e-9)
    assert set(areas(boundary)) == {"mouth_1", "mouth_2"}
    assert read_cad(path, fluid="void").volume() == pytest.approx(1.68 * pi + 6.32, rel=1e-9)


def test_a_part_of_a_bore_ends_at_a_ring_that_is_no_mouth(folder: Path):
    """The cone of the hub alone: from the ring where the bore begins, by a point in it."""
    luer()
    boundary = read_cad(exported(folder / "luer.step"), between=((0, 0, 2), "mouth 2"))
    assert boundary.volume() == pytest.approx(2 * pi * (1 + 1.5 + 1.5**2), rel=1e-9)
    assert areas(boundary) == pytest.approx({"mouth_2": 2.25 * pi, "mouth_3": 0.16 * pi}, rel=1e-9)


def test_faces_pick_mouths(folder: Path):
    """The face round the upper end of the needle, and its bore, which has two."""
    needle()
    path = exported(folder / "needle.step")
    faces = {(face.kind, round(face.area, 6)): face.number for face in inspect_cad(path).faces}
    end = faces["plane", round(0.16 * pi, 6)]
    assert read_cad(path, between=(end, "mouth 1")).volume() == pytest.approx(0.36 * pi)
    with pytest.raises(CadError, match=r"has several mouths.*mouth 1 at \[0, 0, 0\] 0.6 mm wide"):
        read_cad(path, between=(faces["cylinder", round(2.4 * pi, 6)], "mouth 1"))


def test_picks_that_are_no_two_mouths_of_a_room(folder: Path):
    """Two bores that do not meet, and mouths that are not there."""
    bores = [(3, occ.addCylinder(0, y, 1, 6, 0, 0, 0.5)) for y in (1, 3)]
    occ.cut([(3, occ.addBox(0, 0, 0, 6, 4, 2))], bores)
    path = exported(folder / "bores.step")
    for between, words in (
        (("mouth 1", "mouth 2"), r"belong to no common room; .*mouth 4 at \[6, 3, 1\] 1 mm wide"),
        (("mouth 1", "mouth 1"), "picked twice"),
        (("mouth 1", "mouth 5"), "there is no 'mouth 5'"),
        (((0, 1, 1), (3, 3, 3)), "no mouth is round the point"),
        (((0, 1), (6, 1, 1)), "three coordinates"),
    ):
        with pytest.raises(CadError, match=words):
            read_cad(path, between=between)
    assert read_cad(path, between=((0, 1, 1), (6, 1, 1))).volume() == pytest.approx(1.5 * pi)


def test_further_mouths_of_the_room_are_said(folder: Path):
    """A cross of two square bores: V = 2 · 6 · 1 - 1."""
    bores = [(3, occ.addBox(0, 2.5, 0.5, 6, 1, 1)), (3, occ.addBox(2.5, 0, 0.5, 1, 6, 1))]
    occ.cut([(3, occ.addBox(0, 0, 0, 6, 6, 2))], bores)
    with pytest.warns(match=r"further mouths.*mouth 2 at \[3, 0, 1\] 1 mm wide; mouth 3"):
        boundary = read_cad(exported(folder / "cross.step"), between=((0, 3, 1), (6, 3, 1)))
    assert boundary.volume() == pytest.approx(11)
    assert boundary.names == ("", "mouth_1", "mouth_2", "mouth_3", "mouth_4")


def test_info_tells_chips_from_fluids(folder: Path, capsys: pytest.CaptureFixture[str]):
    """A block on glass is a chip; a channel round a pillar is a fluid."""
    block_on_glass()
    path = exported(folder / "block.step")
    assert main(["info", str(path)]) == 0
    said = capsys.readouterr().out
    assert "looks like a chip" in said and "mouth 2 at [8, 2, 3] 0.5 mm wide" in said
    assert main(["info", str(path), "--between", "mouth 1", "mouth 2"]) == 0
    said = capsys.readouterr().out
    assert "looks like a chip" not in said and "volume     1.83 mm^3" in said
    assert "mouths of the room: mouth_1 at [2, 2, 3] mm, 0.5 mm wide; mouth_2 at [8, 2, 3]" in said
    gmsh.clear()
    occ.cut([(3, occ.addBox(0, 0, 0, 9, 4, 1))], [(3, occ.addCylinder(4, 2, 0, 0, 0, 1, 0.5))])
    assert inspect_cad(exported(folder / "pillar.step")).remarks == ()


@pytest.mark.parametrize("suffix", [".step", ".igs"])
@pytest.mark.parametrize("angle", [0.0, 0.1, 1.0, 3.0])
def test_a_hole_in_the_side_of_a_tube(folder: Path, angle: float, suffix: str):
    """A tube of radii 0.5 and 1, 4 long, with a square hole of 0.6 through its side, wherever the
    seam of the tube is. The hole runs from x = (1/4 - y²)^½ to (1 - y²)^½ for |y| < 0.3, times 0.6:
    V = π + 0.6 (F(1) - F(1/2)) with F(r) = 0.3 (r² - 0.09)^½ + r² asin(0.3 / r); the lid is
    0.6 · 2 asin(0.3)."""
    bore = [(3, occ.addCylinder(0, 0, 0, 0, 0, 4, 0.5))]
    hole = [(3, occ.addBox(0, -0.3, 1.7, 2, 0.6, 0.6))]
    occ.rotate(hole, 0, 0, 0, 0, 0, 1, angle)
    occ.cut([(3, occ.addCylinder(0, 0, 0, 0, 0, 4, 1))], occ.fuse(bore, hole)[0])
    boundary = read_cad(exported(folder / f"tube{suffix}"), fluid="void")

    def primitive(r: float) -> float:
        return 0.3 * sqrt(r * r - 0.09) + r * r * asin(0.3 / r)

    expected = pi + 0.6 * (primitive(1) - primitive(0.5))
    assert boundary.volume() == pytest.approx(expected, rel=2e-6)
    assert sorted(areas(boundary).values()) == pytest.approx(
        [1.2 * asin(0.3), pi / 4, pi / 4], rel=2e-6
    )
