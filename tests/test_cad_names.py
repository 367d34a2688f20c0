"""Names, layers and colours of faces.

The box of these tests is that of `named_box.py`.
"""

from dataclasses import replace
from pathlib import Path

import gmsh
import numpy as np
import pytest
from named_box import SIZES, middle_of, named_box, with_lines

from cadbem.boundary import Boundary
from cadbem.cad import inspect_cad, read_cad, write_cad
from cadbem.cad.body.model import open_model
from cadbem.cad.labels.face_labels import FaceLabel, match_labels
from cadbem.cad.text.unit import Unit
from cadbem.cli import main
from cadbem.errors import CadError

occ = gmsh.model.occ


def middles(boundary: Boundary) -> dict[str, list[tuple[float, ...]]]:
    """Middles of the faces of each name, sorted."""
    return {
        name: sorted(
            tuple(np.round(boundary.patches[i].middle().position[:, 0], 9).tolist())
            for i in boundary.select(name)
        )
        for name in boundary.names
    }


def at(*faces: str) -> list[tuple[float, ...]]:
    return sorted(tuple(middle_of(face).tolist()) for face in faces)


def test_layers_of_faces_and_solids_in_step(folder: Path):
    """The solid's layer is that of all faces which are not on one of their own."""
    path = with_lines(
        named_box(folder / "box.step"),
        "#9001=PRESENTATION_LAYER_ASSIGNMENT('in','the one face',({x0}));\n"
        "#9002=PRESENTATION_LAYER_ASSIGNMENT('wall''s','',({solid}));\n"
        "#9003=PRESENTATION_LAYER_ASSIGNMENT('both','',({y0},{y2}));\n",
    )
    assert middles(read_cad(path, names="layers")) == {
        "in": at("x0"),
        "both": at("y0", "y2"),
        "wall's": at("x1", "z0", "z3"),
    }
    assert middles(read_cad(path)) == {name: at(name) for name in
                                       ("x0", "x1", "y0", "y2", "z0", "z3")}  # fmt: skip


STYLE = (
    "#{0}=PRESENTATION_STYLE_ASSIGNMENT((#{0}1));\n#{0}1=SURFACE_STYLE_USAGE(.BOTH.,#{0}2);\n"
    "#{0}2=SURFACE_SIDE_STYLE('',(#{0}3));\n#{0}3=SURFACE_STYLE_FILL_AREA(#{0}4);\n"
    "#{0}4=FILL_AREA_STYLE('',(#{0}5));\n#{0}5=FILL_AREA_STYLE_COLOUR('',#{0}6);\n#{0}6={1};\n"
)


def test_colours_of_faces_and_solids_in_step(folder: Path):
    """Shares 0.2, 0.4, 0.6 of 255 are 51, 102, 153, in hexadecimal 33, 66, 99. A face's colour goes
    before the shell's, whichever comes first in the file, and an overriding one before both."""
    styles = [(901, "COLOUR_RGB('',0.2,0.4,0.6)"), (902, "DRAUGHTING_PRE_DEFINED_COLOUR('red')"),
              (903, "COLOUR_RGB('',1.,1.,0.)"), (904, "DRAUGHTING_PRE_DEFINED_COLOUR('cyan')"),
              (905, "DRAUGHTING_PRE_DEFINED_COLOUR('something')")]  # fmt: skip
    path = with_lines(
        named_box(folder / "box.step"),
        "#9001=STYLED_ITEM('',(#902),{x0});\n#9002=OVER_RIDING_STYLED_ITEM('',(#904),{x1},#9004);\n"
        "#9003=STYLED_ITEM('',(#903),{x1});\n#9004=STYLED_ITEM('',(#901),{shell});\n"
        "#9005=STYLED_ITEM('',(#905),{y0});\n" + "".join(STYLE.format(*style) for style in styles),
    )
    assert middles(read_cad(path, names="colours")) == {
        "#ff0000": at("x0"),
        "#00ffff": at("x1"),
        "#336699": at("y0", "y2", "z0", "z3"),
    }


