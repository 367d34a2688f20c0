"""Which solid, or which room in a chip, is the fluid: `fluid=` of read_cad and inspect_cad."""

import re
from math import asin, pi
from pathlib import Path

import gmsh
import numpy as np
import pytest
from drawn import exported

from cadbem.cad import inspect_cad, read_cad, write_cad
from cadbem.cad.body.model import CadModel, open_model
from cadbem.cad.body.orientation import enclosed
from cadbem.errors import CadError

occ = gmsh.model.occ


def opened(path: Path, fluid: int | str = "solid") -> CadModel:
    return open_model(path, 60.0, fluid=fluid)


def volume(model: CadModel) -> float:
    """Of the closed faces by Green's theorem, positive if their normals point out of the fluid."""
    assert model.obstacles() == []
    return enclosed(model.faces)


def question(path: Path, fluid: int | str = "solid") -> str:
    with pytest.raises(CadError) as caught:
        read_cad(path, fluid=fluid)
    assert "\n" not in str(caught.value)
    return str(caught.value)


def port_places(model: CadModel) -> dict[str, list[float]]:
    by_number = {face.number: face for face in model.faces}
    return {
        name: np.round(model.centre(by_number[number]), 9).tolist()
        for number, name in model.names.items()
    }


def chip_with_channel():
    """10 × 4 × 3 with a channel of 1 × 1 along x at y = 2, z = 1.5."""
    occ.cut([(3, occ.addBox(0, 0, 0, 10, 4, 3))], [(3, occ.addBox(0, 1.5, 1, 10, 1, 1))])


def hollow_box():
    """3 × 3 × 3 with a closed cavity of 1 × 1 × 1 about (1.5, 1.5, 1.5)."""
    occ.cut([(3, occ.addBox(0, 0, 0, 3, 3, 3))], [(3, occ.addBox(1, 1, 1, 1, 1, 1))])


def two_boxes():
    """1 × 2 × 3 and, apart from it, 2 × 2 × 2."""
    occ.addBox(0, 0, 0, 1, 2, 3)
    occ.addBox(5, 0, 0, 2, 2, 2)


def nested_boxes():
    """A hollow box and another solid that fills its cavity."""
    hollow_box()
    occ.addBox(1, 1, 1, 1, 1, 1)


@pytest.mark.parametrize("suffix", [".step", ".igs"])
def test_a_straight_channel_in_a_chip(folder: Path, suffix: str):
    """10 × 1 × 1: ends of area 1 at x = 0 and 10, in the order of x; four walls of area 10."""
    chip_with_channel()
    channel = read_cad(exported(folder / f"chip{suffix}"), fluid="void")
    assert channel.volume() == pytest.approx(10, rel=1e-9)
    assert channel.names == ("", "port_1", "port_2")
    for name, x in (("port_1", 0), ("port_2", 10)):
        port = channel.select(name)
        assert np.allclose([channel.patches[i].middle().position[:, 0] for i in port], [x, 2, 1.5])
        assert len(port) == 1
    assert channel.area() == pytest.approx(42, rel=1e-9)


def test_normals_of_a_channel_in_a_chip_point_into_the_channel(folder: Path):
    """At each point of its faces a step along the normal comes nearer to the middle of the box."""
    chip_with_channel()
    points, _ = read_cad(exported(folder / "chip.step"), fluid="void").quadrature(3)
    inside = points.position + 0.01 * points.normal
    assert ((inside[0] > 0) & (inside[0] < 10)).all()
    assert (abs(inside[1:] - [[2], [1.5]]) < 0.5).all()


def test_a_round_t_channel_in_a_chip(folder: Path):
    """Pipes of radius r = 0.5: one of length 10 along x, one from its axis to the side y = 4, 2
    long. Half of the bicylinder 16 r³/3 belongs to both: V = π r² (10 + 2) - 8 r³/3. Ports are at
    x = 0, at y = 4 in the middle, and at x = 10."""
    pipes = [occ.addCylinder(0, 2, 1.5, 10, 0, 0, 0.5), occ.addCylinder(5, 2, 1.5, 0, 2, 0, 0.5)]
    occ.cut([(3, occ.addBox(0, 0, 0, 10, 4, 3))], [(3, pipe) for pipe in pipes])
    model = opened(exported(folder / "chip.step"), "void")
    assert volume(model) == pytest.approx(pi * 0.25 * 12 - 8 * 0.125 / 3, rel=1e-8)
    assert port_places(model) == {
        "port_1": [0, 2, 1.5], "port_2": [5, 4, 1.5], "port_3": [10, 2, 1.5],
    }  # fmt: skip
    assert len(model.faces) == 5


