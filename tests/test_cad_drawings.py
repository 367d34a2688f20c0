"""Drawings in DXF and GDS: outlines and channels of constant height, areas in closed form."""

from math import pi, sqrt
from pathlib import Path

import ezdxf
import gdstk
import numpy as np
import pytest

from cadbem.boundary import Boundary
from cadbem.cad import read_layout, read_outline
from cadbem.errors import CadError, CadWarning, InputError

UM, MM = 13, 4  # $INSUNITS


def saved(path: Path, draw, units: int = MM) -> Path:
    document = ezdxf.new(units=units)
    draw(document.modelspace(), document)
    document.saveas(path)
    return path


def area_of(boundary: Boundary, name: str) -> float:
    return Boundary(tuple(boundary.patches[k] for k in boundary.select(name))).area()


def bend(space, _):
    """A channel 200 wide: 1000 along x, a quarter turn of inner radius 100, 500 along y; the frame
    ends at x = 0 and y = 800."""
    space.add_lwpolyline(
        [(0, 0, 0), (1000, 0, np.tan(pi / 8)), (1300, 300, 0), (1300, 800, 0), (1100, 800, 0),
         (1100, 300, -np.tan(pi / 8)), (1000, 200, 0), (0, 200, 0)],
        format="xyb", close=True, dxfattribs={"layer": "channels"},
    )  # fmt: skip
    frame = [(0, -500), (2000, -500), (2000, 800), (0, 800)]
    space.add_lwpolyline(frame, close=True, dxfattribs={"layer": "chip"})
    space.add_text("bend", dxfattribs={"layer": "channels"})


BEND = 200 * 1000 + 200 * 500 + pi / 4 * (300**2 - 100**2)
BEND_WALLS = 2 * 1000 + 2 * 500 + pi / 2 * (300 + 100)


def test_a_bend_in_micrometres_with_ports_at_its_frame(tmp_path: Path):
    """Plan, walls and ports of 200 × 50, in the order of x."""
    channel = read_layout(saved(tmp_path / "bend.dxf", bend, UM), height=50, layer="channels")
    assert (channel.unit, channel.dimension) == ("um", 3)
    assert channel.volume() == pytest.approx(50 * BEND, rel=1e-9)
    assert channel.area() == pytest.approx(2 * BEND + 50 * (BEND_WALLS + 400), rel=1e-9)
    assert channel.named(rest="walls").names == ("port_1", "port_2", "walls")
    for name, place in (("port_1", (0, 100, 25)), ("port_2", (1200, 800, 25))):
        (index,) = channel.select(name)
        assert channel.patches[index].middle().position[:, 0] == pytest.approx(place)
    points, weights = channel.quadrature(12)
    assert points.normal @ weights == pytest.approx(np.zeros(3), abs=1e-6)


def test_the_same_outline_in_the_plane(tmp_path: Path):
    plan = read_outline(saved(tmp_path / "bend.dxf", bend, UM), layer="channels")
    assert plan.dimension == 2 and plan.unit == "um"
    assert plan.volume() == pytest.approx(BEND, rel=1e-12)
    assert plan.area() == pytest.approx(BEND_WALLS + 400, rel=1e-12)
    assert plan.names == ("", "port_1", "port_2")
    layers = read_outline(saved(tmp_path / "b.dxf", bend, UM), layer="channels", names="layers")
    assert set(layers.names) == {"channels", "port_1", "port_2"}


def test_ports_at_points(tmp_path: Path):
    path = saved(tmp_path / "bend.dxf", bend)
    channel = read_layout(path, 50, layer="channels", ports=[(1200, 800), (0, 90)])
    (first,) = channel.select("port_1")
    assert channel.patches[first].middle().position[1, 0] == pytest.approx(800)
    for ports, words in (
        ([(600, 500)], "no curve of the outline is at the port"),
        ([(0, 90), (0, 110)], "two ports are on the same curve"),
    ):
        with pytest.raises(CadError, match=words):
            read_layout(path, 50, layer="channels", ports=ports)


