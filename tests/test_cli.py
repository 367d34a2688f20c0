"""The command line: exit codes, one line for a user's mistake, quick help, quick import."""

import ast
import json
import os
import subprocess
import sys
from contextlib import contextmanager
from math import pi
from pathlib import Path

import gmsh
import numpy as np
import pytest

import cadbem
from cadbem.cad import write_cad
from cadbem.cli import main

ROOT = Path(__file__).resolve().parents[1]
SQUARE = ROOT / "geometries" / "square_channel.step"
HEAVY = {"gmsh", "pint", "pyvista", "vtkmodules", "numba", "scipy", "meshio", "matplotlib"}


def cadbem_process(*arguments: str | Path) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", "cadbem", *map(str, arguments)],
        capture_output=True,
        text=True,
        timeout=60,
    )


def mistake(capsys: pytest.CaptureFixture[str], *arguments: str | Path) -> str:
    """The one line on stderr that a command leaves which ends with exit code 2."""
    assert main([str(a) for a in arguments]) == 2
    output, errors = capsys.readouterr()
    assert output == ""
    assert errors.startswith("cadbem: ") and errors.count("\n") == 1
    return errors


def loaded_by(statement: str) -> set[str]:
    """Heavy libraries that a fresh interpreter holds after a statement."""
    code = f"import sys\n{statement}\nsys.stderr.write(' '.join(sys.modules))"
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    return HEAVY & {name.split(".")[0] for name in run.stderr.split()}


@pytest.fixture(params=["info", "view"])
def read(request, tmp_path):
    """Arguments of a command that reads a file, up to the file."""
    return {"info": ["info"], "view": ["view", "-o", tmp_path / "out.png"]}[request.param]


def test_missing_file(capsys, read, tmp_path):
    assert "nothing.step" in mistake(capsys, *read, tmp_path / "nothing.step")


@pytest.mark.parametrize(
    ("name", "content"),
    [("empty.step", ""), ("empty.igs", ""), ("recipe.step", "two eggs\n"), ("recipe.txt", "eggs")],
)
def test_file_that_is_not_cad(capsys, read, tmp_path, name, content):
    (tmp_path / name).write_text(content)
    assert name in mistake(capsys, *read, tmp_path / name)


def test_folder_instead_of_file(capsys, read, tmp_path):
    mistake(capsys, *read, tmp_path)


@pytest.fixture
def plate(tmp_path):
    """A plate 4 x 2 x 1 with a round hole of radius 0.5 through it, in the middle."""
    with gmsh_model() as occ:
        box, hole = occ.addBox(-2, -1, 0, 4, 2, 1), occ.addCylinder(0, 0, 0, 0, 0, 1, 0.5)
        occ.cut([(3, box)], [(3, hole)])
        return written(tmp_path / "plate.step")


@pytest.fixture
def open_box(tmp_path):
    """A box 3 x 2 x 1 without its face at x = 3."""
    with gmsh_model() as occ:
        box = occ.addBox(0, 0, 0, 3, 2, 1)
        occ.remove([(3, box)])
        ends = [face for face in occ.getEntities(2) if occ.getCenterOfMass(*face)[0] > 2.9]
        assert len(ends) == 1
        occ.remove(ends)
        return written(tmp_path / "open_box.step")


@pytest.fixture
def two_boxes(tmp_path):
    """Two solids apart from each other, of volume 1 and 8."""
    with gmsh_model() as occ:
        occ.addBox(0, 0, 0, 1, 1, 1)
        occ.addBox(3, 0, 0, 2, 2, 2)
        return written(tmp_path / "two_boxes.step")


@contextmanager
def gmsh_model():
    gmsh.initialize(interruptible=False, readConfigFiles=False)
    gmsh.option.setNumber("General.Terminal", 0)
    yield gmsh.model.occ
    gmsh.finalize()


def written(path):
    gmsh.model.occ.synchronize()
    write_cad(path, {})
    return path


def totals(output: str) -> dict[str, list[str]]:
    """Words of each line by the first one."""
    return {line.split()[0]: line.split()[1:] for line in output.splitlines() if line}


