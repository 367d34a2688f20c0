"""The drawings in geometries/: files, names and sizes, against closed forms derived here.

Plan areas are sums of rectangles and trapezia; a channel of constant height h over a plan of area
A and perimeter P has volume A h and area 2 A + P h. A channel of cross-section S swept along a
centreline of length L through its centroid has volume S L (Pappus).
"""

import os
import re
import subprocess
import sys
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, replace
from math import asin, pi, sqrt
from pathlib import Path
from types import ModuleType

import gmsh
import numpy as np
import pytest
from scipy.integrate import quad
from scipy.interpolate import BSpline

from cadbem.cad import read_cad, read_layout, write_cad
from cadbem.errors import CadError

ROOT = Path(__file__).parents[1]
FOLDER = ROOT / "geometries"
CHIPS = FOLDER / "chips"


@dataclass(frozen=True)
class Expected:
    """Number of faces of each name, volume, area of each name."""

    faces: dict[str, int]
    volume: float
    areas: dict[str, float]


def half_width() -> BSpline:
    """The wall of the constriction, from the numbers in its script's docstring."""
    knots = [-4] * 3 + list(range(-4, 5)) + [4] * 3
    return BSpline(knots, [1, 1, 1, 0.7, 0.4, 0.4, 0.4, 0.7, 1, 1, 1], 3)


def wall_length() -> float:
    """Length of one constricting wall: Gauss-Kronrod over each span of the spline."""
    slope = half_width().derivative()
    return sum(quad(lambda x: sqrt(1 + slope(x) ** 2), k, k + 1, epsabs=1e-13)[0]
               for k in range(-4, 4))  # fmt: skip


# y_junction: half of the plan is a trapezium 4 wide with sides 6 and 10 - 2 sqrt(2) (branch A) and
# one 2 wide with sides 8 and 8 + 4 sqrt(2) - 2 (outlet): 32 - 4 sqrt(2) + 14 + 4 sqrt(2) = 46.
CASES = {
    "square_channel": Expected(
        {"inlet": 1, "outlet": 1, "walls": 4}, 2, {"inlet": 1, "outlet": 1, "walls": 8}
    ),
    "y_junction": Expected(
        {"inlet_a": 1, "inlet_b": 1, "outlet": 2, "walls": 14},
        4 * 2 * 46,
        {"inlet_a": 16, "inlet_b": 16, "outlet": 16,
         "walls": 4 * 46 + 2 * 4 * (6 + 10 - 2 * sqrt(2) + 8)},
    ),
    "parallel_plates": Expected(
        {"top": 1, "bottom": 1, "sides": 4}, 24 * 24 * 2,
        {"top": 24**2, "bottom": 24**2, "sides": 4 * 48},
    ),
    "t_junction": Expected(
        {"inlet_a": 1, "inlet_b": 1, "outlet": 1, "walls": 15},
        6 + 2.5,
        {"inlet_a": 1, "inlet_b": 1, "outlet": 1, "walls": 2 * 8.5 + 6 + 5 + 2 * 2.5},
    ),
    "flow_focusing": Expected(
        {"inlet": 1, "side_a": 1, "side_b": 1, "outlet": 1, "walls": 30},
        2.5 + 1 + 5 + 0.375 + 0.25 + 1 + 3.75,
        {"inlet": 1, "side_a": 1, "side_b": 1, "outlet": 1.5,
         "walls": 2 * (13.875 + 2.5 + 5 + sqrt(0.5**2 + 0.25**2) + 0.5 + sqrt(1.25) + 2.5)},
    ),
    "round_pipe": Expected(
        {"inlet": 5, "outlet": 5, "walls": 4}, 6 * pi,
        {"inlet": pi, "outlet": pi, "walls": 12 * pi},
    ),
    "bent_pipe": Expected(
        {"inlet": 5, "outlet": 5, "walls": 12}, pi * (4 + 1.5 * pi),
        {"inlet": pi, "outlet": pi, "walls": 2 * pi * (4 + 1.5 * pi)},
    ),
    "serpentine": Expected(
        {"inlet": 1, "outlet": 1, "walls": 40}, 16 + 3 * pi,
        {"inlet": 1, "outlet": 1, "walls": 4 * (16 + 3 * pi)},
    ),
    "constriction": Expected(
        {"inlet": 1, "outlet": 1, "walls": 4}, 11.2,
        {"inlet": 2, "outlet": 2, "walls": 2 * 11.2 + 2 * wall_length()},
    ),
}  # fmt: skip
FILES = [f"{name}{suffix}" for name in CASES for suffix in (".step", ".igs")]