def test_walls_that_end_at_the_frame_are_closed_there(tmp_path: Path):
    """Two pairs of open lines, all on one layer with the frame: a channel of 6 × 1 and its frame;
    and with a pillar of radius 0.2 in it."""

    def draw(space, _):
        space.add_lwpolyline([(0, 0), (6, 0), (6, 5), (0, 5)], close=True)
        space.add_line((0, 2), (6, 2))
        space.add_line((6, 3), (0, 3))
        space.add_circle((3, 2.5), 0.2)

    channel = read_layout(saved(tmp_path / "open.dxf", draw), height=0.5)
    assert channel.volume() == pytest.approx(0.5 * (6 - 0.04 * pi), rel=1e-9)
    assert area_of(channel, "port_1") == pytest.approx(0.5)
    assert area_of(channel, "port_2") == pytest.approx(0.5)


def test_all_kinds_of_curves_in_mirrored_blocks(tmp_path: Path):
    """An ellipse's half (semi-axes 2 and 1) on a rectangle 4 × 1, closed by a parabola as a spline
    (6 high at most 1.5: 2/3 · 4 · 1.5), drawn in a block and inserted mirrored, turned and three
    times as large."""

    def draw(space, document):
        block = document.blocks.new("part")
        block.add_line((-2, 0), (-2, 1))
        block.add_line((2, 1), (2, 0))
        block.add_ellipse((0, 1), major_axis=(2, 0), ratio=0.5, start_param=0, end_param=pi)
        spline = block.add_open_spline([(-2, 0), (0, -3), (2, 0)], degree=2)
        assert spline.dxf.degree == 2
        space.add_blockref("part", (7, 8), dxfattribs={"xscale": -3, "yscale": 3, "rotation": 30})

    plan = read_outline(saved(tmp_path / "block.dxf", draw))
    assert plan.volume() == pytest.approx(9 * (4 + pi + 4), rel=1e-9)
    low, high = plan.bounds()
    assert 0.5 * (low + high)[1] < 9


def test_arcs_with_a_mirrored_extrusion(tmp_path: Path):
    """Programs mirror by a direction of extrusion (0, 0, -1): arcs then run the other way round. A
    half disc of radius 2 about (-5, 1)."""

    def draw(space, _):
        space.add_arc((5, 1), 2, 0, 180, dxfattribs={"extrusion": (0, 0, -1)})
        space.add_line((-7, 1), (-3, 1))

    plan = read_outline(saved(tmp_path / "half.dxf", draw))
    assert plan.volume() == pytest.approx(2 * pi, rel=1e-12)
    assert plan.bounds().mean(axis=0) == pytest.approx([-5, 2], abs=0.3)


def test_what_drawings_leave_open(tmp_path: Path):
    """No unit, no layer, unknown layers, crossing shapes, hatches, and files that are none."""

    def crossing(space, _):
        space.add_lwpolyline([(0, 0), (3, 0), (3, 1), (0, 1)], close=True)
        space.add_circle((3, 0.5), 0.3)

    def square(space, _):
        space.add_lwpolyline([(0, 0), (3, 0), (3, 1), (0, 1)], close=True)
        space.add_hatch()

    with pytest.raises(CadError, match=r"curves cross at \[3, 0\.[28]\d*\]"):
        read_outline(saved(tmp_path / "crossing.dxf", crossing))
    with pytest.warns(CadWarning, match="1 HATCH"):
        read_outline(saved(tmp_path / "square.dxf", square))
    with pytest.warns(CadWarning, match="no unit of length is given, mm is assumed"):
        read_outline(saved(tmp_path / "unitless.dxf", lambda space, d: space.add_circle((0, 0), 1),
                           units=0))  # fmt: skip
    path = saved(tmp_path / "bend.dxf", bend)
    for options, words in (
        ({}, r"layers are 'channels' with 8 curves, 'chip' with 4 curves; choose one"),
        ({"layer": "walls"}, "no layer 'walls'"),
    ):
        with pytest.raises(CadError, match=words):
            read_layout(path, 1.0, **options)
    with pytest.raises(InputError, match="height"):
        read_layout(path, 0, layer="channels")
    with pytest.raises(CadError, match="leave out point and normal"):
        read_outline(path, normal=(0, 0, 1), layer="channels")
    (tmp_path / "none.dxf").write_text("nothing")
    with pytest.raises(CadError, match="cannot be read as DXF"):
        read_outline(tmp_path / "none.dxf")
    with pytest.raises(CadError, match="no such file"):
        read_layout(tmp_path / "missing.dxf", 1.0)
    with pytest.raises(CadError, match="not a drawing"):
        read_layout(Path(__file__), 1.0)


