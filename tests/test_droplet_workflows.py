"""Workflows of droplets, run coarse: each makes its pictures and gets one physical number right."""

import sys
from pathlib import Path

import numpy as np
import pytest
from pictures_in import pictures_in

import cadbem as cb
from cadbem.verification.figures.ellipse import semi_axes
from cadbem.verification.figures.shear_2d import series_error
from cadbem.verification.theory import cox, extension
from cadbem.verification.true_series import SHEAR

sys.path.insert(0, str(Path(__file__).parents[1] / "workflows"))

import droplet_elongation  # noqa: E402
import droplet_extension  # noqa: E402
import droplet_high_deformation_2d  # noqa: E402
import droplet_shear  # noqa: E402
import droplet_shear_2d  # noqa: E402
import ellipse_relaxation  # noqa: E402


def first_deformation(growth: float, decay: float, time: float) -> float:
    """D = growth (1 - exp(-decay τ)) / decay: linear theory of a round droplet in shear flow, as
    long as rotation, of third order in τ, does not matter."""
    return growth * (1 - np.exp(-decay * time)) / decay


def test_ellipse_relaxation(tmp_path):
    """An area of 4.7126 becomes a circle of radius sqrt(4.7126 / π), to 1e-6."""
    history = cb.run(ellipse_relaxation.main, ["-o", str(tmp_path)])
    exact = np.sqrt(4.7126 / np.pi)
    assert semi_axes(history)[:, -1] == pytest.approx([exact, exact], abs=1e-6)
    assert pictures_in(tmp_path) == {"ellipse_relaxation.png"}


def test_droplet_shear_2d(tmp_path):
    """D(τ) for λ = 1 and a true Ca of 0.1 within 1e-4 of a spectral computation."""
    runs = cb.run(droplet_shear_2d.main, ["-o", str(tmp_path), "--end", "0.4"])
    assert series_error(runs["thesis's", 1.0, "ours"]) < 1e-4
    assert pictures_in(tmp_path) == {"droplet_shear_2d.png"}


def test_droplet_high_deformation_2d(tmp_path):
    """At first D grows at 1 / (1 + λ), and decays at 1 / ((1 + λ) Ca) with a true Ca of 1/2."""
    runs = cb.run(
        droplet_high_deformation_2d.main, ["-o", str(tmp_path), "--end", "1", "--fine", "48"]
    )
    ours = runs["ours, N = 24"]
    expected = first_deformation(0.5, 1.0, ours.times[1])
    assert ours.deformation[1] == pytest.approx(expected, rel=1e-3)
    assert pictures_in(tmp_path) == {"deformation.png", "shapes.png"}


def test_droplet_shear(tmp_path):
    """D(0.5) for Ca = 0.2, λ = 1 within 2e-4 of a spectral computation."""
    options = ["--end", "0.5", "--points", "72", "--tolerance", "1e-4", "--capillary", "0.2"]
    runs = cb.run(droplet_shear.main, ["-o", str(tmp_path), *options, "--parts", "shape"])
    found = runs["shape", "ours"].deformation[-1]
    assert found == pytest.approx(SHEAR.deformation[0], abs=2e-4)
    shapes = {f"shape_{name}.png" for name in ("ours", "thesis", "thesis_relaxed")}
    assert pictures_in(tmp_path) == shapes | {"deformation.png"}


def test_volume_in_shear(tmp_path, capsys):
    """The volume is kept to rounding; Cox's formula becomes Taylor's, Ca (19λ + 16) / (16λ + 16).

    In the thesis's way it drifts, most for low viscosity.
    """
    options = ["--end", "0.3", "--points", "50", "--parts", "volume table"]
    runs = cb.run(droplet_shear.main, ["-o", str(tmp_path), *options])
    kept = {key[1:]: run.volume for key, run in runs.items() if key[0] == "volume"}
    changes = {key: abs(volume[-1] / volume[0] - 1) for key, volume in kept.items()}
    assert changes[1.0, "ours", True] < 1e-13
    assert changes[0.1, "thesis's way", False] > 5 * changes[0.1, "ours", False]
    assert cox(1e-6, 0.1) == pytest.approx(17.9e-6 / 17.6, rel=1e-9)
    assert pictures_in(tmp_path) == {"volume.png"}
    assert "Table 4.1" in capsys.readouterr().out


def test_droplet_elongation(tmp_path):
    """At first D grows at 5 / (2 (2λ + 3)), and decays at 40 (1 + λ) / ((2λ + 3)(19λ + 16) Ca)."""
    options = ["--end", "0.3", "--points", "50", "--coarse", "50", "--tolerance", "1e-4"]
    history = cb.run(droplet_elongation.main, ["-o", str(tmp_path), *options])
    expected = first_deformation(5 / 6.4, 44 / (3.2 * 17.9 * 0.5), history.times[1])
    assert history.deformation[1] == pytest.approx(expected, rel=2e-3)
    assert history.volume == pytest.approx(4 * np.pi / 3, rel=1e-3)
    assert len([p for p in tmp_path.iterdir() if p.name.startswith("shape_")]) == 4


def test_droplet_extension(tmp_path):
    """Steady D to second order in Ca; the third order is about 24 Ca³ at λ = 10."""
    options = ["--points", "50", "--highest", "0.01", "--tolerance", "1e-3"]
    branches = cb.run(droplet_extension.main, ["-o", str(tmp_path), *options])
    expected = extension(0.01, 10.0, 2)
    assert expected == pytest.approx(1.75568181818 * 0.01 + 3.85597924157 * 1e-4, rel=1e-10)
    found = branches["ours, polar rule"][0][0]
    assert found == pytest.approx(expected, abs=5e-5)
    assert pictures_in(tmp_path) == {"droplet_extension.png", "shape.png"}


def test_history_has_the_states_that_were_kept():
    droplet = cb.Droplet(cb.spline_circle(points=16), cb.capillary_tension(0.1))
    flow = cb.FreeFlow(cb.shear(dimension=2))
    history = cb.record(cb.Simulation(flow, droplet).run(0.2, every=0.1))
    assert history.times == pytest.approx([0, 0.1, 0.2])
    assert history.at(0.1) is history.states[1]
    assert history.area[0] == pytest.approx(2 * np.pi, rel=1e-4)
    with pytest.raises(cb.ShapeError, match="nearest is at 0.1"):
        history.at(0.13)