def test_info_of_a_plate_with_a_hole(capsys, plate):
    """Volume (4 x 2 - pi/4) x 1; area twice the perforated face, 12 around, pi within the hole.
    The two perforated planes and the hole's cylinder are exact, each of several patches; a corner
    of four straight or round patches about the hole has no more than a right angle."""
    assert main(["info", str(plate)]) == 0
    output, errors = capsys.readouterr()
    table = output.split("\n\n")[0].splitlines()
    header = ["face", "name", "kind", "degrees", "patches", "area", "deviation", "angle"]
    assert table[0].split() == [*header, "jacobian", "centre", "problem"]
    kinds = sorted((row.split()[2], float(row.split()[5])) for row in table[1:])
    face = 8 - pi / 4
    expected = [("cylinder", pi), *(("plane", a) for a in (2, 2, 4, 4, face, face))]
    assert [kind for kind, _ in kinds] == [kind for kind, _ in expected]
    assert [a for _, a in kinds] == pytest.approx([a for _, a in expected], rel=1e-5)
    assert all(float(row.split()[6]) == 0 for row in table[1:])
    found = totals(output)
    assert float(found["area"][0]) == pytest.approx(2 * face + 12 + pi, rel=1e-9)
    assert float(found["volume"][0]) == pytest.approx(face, rel=1e-9)
    assert output.count("relative difference from the CAD kernel's own surfaces") == 2
    assert float(found["area"][-1]) < 1e-9 and float(found["volume"][-1]) < 1e-9
    assert float(found["gap"][0]) < 1e-9
    assert found["deviation"][:2] == ["0", "mm,"]
    smallest = min(float(row.split()[7]) for row in table[1:])
    assert 10 < float(found["angle"][0]) == smallest <= 90
    assert 0 < float(found["jacobian"][0].strip(",")) <= 1
    assert output.rstrip().endswith("No problems: read_cad accepts this file.")
    assert errors == ""


def test_info_passes_the_options_on(capsys, two_boxes):
    """Which of two solids is the fluid must be said; by number it is that one."""
    assert main(["info", str(two_boxes)]) == 0
    assert "Problems:" in capsys.readouterr().out
    volumes = []
    for fluid in ("1", "2", "all"):
        assert main(["info", str(two_boxes), "--fluid", fluid]) == 0
        volumes.append(float(totals(capsys.readouterr().out)["volume"][0]))
    assert sorted(volumes[:2]) == pytest.approx([1, 8])


@pytest.mark.parametrize("command", ["info", "view"])
def test_options_are_those_of_read_cad(capsys, monkeypatch, tmp_path, command):
    """Given ones only; digits are the number of a solid."""
    calls = []

    def reader(path, **options):
        calls.append(options)
        raise cadbem.CadError("seen")

    monkeypatch.setattr("cadbem.cad.report.inspect_cad", reader)
    monkeypatch.setattr("cadbem.cad.survey.survey_cad", reader)
    picture = ["-o", str(tmp_path / "out.png")] if command == "view" else []
    for options in (["--fluid", "2"], ["--fluid", "void 1", "--names", "layers"], []):
        assert main([command, "a.step", *picture, *options]) == 2
    assert main([command, "a.step", *picture, "--tolerance", "1e-4"]) == 2
    assert calls == [{"fluid": 2}, {"fluid": "void 1", "names": "layers"}, {}, {"tolerance": 1e-4}]


@pytest.mark.parametrize("command", ["info", "view"])
@pytest.mark.parametrize(
    ("option", "value"),
    [("tolerance", "fine"), ("tolerance", "0"), ("tolerance", "nan"), ("names", "numbers")],
)
def test_bad_options_are_one_line(capsys, command, option, value):
    with pytest.raises(SystemExit, match="2"):
        main([command, str(SQUARE), f"--{option}", value])
    output, errors = capsys.readouterr()
    assert (output, errors.count("\n")) == ("", 1)
    assert f"--{option}" in errors and f"'{value}'" in errors


@pytest.mark.parametrize(
    ("fluid", "words"), [("3", "no solid 3"), ("0", "fluid=0"), ("water", "called 'water'")]
)
def test_a_fluid_that_is_not_in_the_file(capsys, two_boxes, fluid, words):
    assert words in mistake(capsys, "info", two_boxes, "--fluid", fluid)


def test_warnings_are_one_line_each(tmp_path):
    """Those of cadbem; others keep Python's form."""
    script = tmp_path / "script.py"
    script.write_text(
        "from warnings import warn\nfrom cadbem.errors import CadWarning\n"
        "warn('no unit\\nis given', CadWarning)\nwarn('seven')\n"
    )
    lines = cadbem_process("run", script).stderr.splitlines()
    assert lines[0] == "cadbem: warning: no unit is given"
    assert lines[1:] == [f"{script}:4: UserWarning: seven", "  warn('seven')"]


def test_view_warns(capsys, tmp_path):
    """A channel as if it were 2 km long."""
    long = tmp_path / "long.step"
    long.write_text(SQUARE.read_text().replace(".MILLI.", ".KILO."))
    assert main(["view", str(long), "-o", str(tmp_path / "out.png")]) == 0
    output, errors = capsys.readouterr()
    assert errors.startswith("cadbem: warning: long.step: ") and errors.count("\n") == 1


