"""Files that cannot be a boundary: each gives one line that names the file and the remedy."""

import re
import subprocess
import sys
import tempfile
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import gmsh
import pytest
from drawn import exported

from cadbem.cad import inspect_cad, mesh_volume, read_cad
from cadbem.cad.body.model import open_model
from cadbem.errors import CadError, InputError

occ = gmsh.model.occ
GEOMETRIES = Path(__file__).resolve().parents[1] / "geometries"


def box(folder: Path, suffix: str = ".step") -> Path:
    occ.addBox(0, 0, 0, 1, 2, 3)
    return exported(folder / f"box{suffix}")


def missing(folder: Path) -> Path:
    return folder / "nowhere.step"


def directory(folder: Path) -> Path:
    (folder / "parts.step").mkdir()
    return folder / "parts.step"


def written(name: str, content: str) -> Callable[[Path], Path]:
    def author(folder: Path) -> Path:
        (folder / name).write_text(content)
        return folder / name

    return author


def swapped_ending(folder: Path) -> Path:
    return box(folder).rename(folder / "box.igs")


def swapped_ending_back(folder: Path) -> Path:
    return box(folder, ".igs").rename(folder / "box.stp")


def cut_off(suffix: str) -> Callable[[Path], Path]:
    def author(folder: Path) -> Path:
        path = box(folder, suffix)
        path.write_text(path.read_text()[: -path.stat().st_size // 3])
        return path

    return author


def replaced(suffix: str, old: str, new: str) -> Callable[[Path], Path]:
    """A box with the first `old` of the file become `new`."""

    def author(folder: Path) -> Path:
        path = box(folder, suffix)
        text = path.read_text()
        assert old in text
        path.write_text(text.replace(old, new, 1))
        return path

    return author


def wireframe(folder: Path) -> Path:
    occ.addCircle(0, 0, 0, 1)
    return exported(folder / "wire.step")


def no_entities(folder: Path) -> Path:
    path = box(folder)
    head, _, _ = path.read_text().partition("DATA;")
    path.write_text(head + "DATA;\nENDSEC;\nEND-ISO-10303-21;\n")
    return path


def open_shell(folder: Path) -> Path:
    """A box without its top, z = 3."""
    occ.addBox(0, 0, 0, 1, 2, 3)
    occ.remove([(3, 1)])
    occ.remove([(2, 6)])
    return exported(folder / "tub.step")


def two_solids(folder: Path) -> Path:
    occ.addBox(0, 0, 0, 1, 2, 3)
    occ.addBox(5, 0, 0, 2, 2, 2)
    return exported(folder / "two.step")


def tiny(folder: Path) -> Path:
    occ.addBox(0, 0, 0, 3e-5, 2e-5, 3e-5)
    return exported(folder / "tiny.step")


def huge(folder: Path) -> Path:
    occ.addBox(0, 0, 0, 1e9, 1e9, 1e9)
    return exported(folder / "huge.step")


def damaged_reference(folder: Path) -> Path:
    path = box(folder)
    path.write_text(path.read_text().replace("EDGE_LOOP('',(#", "EDGE_LOOP('',(#99", 1))
    return path


CASES = [
    (missing, "no such file"),
    (directory, "directory"),
    (written("empty.stp", ""), "empty"),
    (written("blank.igs", " \n\n"), "empty"),
    (written("letter.step", "Dear all,\nthe file is attached.\n"), "not STEP"),
    (written("letter.iges", "Dear all,\nthe file is attached.\n"), "not IGES"),
    (written("part.stl", "solid part\nendsolid\n"), "'.stl' is a mesh of triangles.*STEP"),
    (written("part.MSH", ""), "'.MSH' is a mesh, .*; take the STEP or IGES file"),
    (written("mask.dxf", ""), "'.dxf' is a plane drawing; read_layout"),
    (written("part.sldprt", ""), "in the format of one program; export it there as STEP"),
    (written("part.brep", "CASCADE Topology V1\nLocations 0\n"), "cut off before its end"),
    (written("part.brp", "ISO-10303-21;"), "the content is STEP, the ending says"),
    (written("part", "ISO-10303-21;"), "unknown ending ''"),
    (swapped_ending, "content is STEP.*rename the file to .step"),
    (swapped_ending_back, "content is IGES.*rename the file to .iges"),
    (cut_off(".step"), "cut off"),
    (cut_off(".igs"), "cut off"),
    (replaced(".step", "(0.,0.,3.)", "(0.,0.,NaN)"), "'NaN' near line .* not a finite number"),
    (replaced(".step", "(0.,0.,3.)", "(0.,-inf,3.)"), "not a finite number"),
    (replaced(".step", "(0.,0.,3.)", "(0.,0.,1.E+400)"), "not a finite number"),
    (replaced(".igs", ",0.,3.,", ",nan,3,"), "not a finite number"),
    (wireframe, "no faces but 1 curve"),
    (no_entities, "no faces"),
    (open_shell, r"4 edges belong to one face only, the first at \[.*, 3\] mm"),
    (two_solids, r"2 solids .*with 6 faces about \[0.5, 1, 1.5\] mm.*\[6, 1, 1\] mm.*fluid=1"),
    (tiny, "3e-05 mm large"),
    (huge, "1e\\+09 mm large"),
]


@pytest.mark.parametrize(("author", "words"), CASES)
def test_one_line_says_what_is_wrong(folder: Path, author: Callable[[Path], Path], words: str):
    path = author(folder)
    with pytest.raises(CadError, match=words) as caught:
        read_cad(path)
    message = str(caught.value)
    assert path.name in message
    assert "\n" not in message
    assert len(message) < 400


def test_faces_that_cannot_become_patches_are_counted(
    folder: Path, monkeypatch: pytest.MonkeyPatch
):
    """The walls of two pipes that cross, of 6 faces, are not done within 1e-14 without halving."""
    monkeypatch.setattr("cadbem.cad.layout.approximate.HALVINGS", 0)
    pipes = [
        (3, occ.addCylinder(-2, 0, 0, 4, 0, 0, 1)),
        (3, occ.addCylinder(0, 0, -2, 0, 0, 4, 0.6)),
    ]
    occ.cut(pipes[:1], pipes[1:])
    path = exported(folder / "pipes.step")
    words = r"pipes.step: face \d \(cylinder, .*tolerance 1e-14; .* \(1 more faces cannot, either\)"
    with pytest.raises(CadError, match=words) as caught:
        read_cad(path, tolerance=1e-14)
    assert "\n" not in str(caught.value)


def test_a_byte_order_mark_does_no_harm(folder: Path):
    path = box(folder)
    path.write_bytes(b"\xef\xbb\xbf" + path.read_bytes())
    assert read_cad(path).volume() == pytest.approx(6, rel=1e-12)


def test_nan_in_a_name_is_a_name(folder: Path):
    """A string is no number, whatever it says."""
    path = box(folder)
    path.write_text(path.read_text().replace("ADVANCED_FACE(''", "ADVANCED_FACE('(NaN)'"))
    assert read_cad(path).names == ("(NaN)",)


def test_a_dangling_reference_never_passes_silently(folder: Path):
    with pytest.raises(CadError):
        read_cad(damaged_reference(folder))


@pytest.mark.parametrize("function", [read_cad, inspect_cad])
def test_the_kernel_has_a_time_limit(folder: Path, function: Callable[..., object]):
    with pytest.raises(CadError, match="not done after 0.01 s.*time_limit"):
        function(box(folder), time_limit=0.01)


def test_a_crash_of_the_kernel_is_reported(folder: Path, monkeypatch: pytest.MonkeyPatch):
    """A process that a signal ended has a negative exit code and leaves no answer."""
    monkeypatch.setattr("cadbem.cad.kernel.process._finished", lambda *_: (-11, b"noise"))
    with pytest.raises(CadError, match="kernel crashed.*exit code -11"):
        read_cad(box(folder))


def test_a_missing_gmsh_is_named(folder: Path, monkeypatch: pytest.MonkeyPatch):
    """The wheel of gmsh needs system libraries that a bare machine lacks."""
    complaint = b"Traceback ...\nOSError: libGLU.so.1: cannot open shared object file\n"
    monkeypatch.setattr("cadbem.cad.kernel.process._finished", lambda *_: (1, complaint))
    with pytest.raises(CadError, match="libGLU.so.1.*install"):
        read_cad(box(folder))


def test_reports_do_not_raise_for_what_they_can_describe(folder: Path):
    report = inspect_cad(open_shell(folder))
    assert len(report.problems) == 1
    assert "4 edges belong to one face only" in report.problems[0]
    assert report.area == pytest.approx(22 - 2, rel=1e-12)
    gmsh.clear()
    assert "2 solids" in inspect_cad(two_solids(folder)).problems[0]


def test_reports_tell_what_the_kernel_complained_about(folder: Path):
    """A shell that refers to a face which is not there has a hole in its place."""
    path = box(folder)
    text = path.read_text()
    shell = re.search(r"CLOSED_SHELL\('',\((#\d+)", text)
    assert shell is not None
    path.write_text(text.replace(shell[0], "CLOSED_SHELL('',(#99999"))
    report = inspect_cad(path)
    assert any("Unresolved Reference" in remark for remark in report.remarks)
    assert "4 edges belong to one face only" in report.problems[0]


def test_faces_of_no_solid_must_be_turned_alike(folder: Path):
    """A closed box without a solid: fine as it is, refused with its first two faces turned."""
    model = open_model(box(folder), 60.0)
    loose = replace(model, kernel=replace(model.kernel, solids=()))
    assert loose.obstacles() == []
    turned = [replace(face, outward=-face.outward) for face in loose.faces[:2]]
    (problem,) = replace(loose, faces=(*turned, *loose.faces[2:])).obstacles()
    assert "turned to different sides" in problem


@pytest.mark.parametrize("size", [0.0, -1.0, float("nan")])
def test_the_size_of_tetrahedra_must_be_positive(folder: Path, size: float):
    with pytest.raises(InputError, match="size is .*; give a finite number above 0"):
        mesh_volume(folder / "any.step", size)


def test_no_temporary_folder(folder: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(tempfile, "tempdir", str(folder / "not there"))
    with pytest.raises(CadError, match="no room for temporary files.*not there, or set TMPDIR"):
        read_cad(box(folder))


@pytest.mark.skipif(sys.platform != "linux", reason="needs a limit on the size of files")
@pytest.mark.parametrize("room", [100, 30_000, 100_000])
def test_a_temporary_folder_that_fills_up(room: int):
    """While the file is copied, and while the kernel writes."""
    import resource

    done = subprocess.run(
        [sys.executable, "-m", "cadbem", "info", GEOMETRIES / "serpentine.step"],
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (room, room)),
        capture_output=True, text=True,
    )  # fmt: skip
    assert done.returncode == 2
    assert done.stderr.count("\n") == 1
    assert "no room for temporary files" in done.stderr


def test_only_one_solid_is_meshed(folder: Path):
    with pytest.raises(CadError, match="2 solids"):
        mesh_volume(two_solids(folder), 1.0)