def test_walls_of_a_void_keep_the_chips_names(folder: Path):
    """The channel's floor, z = 1, is called so in the file; the ports have names of their own."""
    chip_with_channel()
    occ.synchronize()
    middles = {tag: occ.getCenterOfMass(2, tag) for _, tag in gmsh.model.getEntities(2)}
    write_cad(
        folder / "chip.step",
        {tag: "floor" for tag, middle in middles.items() if np.allclose(middle, [5, 2, 1])},
    )
    model = opened(folder / "chip.step", "void")
    assert port_places(model)["floor"] == [5, 2, 1]
    assert sorted(model.names.values()) == ["floor", "port_1", "port_2"]


def test_sides_that_are_not_flat_hold_no_ports(folder: Path):
    """A disc with a U-shaped channel between two holes in its top, of 1 × 1 × 1 each and
    2 × 1 × 0.5 between them: V = 3. The room beside the disc's round wall is no choice."""
    parts = [(-2, 1, 1), (1, 1, 1), (-1, 2, 0.5)]  # x, length, height
    tools = [(3, occ.addBox(x, -0.5, 1, length, 1, height)) for x, length, height in parts]
    occ.cut([(3, occ.addCylinder(0, 0, 0, 0, 0, 2, 5))], tools)
    model = opened(exported(folder / "disc.step"), "void")
    assert volume(model) == pytest.approx(3, rel=1e-12)
    assert port_places(model) == {"port_1": [-1.5, 0, 2], "port_2": [1.5, 0, 2]}


def test_a_plane_wall_deep_inside_is_no_side(folder: Path):
    """A tube of radii 0.7 and 1 and length 4 along z, whose corners lie at y = 0, as does the end
    of a rib in its bore, 0.6 wide and 1 long: V = π 0.7² 4 less the rib."""
    ring = occ.cut([(3, occ.addCylinder(0, 0, 0, 0, 0, 4, 1))],
                   [(3, occ.addCylinder(0, 0, 0, 0, 0, 4, 0.7))])[0]  # fmt: skip
    rib = occ.intersect([(3, occ.addBox(-0.3, -2, 1, 0.6, 2, 1))],
                        [(3, occ.addCylinder(0, 0, 0, 0, 0, 4, 0.8))])[0]  # fmt: skip
    occ.fuse(ring, rib)
    model = opened(exported(folder / "tube.step"), "void")
    # cross-section of the rib in the bore: strip |x| < 0.3 from y = -sqrt(0.49 - x²) to 0
    strip = 0.3 * (0.49 - 0.09) ** 0.5 + 0.49 * asin(0.3 / 0.7)
    assert volume(model) == pytest.approx(pi * 0.49 * 4 - strip, rel=1e-8)
    assert port_places(model) == {"port_1": [0, 0, 0], "port_2": [0, 0, 4]}


def test_a_chip_across_the_axes(folder: Path):
    """The channel of 10 × 1 × 1 again: V = 10 however the chip is turned."""
    chip_with_channel()
    occ.rotate([(3, 1)], 0, 0, 0, 0, 0, 1, 0.5)
    model = opened(exported(folder / "chip.step"), "void")
    assert volume(model) == pytest.approx(10, rel=1e-9)
    assert sorted(model.names.values()) == ["port_1", "port_2"]


def test_several_rooms_are_listed_and_chosen_by_number(folder: Path):
    """Channels of 1 × 1 × 10 and 1 × 2 × 10, the larger first, and a closed cavity of 0.5³."""
    tools = [occ.addBox(0, 1, 1, 10, 1, 1), occ.addBox(0, 3, 1, 10, 2, 1)]
    tools.append(occ.addBox(5, 6, 1, 0.5, 0.5, 0.5))
    occ.cut([(3, occ.addBox(0, 0, 0, 10, 8, 3))], [(3, tool) for tool in tools])
    path = exported(folder / "chip.step")
    asked = question(path, "void")
    assert "3 rooms" in asked
    assert "1 with 6 faces, volume 20, port_1 at [0, 4, 1.5] 2 mm wide, port_2 at [10, 4" in asked
    assert "3 with 6 faces, volume 0.125)" in asked
    for number, size in ((1, 20), (2, 10), (3, 0.125)):
        assert volume(opened(path, f"void {number}")) == pytest.approx(size, rel=1e-9)
    with pytest.raises(CadError, match="no void 4"):
        read_cad(path, fluid="void 4")


def test_a_full_box_has_no_void(folder: Path):
    occ.addBox(0, 0, 0, 1, 2, 3)
    assert "no void" in question(exported(folder / "box.step"), "void")