def test_info_of_the_square_channel(capsys):
    """Cross-section 1 x 1, length 2: volume 2, area 2 + 4 x 2 = 10; six planes."""
    assert main(["info", str(SQUARE)]) == 0
    output, errors = capsys.readouterr()
    lines = {line.split()[0]: line.split() for line in output.splitlines() if line}
    assert errors == ""
    assert float(lines["area"][1]) == pytest.approx(10, abs=1e-9)
    assert float(lines["volume"][1]) == pytest.approx(2, abs=1e-9)
    assert lines["faces"][1:] == ["6", "in", "6", "patches"]
    assert [lines[str(n)][2] for n in range(1, 7)] == ["plane"] * 6
    assert sorted(lines[str(n)][1] for n in range(1, 7)) == ["inlet", "outlet", *4 * ["walls"]]
    assert output.rstrip().endswith("No problems: read_cad accepts this file.")


def test_info_lists_problems_of_an_open_channel(capsys, tmp_path):
    """A STEP file without its last face is not closed: info says so, view refuses."""
    text = SQUARE.read_text()
    shell = next(line for line in text.split(";") if "CLOSED_SHELL" in line)
    faces = shell[shell.rindex("(") + 1 : shell.index(")")]
    broken = text.replace(faces, faces.rsplit(",", 1)[0])
    path = tmp_path / "open.step"
    path.write_text(broken)
    assert main(["info", str(path)]) == 0
    output, _ = capsys.readouterr()
    assert "Problems:\n- open.step" in output


def test_view_of_an_open_box(capsys, open_box, tmp_path):
    """The four neighbours of the missing face are named, each with the middle of its open edge;
    the opposite face is not."""
    picture = tmp_path / "out.png"
    assert main(["view", str(open_box), "-o", str(picture)]) == 2
    output, errors = capsys.readouterr()
    lines = output.splitlines()
    assert lines[0] == str(picture) and picture.read_bytes().startswith(b"\x89PNG")
    assert errors.startswith("cadbem: open_box.step: the faces leave openings: 4 edges")
    assert errors.count("\n") == 1
    places = [line.split("[")[2].split("]")[0] for line in lines[1:]]
    assert sorted(places) == ["3, 0, 0.5", "3, 1, 0", "3, 1, 1", "3, 2, 0.5"]
    assert all(line.endswith("mm belongs to this face only") for line in lines[1:])


def test_view_draws_and_does_not_overwrite(capsys, tmp_path):
    picture = tmp_path / "square.png"
    assert main(["view", str(SQUARE), "-o", str(picture)]) == 0
    assert picture.read_bytes().startswith(b"\x89PNG")
    capsys.readouterr()
    picture.write_bytes(b"mine")
    assert "--force" in mistake(capsys, "view", SQUARE, "-o", picture)
    assert picture.read_bytes() == b"mine"
    assert main(["view", str(SQUARE), "-o", str(picture), "--force"]) == 0
    assert picture.read_bytes().startswith(b"\x89PNG")


def test_view_into_a_missing_folder(capsys, tmp_path):
    assert "no folder" in mistake(capsys, "view", SQUARE, "-o", tmp_path / "a" / "b.png")


def test_run_passes_arguments_and_finds_neighbours(tmp_path):
    """As with python itself: sys.argv, the script's folder first on the path, __main__."""
    (tmp_path / "helper.py").write_text("word = 'found'")
    script = tmp_path / "script.py"
    script.write_text("import sys, helper\nprint(__name__, helper.word, sys.argv[1:])")
    run = cadbem_process("run", script, "-o", "folder", "--help")
    assert run.stdout == "__main__ found ['-o', 'folder', '--help']\n"
    assert (run.returncode, run.stderr) == (0, "")


def test_run_without_its_script(capsys, tmp_path):
    assert "missing.py" in mistake(capsys, "run", tmp_path / "missing.py")


def test_mistake_in_a_script_is_one_line(tmp_path):
    script = tmp_path / "script.py"
    script.write_text("import cadbem\nraise cadbem.ConditionError('walls have\\nno condition')")
    run = cadbem_process("run", script)
    assert (run.returncode, run.stderr) == (2, "cadbem: walls have no condition\n")


def test_other_errors_of_a_script_keep_their_traceback(tmp_path):
    script = tmp_path / "script.py"
    script.write_text("def deep():\n    raise ValueError('seven')\ndeep()")
    run = cadbem_process("run", script)
    assert run.returncode == 1
    assert "Traceback" in run.stderr and "in deep" in run.stderr
    assert run.stderr.endswith("ValueError: seven\n")