@pytest.fixture
def model() -> Iterator[ModuleType]:
    """gmsh with an empty model, silent, that opens IGES as solids."""
    gmsh.initialize(interruptible=False, readConfigFiles=False)
    gmsh.option.setNumber("General.Terminal", 0)
    yield gmsh
    gmsh.finalize()


def face_names(path: Path) -> Counter[str]:
    """Names of the faces in the text of a file, with how often they occur."""
    text = path.read_text(encoding="ascii")
    if path.suffix == ".step":
        return Counter(re.findall(r"ADVANCED_FACE\('([^']*)'", text))
    directory = [line for line in text.splitlines() if line[72] == "D"]
    second_lines = [line for line in directory if line[:8] == "     144"][1::2]
    return Counter(line[56:64].strip() for line in second_lines)


def opened(path: Path) -> None:
    gmsh.clear()
    for option in ("OCCSewFaces", "OCCMakeSolids"):  # IGES has no solids, but faces on their own
        gmsh.option.setNumber(f"Geometry.{option}", float(path.suffix == ".igs"))
    gmsh.open(str(path))


def corner_box() -> np.ndarray:
    corners = [gmsh.model.getValue(0, tag, []) for _, tag in gmsh.model.getEntities(0)]
    return np.array([np.min(corners, axis=0), np.max(corners, axis=0)])


def box(model: ModuleType) -> dict[str, int]:
    """A unit cube in the current model, and the tags of its sides by their outward directions."""
    solid = model.model.occ.addBox(0, 0, 0, 1, 1, 1)
    model.model.occ.synchronize()
    sides = {}
    for _, tag in model.model.getBoundary([(3, solid)], oriented=False):
        offset = np.array(model.model.occ.getCenterOfMass(2, tag)) - 0.5
        axis = int(np.argmax(np.abs(offset)))
        sides["xyz"[axis] + ("+" if offset[axis] > 0 else "-")] = tag
    return sides


def test_constriction_volume() -> None:
    """The closed form 11.2 = 2 sum c_i (t_i+4 - t_i)/4 against exact integration; throat 0.8."""
    assert 2 * half_width().integrate(-4, 4) == pytest.approx(11.2, rel=1e-14)
    assert half_width()([-4, 0, 4]) == pytest.approx([1, 0.4, 1], rel=1e-14)


def test_every_drawing_is_tested() -> None:
    scripts = {path.stem for path in FOLDER.glob("*.py")} - {"authoring"}
    assert scripts == set(CASES)


@pytest.mark.parametrize("name", CASES)
def test_redrawing_gives_the_committed_files(
    name: str, tmp_path: Path, model: ModuleType
) -> None:
    """Same bytes; with another OpenCASCADE, which may write otherwise, same names and box."""
    subprocess.run(
        [sys.executable, FOLDER / f"{name}.py", tmp_path],
        check=True, env={**os.environ, "PYTHONPATH": str(ROOT)},
    )  # fmt: skip
    for suffix in (".step", ".igs"):
        committed, redrawn = FOLDER / f"{name}{suffix}", tmp_path / f"{name}{suffix}"
        if committed.read_bytes() == redrawn.read_bytes():
            continue
        assert face_names(redrawn) == face_names(committed)
        opened(committed)
        expected_box = corner_box()
        opened(redrawn)
        np.testing.assert_allclose(corner_box(), expected_box, rtol=0, atol=1e-12)


@pytest.mark.parametrize("file", FILES)
def test_faces_and_volume(file: str, model: ModuleType) -> None:
    """One solid with the faces drawn, each with four edges and shared with a neighbour.

    gmsh's volume is exact for all but the constriction (see the test through `read_cad`);
    IGES texts hold ten digits.
    """
    expected = CASES[Path(file).stem]
    assert face_names(FOLDER / file) == expected.faces
    opened(FOLDER / file)
    [solid] = model.model.getEntities(3)
    faces = model.model.getBoundary([solid], oriented=False)
    assert len(faces) == len(model.model.getEntities(2)) == sum(expected.faces.values())
    edges = Counter(
        edge for face in faces for edge in model.model.getBoundary([face], oriented=False)
    )
    assert len(edges) == 2 * len(faces) and set(edges.values()) == {2}
    if not file.startswith("constriction"):
        tolerance = 1e-12 if file.endswith(".step") else 1e-9
        volume = model.model.occ.getMass(*solid)
        assert volume == pytest.approx(expected.volume, rel=tolerance)