@pytest.mark.parametrize("suffix", [".step", ".igs"])
def test_a_closed_cavity_is_not_passed_over(folder: Path, suffix: str):
    """Between the shells 27 - 1, within the cavity 1; normals at the cavity's side x = 1 point into
    the fluid: along -x, and along +x."""
    hollow_box()
    path = exported(folder / f"hollow{suffix}")
    asked = question(path)
    assert "1 closed cavity (1 with 6 faces about [1.5, 1.5, 1.5] mm, volume 1)" in asked
    assert "fluid='void'" in asked
    assert "fluid='material'" in asked
    for fluid, size, direction in (("material", 26, -1), (1, 26, -1), ("void", 1, 1)):
        boundary = read_cad(path, fluid=fluid)
        assert boundary.volume() == pytest.approx(size, rel=1e-9)
        points, _ = boundary.quadrature(3)
        wall = (abs(points.position[0] - 1) < 1e-6) & (abs(points.position[1:] - 1.5) < 0.5).all(0)
        assert wall.any()
        assert np.allclose(points.normal[:, wall], [[direction], [0], [0]], atol=1e-9)


def test_the_room_in_a_named_shell(folder: Path):
    hollow_box()
    path = exported(folder / "hollow.step")
    names = iter(("outside", "reservoir"))
    shell = re.compile(r"(?<!_)CLOSED_SHELL\(''")
    path.write_text(shell.sub(lambda _: f"CLOSED_SHELL('{next(names)}'", path.read_text()))
    assert "fluid='reservoir' for inside" in question(path)
    assert read_cad(path, fluid="reservoir").volume() == pytest.approx(1, rel=1e-12)
    assert "no solid or inner shell is called 'outside'" in question(path, "outside")


def named(path: Path, *names: str) -> Path:
    """The file with names of its solids in the file's order."""
    found = iter(names)
    text = re.sub(
        r"(MANIFOLD_SOLID_BREP|BREP_WITH_VOIDS)\(''",
        lambda match: f"{match[1]}('{next(found)}'",
        path.read_text(),
    )
    path.write_text(text)
    return path


def test_several_solids_are_listed_and_chosen(folder: Path):
    """1 × 2 × 3 and 2 × 2 × 2."""
    two_boxes()
    path = named(exported(folder / "two.step"), "Body 1", "Body 2")
    asked = question(path)
    assert "1 'Body 1' with 6 faces about [0.5, 1, 1.5] mm, volume 6; 2 'Body 2' with" in asked
    assert "fluid='Body 1'" in asked
    for fluid, size in ((1, 6), (2, 8), ("Body 1", 6), ("Body 2", 8), ("all", 14)):
        assert read_cad(path, fluid=fluid).volume() == pytest.approx(size, rel=1e-12)
    assert "no solid 3" in question(path, 3)
    assert "'Body 3'" in question(path, "Body 3")
    assert "2 solids are called 'twin'" in question(
        named(exported(folder / "twins.step"), "twin", "twin"), "twin"
    )


def test_reports_ask_the_same_question(folder: Path):
    two_boxes()
    path = exported(folder / "two.step")
    report = inspect_cad(path)
    assert len(report.faces) == 12
    assert "2 solids" in report.problems[0]
    assert inspect_cad(path, fluid=2).volume == pytest.approx(8, rel=1e-12)


@pytest.mark.parametrize("fluid", [0, -1, True, "", 1.5, None])
def test_what_is_neither_a_name_nor_a_number(folder: Path, fluid: object):
    with pytest.raises(CadError, match="solid's name or number"):
        read_cad(folder / "any.step", fluid=fluid)  # type: ignore[arg-type]


def test_cells_that_share_faces_are_one_volume(folder: Path):
    """Two cubes and, on part of the second one's side, a smaller box of 1 × 0.5 × 0.5: of 6 + 6 + 6
    faces the shared ones go (a ring stays of the side): 5 + 5 + 5. V = 2.25."""
    occ.addBox(0, 0, 0, 1, 1, 1)
    occ.addBox(1, 0, 0, 1, 1, 1)
    occ.addBox(2, 0.25, 0.25, 1, 0.5, 0.5)
    model = opened(exported(folder / "cells.step"), "all")
    assert volume(model) == pytest.approx(2.25, rel=1e-12)
    assert len(model.faces) == 5 + 5 + 5


def test_overlapping_solids_together_are_their_union(folder: Path):
    """Two unit cubes that share half of each: V = 1.5."""
    occ.addBox(0, 0, 0, 1, 1, 1)
    occ.addBox(0.5, 0, 0, 1, 1, 1)
    assert volume(opened(exported(folder / "cells.step"), "all")) == pytest.approx(1.5, rel=1e-12)


def test_solids_that_touch_in_an_edge_are_not_one_volume(folder: Path):
    occ.addBox(0, 0, 0, 1, 1, 1)
    occ.addBox(1, 1, 0, 1, 1, 1)
    (problem,) = opened(exported(folder / "cells.step"), "all").obstacles()
    assert "1 edges belong to more than two faces, the first at [1, 1, 0.5] mm" in problem


@pytest.mark.parametrize(("fluid", "size"), [(1, 26), (2, 1), ("all", 27)])
def test_nested_solids(folder: Path, fluid: int | str, size: float):
    nested_boxes()
    path = exported(folder / "nested.step")
    assert read_cad(path, fluid=fluid).volume() == pytest.approx(size, rel=1e-12)