def test_exit_code_of_a_script_is_kept(tmp_path):
    script = tmp_path / "script.py"
    script.write_text("raise SystemExit(7)")
    assert cadbem_process("run", script).returncode == 7


def test_interruption(tmp_path):
    script = tmp_path / "script.py"
    # a process that was started in the background ignores the signal unless told otherwise
    handler = "signal.signal(signal.SIGINT, signal.default_int_handler)"
    script.write_text(f"import os, signal\n{handler}\nos.kill(os.getpid(), signal.SIGINT)")
    run = cadbem_process("run", script)
    assert (run.returncode, run.stderr) == (130, "cadbem: interrupted\n")


@pytest.mark.parametrize("arguments", [[], ["fly"], ["view", "a.step"], ["info"]])
def test_wrong_usage_is_one_line(arguments):
    run = cadbem_process(*arguments)
    assert (run.returncode, run.stdout, run.stderr.count("\n")) == (2, "", 1)
    assert "--help" in run.stderr


@pytest.mark.parametrize("command", ["info", "view", "run", "resume", "render", "sweep", "warmup"])
def test_help_gives_an_example(capsys, command):
    with pytest.raises(SystemExit, match="0"):
        main([command, "--help"])
    assert f"example: cadbem {command}" in capsys.readouterr().out


def test_import_and_help_load_nothing_heavy():
    assert loaded_by("import cadbem; dir(cadbem)") == set()
    help_text = "import cadbem.cli\ntry: cadbem.cli.main(['--help'])\nexcept SystemExit: pass"
    assert loaded_by(help_text) == set()


def test_public_names_exist_and_are_declared_for_type_checkers():
    tree = ast.parse(Path(cadbem.__file__).read_text())
    declared = {
        alias.name
        for node in ast.walk(tree)
        if isinstance(node, ast.ImportFrom) and str(node.module).startswith("cadbem.")
        for alias in node.names
    }
    assert {*dir(cadbem)} == declared | {"__version__"}
    for name in dir(cadbem):
        assert getattr(cadbem, name) is not None
    with pytest.raises(AttributeError, match="no attribute 'stream'"):
        cadbem.stream  # noqa: B018


@pytest.mark.skipif(sys.platform != "linux", reason="system libraries are probed on Linux only")
def test_setup_names_missing_libraries_and_stops(tmp_path):
    """bin/test on a machine without libXft and libEGL, and without the right to install."""
    for name, text in {
        "ldconfig": "/sbin/ldconfig -p | grep -v -e libXft -e libEGL",
        "id": "echo 1000",
    }.items():
        (tmp_path / name).write_text(f"#!/bin/sh\n{text}\n")
        (tmp_path / name).chmod(0o755)
    path = f"{tmp_path}:{os.environ['PATH']}"
    run = subprocess.run(
        [ROOT / "bin" / "test"], env={**os.environ, "PATH": path}, capture_output=True, text=True
    )
    assert run.returncode == 1
    assert run.stderr.count("\n") == 1
    assert "apt-get install -y libegl1 libxft2" in run.stderr


RESUMABLE = '''"""A plane droplet in shear."""
import cadbem as cb


def main(output: str = "out", end: float = 1.0, resume: bool = False, crash: float = 9.0):
    folder = cb.run_folder(output, resume=resume)
    tension = cb.capillary_tension(0.3)
    droplet = cb.Droplet(cb.spline_circle(points=24), tension)
    simulation = cb.Simulation(cb.FreeFlow(cb.shear(dimension=2)), droplet)
    for state in folder.run(simulation, end, every=0.1):
        if state.time > crash and not resume:
            raise KeyboardInterrupt
    folder.summary({"D": cb.taylor_deformation(state.droplet.shape)})


if __name__ == "__main__":
    cb.run(main)
'''


@pytest.fixture
def droplet_script(tmp_path):
    script = tmp_path / "droplet.py"
    script.write_text(RESUMABLE)
    return script