@pytest.mark.parametrize("file", FILES)
def test_read_back(file: str) -> None:
    """Volume, and the area of each name, as the closed forms say; each face is one patch.

    STEP holds all digits of corners and 13 of curved surfaces, IGES ten digits.
    """
    expected = CASES[Path(file).stem]
    boundary = read_cad(FOLDER / file)
    tolerance = 1e-10 if file.endswith(".step") else 1e-7
    assert Counter(patch.name for patch in boundary.patches) == expected.faces
    assert boundary.unit == "mm"
    assert boundary.volume() == pytest.approx(expected.volume, rel=tolerance)
    for name, area in expected.areas.items():
        patches = tuple(boundary.patches[index] for index in boundary.select(name))
        assert replace(boundary, patches=patches).area() == pytest.approx(area, rel=tolerance)


def test_y_junction_is_mirror_symmetric(model: ModuleType) -> None:
    """Corners in the STEP file and their mirror images about y = 5 sqrt(2): a rounding apart."""
    opened(FOLDER / "y_junction.step")
    corners = np.array([gmsh.model.getValue(0, tag, []) for _, tag in gmsh.model.getEntities(0)])
    mirrored = corners * [1, -1, 1] + [0, 10 * sqrt(2), 0]
    gaps = np.abs(corners[:, None] - mirrored).max(axis=2).min(axis=1)
    assert len(corners) == 20 and gaps.max() <= 2e-15


def test_names_go_to_the_right_faces(model: ModuleType, tmp_path: Path) -> None:
    """The sides of a cube, named by their directions: every corner of a side's text agrees."""
    sides = box(model)
    write_cad(tmp_path / "cube.step", {tag: side for side, tag in sides.items()})
    text = (tmp_path / "cube.step").read_text()
    records = dict(re.findall(r"#(\d+) = (.*?);\n", text, re.DOTALL))
    for side in sides:
        [face] = [body for body in records.values() if f"ADVANCED_FACE('{side}'" in body]
        plane = records[re.findall(r"#(\d+)", face)[-1]]
        placement = records[re.findall(r"#(\d+)", plane)[0]]
        origin, normal = (records[n] for n in re.findall(r"#(\d+)", placement)[:2])
        axis = "xyz".index(side[0])
        assert float(re.findall(r"[-\d.]+", normal)[axis]) in (1, -1)
        assert float(re.findall(r"[-\d.]+", origin)[axis]) == (side[1] == "+")


def test_writing_twice_gives_the_same_bytes(model: ModuleType, tmp_path: Path) -> None:
    """OpenCASCADE counts the files that it writes, and stamps them: neither may show."""
    names = {tag: "side" for tag in box(model).values()}
    for suffix in (".stp", ".iges"):
        for folder in ("first", "second"):
            (tmp_path / folder).mkdir(exist_ok=True)
            write_cad(tmp_path / folder / f"cube{suffix}", names)
        first, second = (tmp_path / folder / f"cube{suffix}" for folder in ("first", "second"))
        assert first.read_bytes() == second.read_bytes()
        assert str(tmp_path) not in first.read_text()


@pytest.mark.parametrize("suffix", [".step", ".igs"])
def test_any_file_name(model: ModuleType, tmp_path: Path, suffix: str) -> None:
    """Quotes, commas and letters beyond ASCII in the file's name do not spoil the text."""
    path = tmp_path / f"it's a, naïve; cube{suffix}"
    write_cad(path, {tag: "side" for tag in box(model).values()})
    opened(path)
    assert len(model.model.getEntities(3)) == 1 and len(model.model.getEntities(2)) == 6


