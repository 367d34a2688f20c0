"""Models that are sewn or healed because they need it, and only then; defects that stay."""

from pathlib import Path

import gmsh
import numpy as np
import pytest
from drawn import exported

from cadbem.cad import read_cad
from cadbem.cad.body.model import CadModel, open_model
from cadbem.cad.body.orientation import enclosed
from cadbem.errors import CadError, CadWarning

occ = gmsh.model.occ
CORNERS = [(0, 0, 0), (1, 0, 0), (1, 2, 0), (0, 2, 0), (0, 0, 3), (1, 0, 3), (1, 2, 3), (0, 2, 3)]


def opened(path: Path) -> CadModel:
    return open_model(path, 60.0)


def polyhedron(corners: list[tuple], faces: list[list[int]]) -> None:
    """A solid with plane faces; neighbours share their edges."""
    points = [occ.addPoint(*corner) for corner in corners]
    lines: dict[tuple[int, int], int] = {}

    def line(start: int, end: int) -> int:
        if (end, start) in lines:
            return -lines[end, start]
        return lines.setdefault((start, end), occ.addLine(points[start], points[end]))

    def plane(loop: list[int]) -> int:
        edges = [line(a, b) for a, b in zip(loop, loop[1:] + loop[:1], strict=True)]
        return occ.addPlaneSurface([occ.addCurveLoop(edges)])

    occ.addVolume([occ.addSurfaceLoop([plane(loop) for loop in faces])])


def box_with_short_edge(length: float) -> None:
    """1 × 2 × 3; the edge x = 1, z = 3 has a corner `length` before its end: 6 faces, 13 edges."""
    faces = [
        [3, 2, 1, 0],
        [4, 5, 8, 6, 7],
        [0, 1, 5, 4],
        [1, 2, 6, 8, 5],
        [2, 3, 7, 6],
        [3, 0, 4, 7],
    ]
    polyhedron([*CORNERS, (1, 2 - length, 3)], faces)


def box_with_sliver(width: float) -> None:
    """1 × 2 × 3; a strip of `width` of the side x = 1 is a face of its own: 7 faces, 15 edges."""
    faces = [[3, 2, 9, 1, 0], [4, 5, 8, 6, 7], [0, 1, 5, 4], [1, 9, 8, 5], [9, 2, 6, 8],
             [2, 3, 7, 6], [3, 0, 4, 7]]  # fmt: skip
    polyhedron([*CORNERS, (1, 2 - width, 3), (1, 2 - width, 0)], faces)


@pytest.mark.parametrize("author", [box_with_short_edge, box_with_sliver])
@pytest.mark.parametrize("suffix", [".step", ".igs"])
def test_what_is_too_small_is_removed_with_a_warning(folder: Path, author, suffix: str):
    """5e-7 is less than 1e-6 of the size 3: twelve edges and six faces of a box stay, and its
    volume up to a layer of 5e-7 on its surface of 22."""
    author(5e-7)
    path = exported(folder / f"small{suffix}")
    with pytest.warns(CadWarning, match=r"healed: .* (1[35]) edges became 12\)"):
        boundary = read_cad(path)
    assert len(boundary.patches) == 6
    assert boundary.volume() == pytest.approx(6, abs=22 * 5e-7)


@pytest.mark.parametrize(("author", "faces"), [(box_with_short_edge, 6), (box_with_sliver, 7)])
def test_what_is_large_enough_is_left_alone(folder: Path, author, faces: int):
    """1e-3 of an edge may be meant: all faces and corners stay as they are."""
    author(1e-3)
    model = opened(exported(folder / "fine.step"))
    assert len(model.faces) == faces
    assert model.kernel.healed == ()
    assert model.warnings == ()
    ends = np.concatenate([use.ends for f in model.faces for loop in f.loops for use in loop])
    assert any(np.array_equal(end, [1, 2 - 1e-3, 3]) for end in ends)
    assert enclosed(model.faces) == pytest.approx(6, rel=1e-12)


def test_poles_are_no_mistakes(folder: Path):
    """The ends of a sphere's seam are edges of no length, rightly so."""
    occ.addSphere(0, 0, 0, 1)
    assert opened(exported(folder / "ball.step")).kernel.healed == ()


def loose_box(gap: float) -> None:
    """Six faces of 1 × 2 × 3, each with corners of its own; that at z = 3 is `gap` away."""
    for x, turn in ((0, 0), (1, 0)):
        tag = occ.addRectangle(0, 0, 0, 3, 2)
        occ.rotate([(2, tag)], 0, 0, 0, 0, 1, 0, -np.pi / 2)
        occ.translate([(2, tag)], x, turn, 0)
    for y in (0, 2):
        tag = occ.addRectangle(0, 0, 0, 1, 3)
        occ.rotate([(2, tag)], 0, 0, 0, 1, 0, 0, np.pi / 2)
        occ.translate([(2, tag)], 0, y, 0)
    for z in (0, 3 + gap):
        occ.addRectangle(0, 0, z, 1, 2)