def iges_with(path: Path, levels: dict[str, int], colours: dict[str, int]) -> Path:
    """The IGES file with levels (field 5) and colours (field 13) in the directory, by face name."""
    lines = path.read_text().splitlines()
    for index, line in enumerate(lines):
        if line[72:73] == "D" and int(line[73:80]) % 2 == 0 and line[:8] == "     144":
            name = line[56:64].strip()
            lines[index] = f"{line[:16]}{colours.get(name, 0):8}{line[24:]}"
            above = lines[index - 1]
            lines[index - 1] = f"{above[:32]}{levels.get(name, 0):8}{above[40:]}"
    path.write_text("\n".join(lines) + "\n")
    return path


def with_entity(path: Path, kind: int, parameters: str) -> int:
    """Appends an entity to an IGES file; the number that refers to it."""
    lines = path.read_text().splitlines()
    sections = {key: [line for line in lines if line[72:73] == key] for key in "SGDPT"}
    number, row = len(sections["D"]) + 1, len(sections["P"]) + 1
    first = f"{kind:8}{row:8}{0:8}{0:8}{0:8}{0:8}{0:8}{0:8}{'00000200'}"
    second = f"{kind:8}{0:8}{0:8}{1:8}{0:8}{'':16}{'':8}{0:8}"
    sections["D"] += [f"{first}D{number:7}", f"{second}D{number + 1:7}"]
    sections["P"].append(f"{parameters:64}{number:8}P{row:7}")
    counts = "".join(f"{letter}{len(sections[letter]):7}" for letter in "SGDP")
    sections["T"] = [f"{counts:72}T      1"]
    path.write_text("\n".join(line for key in "SGDPT" for line in sections[key]) + "\n")
    return number


def test_levels_and_colours_in_iges(folder: Path):
    """Colour 2 is red, 4 blue; a negative one refers to shares in percent (entity 314): 20, 40, 60
    per cent of 255 are 51, 102, 153. A negative level refers to a list (entity 406, form 1)."""
    path = named_box(folder / "box.igs")
    own = with_entity(path, 314, "314,20.,40.,60.,9Hsome blue;")
    several = with_entity(path, 406, "406,2,7,8;")
    iges_with(path, {"x0": 5, "x1": -several, "y0": 5}, {"x0": 2, "x1": 4, "z0": -own})
    assert middles(read_cad(path, names="layers")) == {
        "5": at("x0", "y0"), "7": at("x1"), "": at("y2", "z0", "z3")
    }  # fmt: skip
    assert middles(read_cad(path, names="colours")) == {
        "#ff0000": at("x0"), "#0000ff": at("x1"), "#336699": at("z0"), "": at("y0", "y2", "z3")
    }  # fmt: skip


def test_the_report_shows_layers_and_colours(folder: Path, capsys: pytest.CaptureFixture[str]):
    path = named_box(folder / "box.step")
    main(["info", str(path)])
    plain = capsys.readouterr().out.splitlines()[0].split()
    assert plain[:3] == ["face", "name", "kind"]
    with_lines(
        path,
        "#9001=PRESENTATION_LAYER_ASSIGNMENT('in','',({x0}));\n"
        "#9002=STYLED_ITEM('',(#901),{x0});" + STYLE.format(901, "COLOUR_RGB('',1.,0.,0.)"),
    )
    faces = {face.name: face for face in inspect_cad(path, names="names").faces}
    assert (faces["x0"].layer, faces["x0"].colour) == ("in", "#ff0000")
    assert (faces["x1"].layer, faces["x1"].colour) == ("", "")
    main(["info", str(path)])
    lines = [line.split()[:4] for line in capsys.readouterr().out.splitlines()[:7]]
    assert lines[0] == ["face", "name", "layer", "colour"]
    assert ["x0", "in", "#ff0000"] in [line[1:] for line in lines]
    assert ["x1", "-", "-"] in [line[1:] for line in lines]


@pytest.mark.parametrize("function", [read_cad, inspect_cad])
def test_names_must_be_a_known_choice(folder: Path, function):
    with pytest.raises(CadError, match="names='colors'.*'names', 'layers' or 'colours'"):
        function(folder / "any.step", names="colors")


