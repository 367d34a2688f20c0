"""Workflows, run coarse: each makes its files and gets one physical number right."""

import sys
from math import pi
from pathlib import Path

import pytest
from pictures_in import pictures_in

import cadbem as cb

sys.path.insert(0, str(Path(__file__).parents[1] / "workflows"))

import moving_sphere  # noqa: E402
import square_channel  # noqa: E402
import y_junction_flow  # noqa: E402

PICTURES = {"faces.png", "collocation.png", "traction.png", "slices.png", "streamlines.png"}


def test_square_channel(tmp_path):
    """The exact gradient within 1 % from 256 points."""
    solution = cb.run(
        square_channel.main, ["-o", str(tmp_path), "--spans", "3", "--mesh-size", "0.3"]
    )
    drop = solution.mean_pressure("inlet") - solution.mean_pressure("outlet")
    assert -drop / 2 == pytest.approx(square_channel.EXACT_GRADIENT, rel=0.01)
    assert pictures_in(tmp_path) == PICTURES | {"volume.vtu", "walls.vtu"}


def test_y_junction(tmp_path):
    """Both inlets see the same pressure (mirror symmetry) within the accuracy, and what enters
    leaves."""
    solution = cb.run(
        y_junction_flow.main, ["-o", str(tmp_path), "--accuracy", "0.01", "--mesh-size", "1.5"]
    )
    a, b = solution.mean_pressure("inlet_a"), solution.mean_pressure("inlet_b")
    assert a == pytest.approx(b, rel=1e-2)
    assert solution.flow_rate("outlet") == pytest.approx(-96, rel=1e-9)
    assert pictures_in(tmp_path) == PICTURES | {"volume.vtu", "walls.vtu"}


def test_moving_sphere(tmp_path, capsys):
    """F = -6πμaU to 1e-8; a table for each of seven problems."""
    solution = cb.run(moving_sphere.main, ["-o", str(tmp_path), "--spans", "2"])
    drag = solution.force("body")[0] / (-6 * pi)
    assert drag == pytest.approx(1, abs=1e-8)
    printed = capsys.readouterr().out
    assert printed.count("relative errors") == 7
    assert pictures_in(tmp_path) == {"speed.png"}


def test_wrong_options_are_told_in_one_line(capsys):
    with pytest.raises(SystemExit) as end:
        cb.run(square_channel.main, ["--span", "x"])
    assert end.value.code == 2
    assert capsys.readouterr().err.count("\n") == 1