@pytest.mark.parametrize("gap", [0.0, 3e-7])
def test_separate_faces_are_sewn(folder: Path, gap: float):
    """Gaps of up to 1e-6 of the size; the height is 3 or 3 + gap. What is more than rounding is
    said."""
    loose_box(gap)
    model = opened(exported(folder / "loose.igs"))
    assert model.kernel.sewn
    assert model.obstacles() == []
    assert enclosed(model.faces) == pytest.approx(6 + gap, abs=2 * gap + 1e-8)
    assert ("sewn" in " ".join(model.warnings)) == (gap == 3e-7)


def test_faces_too_far_apart_are_located(folder: Path):
    """A lid 1e-3 above the box: its four edges are alone, and so are those of the four sides."""
    loose_box(1e-3)
    model = opened(exported(folder / "loose.igs"))
    (problem,) = model.obstacles()
    assert "8 edges belong to one face only" in problem
    defects = model.defective_faces()
    lid = max(model.faces, key=lambda face: model.centre(face)[2])
    floor = min(model.faces, key=lambda face: model.centre(face)[2])
    assert len(defects) == 5
    assert lid.number in defects
    assert floor.number not in defects
    assert "belongs to this face only" in defects[lid.number]


def test_a_lasting_opening_is_that_of_the_file(folder: Path):
    """A box without its lid, from separate faces: four edges are open, eight are joined."""
    loose_box(0.0)
    occ.remove([(2, 6)])
    with pytest.raises(CadError, match=r"4 edges belong to one face only, the first at \[.*, 3\]"):
        read_cad(exported(folder / "tub.igs"))


def test_sound_models_have_no_defective_faces(folder: Path):
    occ.addBox(0, 0, 0, 1, 2, 3)
    assert opened(exported(folder / "box.step")).defective_faces() == {}


def test_faces_at_an_edge_of_three_are_named(folder: Path):
    """Cubes that touch in an edge: the two faces of each that meet there."""
    occ.addBox(0, 0, 0, 1, 1, 1)
    occ.addBox(1, 1, 0, 1, 1, 1)
    model = open_model(exported(folder / "cubes.step"), 60.0, fluid="all")
    defects = model.defective_faces()
    assert len(defects) == 4
    assert set(defects.values()) == {"the edge at [1, 1, 0.5] mm belongs to more than two faces"}


def lifted_lid(gap: float) -> None:
    """The six faces of 4 × 2 × 1, the upper one lifted by a gap."""
    corners = ((0, 0), (4, 0), (4, 2), (0, 2))
    sides = [(a, b) for a, b in zip(corners, corners[1:] + corners[:1], strict=True)]
    faces = [[(*c, 0) for c in corners], [(*c, 1 + gap) for c in corners]]
    faces += [[(*a, 0), (*b, 0), (*b, 1), (*a, 1)] for a, b in sides]
    for points in faces:
        tags = [occ.addPoint(*point) for point in points]
        lines = [occ.addLine(tags[k - 1], tags[k]) for k in range(4)]
        occ.addPlaneSurface([occ.addCurveLoop(lines)])


@pytest.mark.parametrize("suffix", [".step", ".igs"])
def test_wider_gaps_are_sewn_on_request(folder: Path, suffix: str):
    """A gap of 4e-4, which is 1e-4 of the size: sewn, V is between 8 and 8 + 8 · 4e-4."""
    lifted_lid(4e-4)
    path = exported(folder / f"lid{suffix}")
    with pytest.raises(CadError, match=r"up to 0.0004 mm \(0.0001 of the size\) apart.*sew=0.0002"):
        read_cad(path)
    with pytest.warns(CadWarning, match="results are no more exact than that"):
        boundary = read_cad(path, sew=2e-4)
    assert 8 <= boundary.volume() <= 8.0032
    with pytest.raises(CadError, match="sew=0.1: give a gap per size of the model"):
        read_cad(path, sew=0.1)


@pytest.mark.parametrize("suffix", [".step", ".igs"])
def test_small_features_of_parts_far_apart_stay(folder: Path, suffix: str):
    """A cube with a bevel of 0.01, and another one 1e5 away: V = 1 - 0.01² / 2."""
    points = [occ.addPoint(x, y, 0) for x, y in ((0, 0), (1, 0), (1, 1), (0.01, 1), (0, 0.99))]
    lines = [occ.addLine(points[k - 1], points[k]) for k in range(5)]
    occ.extrude([(2, occ.addPlaneSurface([occ.addCurveLoop(lines)]))], 0, 0, 1)
    occ.addBox(1e5, 0, 0, 1, 1, 1)
    boundary = read_cad(exported(folder / f"far{suffix}"), fluid=1)
    assert boundary.volume() == pytest.approx(1 - 5e-5, rel=1e-7)
