"""The command line: exit codes, one line for a user's mistake, quick help, quick import."""

import ast
import os
import subprocess
import sys
from pathlib import Path

import pytest

import cadbem
from cadbem.cli import main

ROOT = Path(__file__).resolve().parents[1]
SQUARE = ROOT / "geometries" / "square_channel.step"
HEAVY = {"gmsh", "pyvista", "vtkmodules", "numba", "scipy", "meshio", "matplotlib"}


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
    assert "open.step" in mistake(capsys, "view", path, "-o", tmp_path / "out.png")


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


@pytest.mark.parametrize("command", ["info", "view", "run", "warmup"])
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