def test_interrupted_run_says_how_to_go_on_and_does(droplet_script, tmp_path, capsys):
    """Interrupted at τ > 0.07, gone on with to τ = 1.2, later than asked at first: frames at every
    0.1, and a droplet that was round only grows longer so early."""
    folder = tmp_path / "out"
    run = cadbem_process("run", droplet_script, "-o", folder, "--crash", "0.07")
    assert run.returncode == 130
    assert run.stderr == f"cadbem: interrupted; go on with 'cadbem resume {folder}'\n"
    stored = cadbem.open_run(folder)
    assert stored.times[-1] < 0.9
    run = cadbem_process("resume", folder, "--end", "1.2")
    assert (run.returncode, run.stderr) == (0, f"{folder}: end is 1.2, was 1.0\n")
    run = cadbem.open_run(folder)
    assert run.times == pytest.approx(np.linspace(0, 1.2, 13))
    assert (np.diff(run.body_table["deformation"]) > 0).all()
    assert main(["render", str(folder)]) == 0
    drawn = {Path(line).name for line in capsys.readouterr().out.splitlines()}
    assert drawn == {"movie.mp4", "movie.gif", "filmstrip.png", "series.png"}


def test_run_that_cannot_go_on(tmp_path, capsys):
    script = tmp_path / "once.py"
    script.write_text(
        "import cadbem as cb\ndef main(output: str = ''):\n    cb.run_folder(output)\ncb.run(main)"
    )
    folder = tmp_path / "out"
    assert cadbem_process("run", script, "-o", folder).returncode == 0
    assert "takes no 'resume'" in mistake(capsys, "resume", folder)
    assert "holds no frames" in mistake(capsys, "render", folder)
    assert "holds no run" in mistake(capsys, "resume", tmp_path)


def test_quiet_and_verbose(droplet_script, tmp_path):
    """Verbose tells of each stage and gives the traceback of a mistake."""
    script = tmp_path / "mistake.py"
    script.write_text("import cadbem\nraise cadbem.ConditionError('no inlet')")
    run = cadbem_process("run", "--verbose", script)
    assert run.returncode == 2
    assert "Traceback" in run.stderr and run.stderr.endswith("cadbem: no inlet\n")
    run = cadbem_process("run", "--verbose", droplet_script, "-o", tmp_path / "out")
    assert run.returncode == 0 and "done at t = 1, 11 frames" in run.stderr
    run = cadbem_process("run", "--quiet", droplet_script, "-o", tmp_path / "other")
    assert (run.returncode, run.stdout, run.stderr) == (0, "", "")


def test_resume_from_another_folder(tmp_path):
    """Relative paths among the arguments are those of the folder where the run began."""
    (tmp_path / "chip.txt").write_text("as it was")
    (tmp_path / "elsewhere").mkdir()
    (tmp_path / "script.py").write_text(
        "import cadbem as cb\n"
        "def main(output: str = 'out', cad: str = 'chip.txt', resume: bool = False):\n"
        "    folder = cb.run_folder(output, cad, resume=resume)\n"
        "    folder.summary({'resumed': float(resume)})\n"
        "cb.run(main)"
    )
    command = [sys.executable, "-m", "cadbem"]
    subprocess.run([*command, "run", "script.py"], cwd=tmp_path, check=True)
    subprocess.run([*command, "resume", "../out"], cwd=tmp_path / "elsewhere", check=True)
    assert json.loads((tmp_path / "out" / "summary.json").read_text()) == {"resumed": 1.0}
    (tmp_path / "script.py").unlink()
    run = cadbem_process("resume", tmp_path / "out")
    assert run.returncode == 2 and "is not there; run its copy" in run.stderr


def test_later_arguments_are_kept_for_the_next_time(droplet_script, tmp_path):
    folder = tmp_path / "out"
    assert cadbem_process("run", droplet_script, "-o", folder, "--end", "0.2").returncode == 0
    assert cadbem_process("resume", folder, "--end", "0.4").returncode == 0
    assert json.loads((folder / "run.json").read_text())["arguments"]["end"] == 0.4
    assert cadbem_process("resume", folder).returncode == 0
    assert cadbem.open_run(folder).times[-1] == 0.4


def test_options_of_a_script(capsys):
    """Needed ones, those whose default is None or True, and what cannot be one."""

    def main(size: float, limit: float | None = None, draw: bool = True, share: str = "50%"):
        return size, limit, draw, share

    assert cadbem.run(main, ["--size", "2", "--limit=3", "--no-draw"]) == (2.0, 3.0, False, "50%")
    assert cadbem.run(main, ["--size=2"]) == (2.0, None, True, "50%")
    for arguments, code in (([], 2), (["--help"], 0)):
        with pytest.raises(SystemExit) as end:
            cadbem.run(main, arguments)
        assert end.value.code == code
    printed = capsys.readouterr()
    assert "--size" in printed.err and "default: 50%" in printed.out

    def other(sizes: tuple = (1, 2)):
        """Cannot be called from a command line."""

    with pytest.raises(SystemExit, match="2"):
        cadbem.run(other, [])
    assert "'sizes' of main cannot be an option" in capsys.readouterr().err