def test_labels_that_contradict_each_other_name_no_face(folder: Path):
    """A face that the text has twice under different names could be either; if both say the same,
    there is no doubt."""
    model = open_model(named_box(folder / "box.step"), 60.0)
    labels = list(model.labels.values())
    doubled = [*labels, *(replace(m, name="other") for m in labels if m.name == "x0")]
    found = match_labels(doubled, list(model.faces), Unit("mm", 1.0))
    assert sorted(mark.name for mark in found.values()) == ["x1", "y0", "y2", "z0", "z3"]
    found = match_labels([*labels, *labels], list(model.faces), Unit("mm", 1.0))
    assert len(found) == 6


def test_a_face_is_not_its_neighbour_with_the_same_corners(folder: Path):
    """The square [0, 1]² bulging out by half circles on all sides has the square's corners, but the
    middles of its edges lie half an edge away."""
    model = open_model(named_box(folder / "box.step"), 60.0)
    corners = np.array([[0, 0, 0], [0, 2, 0], [0, 2, 3], [0, 0, 3]])
    straight = np.array([[0, 1, 0], [0, 2, 1.5], [0, 1, 3], [0, 0, 1.5]])
    bulge = np.array([[0, 0, -1], [0, 1, 0], [0, 0, 1], [0, -1, 0]])
    for middles, expected in ((straight, 1), (straight + 1.2 * bulge, 0)):
        found = match_labels(
            [FaceLabel("x0", corners, middles)], list(model.faces), Unit("mm", 1.0)
        )
        assert len(found) == expected


def test_faces_of_a_part_that_was_moved_keep_their_names(folder: Path):
    """In an assembly the text describes a part where it was drawn, the kernel where it is put: here
    turned by 90 degrees about z and shifted."""
    model = open_model(named_box(folder / "box.step"), 60.0)
    put = np.array([[0.0, -1, 0, 10], [1, 0, 0, 20], [0, 0, 1, 30], [0, 0, 0, 1]])
    moved = []
    for face in model.faces:
        loops = tuple(
            tuple(
                replace(use, matrix=put @ use.matrix, ends=use.ends @ put[:3, :3].T + put[:3, 3])
                for use in loop
            )
            for loop in face.loops
        )
        moved.append(replace(face, matrix=put @ face.matrix, loops=loops))
    found = match_labels(list(model.labels.values()), moved, Unit("mm", 1.0))
    assert {n: mark.name for n, mark in found.items()} == model.names


def test_a_face_that_the_kernel_divided_has_no_name(folder: Path):
    """The corners of its parts are not those of the face in the text."""
    model = open_model(named_box(folder / "box.step"), 60.0)
    gmsh.clear()
    occ.addBox(0, 0, 0, *SIZES)
    line = occ.addLine(occ.addPoint(0, 1, 0), occ.addPoint(0, 1, 3))
    occ.fragment([(3, 1)], [(1, line)])
    occ.synchronize()
    gmsh.write(str(folder / "divided.step"))
    divided = open_model(folder / "divided.step", 60.0)
    found = match_labels(list(model.labels.values()), list(divided.faces), Unit("mm", 1.0))
    assert len(divided.faces) == 7
    assert sorted(mark.name for mark in found.values()) == ["x1", "y0", "y2"]


def test_names_of_a_chip_are_those_of_the_channel_in_it(folder: Path):
    """A block [0, 4] × [0, 4] × [0, 2] with a channel 1 × 1 along x: its walls belong to it,
    the ports are not, and have none of its names."""
    block = occ.addBox(0, 0, 0, 4, 4, 2)
    occ.cut([(3, block)], [(3, occ.addBox(0, 1.5, 0.5, 4, 1, 1))])
    occ.synchronize()
    names = {}
    for _, tag in gmsh.model.getEntities(2):
        x, y, z = occ.getCenterOfMass(2, tag)
        inner = abs(x - 2) < 1 and abs(y - 2) < 1 and abs(z - 1) < 0.9
        names[tag] = f"wall_{y:.1f}_{z:.1f}" if inner else "outside"
    path = folder / "chip.step"
    write_cad(path, names)
    walls = {"wall_1.5_1.0", "wall_2.5_1.0", "wall_2.0_0.5", "wall_2.0_1.5"}
    boundary = read_cad(path, fluid="void")
    assert set(boundary.names) - {"port_1", "port_2"} == walls
    assert boundary.volume() == pytest.approx(4, rel=1e-12)