@pytest.mark.parametrize(
    ("file", "name", "message"),
    [
        ("cube.brep", "inlet", "cube.brep: unknown extension"),
        ("cube.igs", "left_inlet", "'left_inlet' is longer than IGES's 8 characters"),
        ("cube.step", "it's", "use letters, digits"),
        ("cube.step", "", "use letters, digits"),
    ],
)
def test_what_cannot_be_written(
    model: ModuleType, tmp_path: Path, file: str, name: str, message: str
) -> None:
    sides = box(model)
    with pytest.raises(CadError, match=re.escape(message)):
        write_cad(tmp_path / file, {sides["x-"]: name})
    assert not (tmp_path / file).exists()


def test_unknown_tag_and_empty_model(model: ModuleType, tmp_path: Path) -> None:
    with pytest.raises(CadError, match="the gmsh model has no faces"):
        write_cad(tmp_path / "cube.step", {})
    box(model)
    with pytest.raises(CadError, match="no surface 7 in the gmsh model"):
        write_cad(tmp_path / "cube.step", {7: "inlet"})


def test_faces_with_the_same_corners(model: ModuleType, tmp_path: Path) -> None:
    """Half a ball, whose faces all run from pole to pole: one name for all is fine, two are not."""
    occ = model.model.occ
    right, left, centre = (occ.addPoint(x, 0, 0) for x in (1, -1, 0))
    meridian, axis = occ.addCircleArc(right, centre, left), occ.addLine(left, right)
    occ.remove([(0, centre)])
    half_disk = occ.addPlaneSurface([occ.addCurveLoop([meridian, axis])])
    occ.revolve([(2, half_disk)], 0, 0, 0, 1, 0, 0, pi)
    occ.synchronize()
    tags = [tag for _, tag in model.model.getEntities(2)]
    for suffix in (".step", ".igs"):
        write_cad(tmp_path / f"half{suffix}", {tag: "side" for tag in tags})
        assert face_names(tmp_path / f"half{suffix}") == {"side": len(tags)}
        with pytest.raises(CadError, match="same corners; split it"):
            write_cad(tmp_path / f"half{suffix}", {tags[0]: "one"})


# The groove begins at a well's axis, 0.6 wide: |y| < 0.3, 0 < x < (1/4 - y²)^½ is what they share,
# 0.3 · 0.4 + 0.25 asin(0.6) in plan.
SHARED = 0.4 * (0.12 + 0.25 * asin(0.6))


@pytest.mark.parametrize(
    ("name", "options", "volume", "names"),
    [
        ("pdms_block", {"between": ("mouth 1", "mouth 2")}, 0.96 + pi - 2 * SHARED, "mouth_{}"),
        ("luer", {"between": ((0, 0, 0), (0, 0, 11))},
         2 * pi * (4 + 2 * 1.64 + 1.64**2) + 1.25 * pi, "mouth_{}"),
        ("manifold", {"fluid": "void"}, 0.64 * 8 + 0.09 * pi * 4.2, "port_{}"),
    ],
)  # fmt: skip
def test_rooms_in_chips(name: str, options: dict, volume: float, names: str) -> None:
    """Groove and wells, less what they share; a cone and a bore; a bore and its branches."""
    room = read_cad(CHIPS / f"{name}.step", **options).named(rest="walls")
    assert room.volume() == pytest.approx(volume, rel=1e-8)
    count = 4 if name == "manifold" else 2
    assert room.names == (*(names.format(k) for k in range(1, count + 1)), "walls")


def test_the_mixer(tmp_path: Path) -> None:
    """Inlets 100 × 1000, lines of 250, 250 and twice 150, two quarters of a turn at radius 150 and
    half a turn at 100: by Pappus the centreline times 100, and 50 high."""
    centreline = 250 + 250 + pi * 150 + pi * 100 + 2 * 150
    channel = read_layout(CHIPS / "mixer.dxf", height=50, layer="channels")
    assert channel.volume() == pytest.approx(5000 * (1000 + centreline), rel=1e-9)
    assert set(channel.names) == {"", "port_1", "port_2", "port_3"}


def test_chips_are_drawn_by_their_script(tmp_path: Path) -> None:
    subprocess.run([sys.executable, CHIPS / "draw.py", tmp_path], check=True)
    for name in ("pdms_block.step", "luer.step", "manifold.step"):
        written, kept = (read_cad(place / name, fluid="void") for place in (tmp_path, CHIPS))
        assert written.volume() == pytest.approx(kept.volume(), rel=1e-12)
