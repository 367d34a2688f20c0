"""Workflows of designers' questions, run coarse: each gets one physical number right."""

import sys
from pathlib import Path

import numpy as np
import pytest
from pictures_in import pictures_in

import cadbem as cb

sys.path.insert(0, str(Path(__file__).parents[1] / "workflows"))

import chip_resistance  # noqa: E402
import deformation_limit  # noqa: E402
import droplet_sorting  # noqa: E402
import flow_split  # noqa: E402
import tracer_paths  # noqa: E402
import wall_shear_peak  # noqa: E402


def test_chip_resistance(tmp_path, capsys):
    """Side channels are mirror images; a tube takes 128 μ L Q / (π d⁴): 128 × 1 mPa s × 10 cm
    × 30 µL/min / (π (1 mm)⁴) = 2.0372 Pa."""
    options = ["--accuracy", "0.02", "--mesh-size", "1", "--bore", "1 mm"]
    network, point = cb.run(
        chip_resistance.main, ["-o", str(tmp_path), *options, "--tube-length", "10 cm"]
    )
    assert network.conductance[1, 1] == pytest.approx(network.conductance[2, 2], rel=1e-6)
    assert point.flow_rates == pytest.approx([0.5, 1.0, 1.0, -2.5], rel=1e-6)
    tube = 128 * 1e-3 * 0.1 * 5e-10 / (np.pi * 1e-12)
    assert point.outside[0] - point.pressures[0] == pytest.approx(tube, rel=1e-9)
    assert pictures_in(tmp_path) == {"slices.png", "streamlines.png"}
    assert "60 µL/min" in capsys.readouterr().out


def test_flow_split(tmp_path):
    """Halves without a tube; with one, both arms' tubes end at pressure 0, so that the share of
    the arm with a tube falls."""
    options = ["--accuracy", "0.02", "--steps", "3"]
    points = cb.run(flow_split.main, ["-o", str(tmp_path), *options])
    shares = [point.fractions["right"] for point in points]
    assert shares[0] == pytest.approx(0.5, abs=1e-6)
    assert shares[0] > shares[1] > shares[2] > 0
    assert pictures_in(tmp_path) == {"split.png"}


def test_wall_shear_peak(tmp_path):
    """In the throat's side walls, about as in a straight duct 0.8 mm wide and 1 mm high: in
    mid-wall G b [1/2 - (4/π²) Σ 1 / (n² cosh(nπ h / 2b))], b = 0.8 and h = 1, by the series of
    ``rectangle_profile``, from whose mean G follows."""
    found = cb.run(wall_shear_peak.main, ["-o", str(tmp_path), "--accuracy", "0.02"])
    b, h, n = 0.8, 1.0, np.arange(1, 60, 2)
    mean = (
        b**2 / 12 * (1 - 192 * b / (np.pi**5 * h) * (np.tanh(n * np.pi * h / (2 * b)) / n**5).sum())
    )
    gradient = 1e-3 * 1.0 / (b * h) / mean
    series = (1 / (n**2 * np.cosh(n * np.pi * h / (2 * b)))).sum()
    assert found.peak == pytest.approx(gradient * b * (0.5 - 4 / np.pi**2 * series), rel=0.1)
    assert abs(found.place[0]) < 0.6 and abs(found.place[1]) == pytest.approx(0.4, abs=0.01)
    assert pictures_in(tmp_path) == {"wall_stresses.png"}


def test_tracer_paths(tmp_path):
    """The mean residence time over both streams is V / Q = 8.5 mm³ / (1 mm³/s)."""
    options = ["--accuracy", "0.02", "--tracers", "4", "--paths", "1"]
    found = cb.run(tracer_paths.main, ["-o", str(tmp_path), *options])
    whole = sum(group.mean_time * group.flow_rates.sum() for group in found.values())
    assert whole == pytest.approx(8.5, rel=0.05)
    assert all(group.shares == {"outlet": 1.0} for group in found.values())
    assert pictures_in(tmp_path) == {"paths.png", "residence_times.png"}


def test_droplet_sorting(tmp_path):
    """On the axis of a square duct a small round droplet of λ = 1 goes with the mean of the flow
    over its volume: u(0) + R² Δu / 10 = 2.0963 - 28.454 / 1000 times the mean velocity, and a
    little slower where it starts, 0.7 widths before the junction."""
    options = ["--radii", "100 um", "--starts", "0 um", "--end", "0.1 s", "--every", "0.1"]
    (fate,) = cb.run(droplet_sorting.main, ["-o", str(tmp_path), *options])
    speed = (fate.path[1, -1] - fate.path[1, 0]) / 0.1
    assert speed == pytest.approx(2.0963 - 0.0285, rel=0.04)
    assert fate.opening == "" and fate.ended == "still inside at time 0.1"
    assert pictures_in(tmp_path) == {"paths.png"}


@pytest.mark.long
def test_droplets_leave_through_both_arms(tmp_path):
    """Far enough to either side of the dividing surface droplets follow the fluid."""
    options = ["--radii", "100 um", "--starts", "-250 100 um"]
    fates = cb.run(droplet_sorting.main, ["-o", str(tmp_path), *options])
    assert [fate.opening for fate in fates] == ["left", "right"]


def test_deformation_limit(tmp_path):
    """Taylor's Ca for a small limit, within 1 %."""
    options = ["--limit", "0.03", "--viscosity-ratios", "1", "--end", "0.7", "--limits", "1"]
    found = cb.run(deformation_limit.main, ["-o", str(tmp_path), *options])
    assert found[1.0] == pytest.approx(0.03 * 32 / 35, rel=0.01)
    assert pictures_in(tmp_path) == {"capillary_numbers.png"}