def written(path: Path, *polygons) -> Path:
    library = gdstk.Library(unit=1e-6, precision=1e-9)
    library.new_cell("chip").add(*polygons)
    library.write_gds(path)
    return path


def test_polygons_of_gds_are_united(tmp_path: Path):
    """A cross of two rectangles 100 × 20 on layer 3, less a square hole of 4; the frame on layer
    7."""
    hole = gdstk.boolean(
        gdstk.rectangle((0, -10), (100, 10)), gdstk.rectangle((48, -2), (52, 2)), "not", layer=3
    )
    path = written(
        tmp_path / "cross.gds", *hole, gdstk.rectangle((40, -50), (60, -5), layer=3),
        gdstk.rectangle((40, 5), (60, 50), layer=3), gdstk.rectangle((0, -50), (100, 50), layer=7),
    )  # fmt: skip
    channel = read_layout(path, 10, layer=3)
    assert channel.unit == "um"
    assert channel.volume() == pytest.approx(10 * (2000 + 2 * 800 - 16), rel=1e-9)
    assert set(channel.names) == {"", "port_1", "port_2", "port_3", "port_4"}
    assert read_outline(path, layer="3/0").volume() == pytest.approx(3584, rel=1e-9)


def test_rounded_shapes_of_gds_become_arcs(tmp_path: Path):
    """A disc of radius 40 and a track of width 20 that turns by a right angle at radius 50: their
    polygons have corners on circles up to the grid of 1 nm."""
    disc = gdstk.ellipse((0, 0), 40, tolerance=1e-2)
    with pytest.warns(CadWarning, match="1 arcs of circles"):
        plan = read_outline(written(tmp_path / "disc.gds", disc))
    assert plan.volume() == pytest.approx(1600 * pi, rel=1e-4)
    assert len(plan.patches) == 4
    track = gdstk.FlexPath([(0, 0), (200, 0), (200, 300)], 20, bend_radius=50, tolerance=1e-2)
    with pytest.warns(CadWarning, match="2 arcs of circles"):
        plan = read_outline(written(tmp_path / "track.gds", track))
    assert plan.volume() == pytest.approx(20 * (150 + 250 + 25 * pi), rel=1e-4)
    assert len(plan.patches) == 8


def test_a_mirrored_cell_of_gds(tmp_path: Path):
    """A triangle of legs 30 and 10, mirrored and turned."""
    library = gdstk.Library()
    part = library.new_cell("part")
    part.add(gdstk.Polygon([(0, 0), (30, 0), (0, 10)]))
    library.new_cell("top").add(gdstk.Reference(part, (5, 5), rotation=pi / 2, x_reflection=True))
    library.write_gds(tmp_path / "mirrored.gds")
    plan = read_outline(tmp_path / "mirrored.gds")
    assert plan.volume() == pytest.approx(150, rel=1e-9)
    assert plan.area() == pytest.approx(40 + sqrt(1000), rel=1e-9)
    assert plan.bounds() == pytest.approx(np.array([[5, 5], [15, 35]]))
