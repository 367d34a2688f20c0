"""Plane droplets between moving plates: the workflows, run coarse, against what theory says."""

import json
import sys
from pathlib import Path

import numpy as np
import pytest
from pictures_in import pictures_in

import cadbem as cb
from cadbem.verification.figures.pair_2d import area_change, gaps
from cadbem.verification.figures.plates_2d import flux_across
from cadbem.verification.plates import between_plane_plates
from cadbem.verification.theory import far_plates

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE.parent / "workflows"))

import droplet_between_plates_2d as one  # noqa: E402
import two_droplets_2d as two  # noqa: E402

SERIES = json.loads((HERE / "data/reference.json").read_text())["drop_2d_shear"]["Cat0.1_l1"]


@pytest.fixture(autouse=True)
def few_frames(monkeypatch):
    monkeypatch.setattr(one, "FRAMES", 4)


def assert_sound(run: cb.History) -> None:
    """Areas stay, and at no time does anything flow across the channel: shear flow carries as
    much to either side, droplets cannot change that between closed ends, and through a section
    that cuts a droplet the flow inside counts, too."""
    assert not run.last.stopped
    assert area_change(run) < 1e-10
    for state in run.states:
        assert abs(state.walls.net_flux()) < 1e-4
        for x in (0.7, -2.5):
            assert abs(flux_across(state, x)) < 1e-4


def test_droplet_between_plates(tmp_path):
    """The unbounded droplet follows a spectral computation up to its steady D of 0.0992715;
    plates deform the droplet more, and turn it towards them.  By symmetry it stays where it is."""
    options = ["--widths", "2 4", "--points", "32", "--end", "4", "--parts", "widths"]
    runs = cb.run(one.main, ["-o", str(tmp_path), *options])
    free, near, far = (runs["width", w] for w in (np.inf, 2.0, 4.0))
    exact = np.interp(free.times, SERIES["tau"], SERIES["D"])
    assert free.deformation == pytest.approx(exact, abs=1e-4)
    assert free.deformation[-1] == pytest.approx(0.0992714943648, abs=2e-5)
    assert near.deformation[-1] > far.deformation[-1] > free.deformation[-1]
    tilts = [cb.inclination(run.last.droplet.shape) for run in (near, far, free)]
    assert tilts == sorted(tilts)
    for run in (near, far):
        assert_sound(run)
        assert np.abs(run.track()[1]).max() < 1e-10
    assert pictures_in(tmp_path) == {
        "deformation.png", "movie.gif", "shapes.png", "filmstrip.png"
    }  # fmt: skip


def test_plates_far_away(capsys):
    """D = D_free (1 + K (R / W)² + O(W⁻⁴)), with K = 1.4520976 for λ = 1 and small Ca from the
    Fourier integral in ``far_plates``: extrapolated from W = 8 and 16, and what is left falls
    with W²."""
    options = ["--widths", "8 16", "--capillary", "0.04", "--points", "24", "--end", "0.5"]
    runs = cb.run(one.main, ["-o", "", *options, "--parts", "widths"])
    last = {w: runs["width", w].deformation[-1] for w in (8.0, 16.0, np.inf)}
    found = {w: (last[w] / last[np.inf] - 1) * w**2 for w in (8.0, 16.0)}
    theory = far_plates(1.0)
    assert theory == pytest.approx(1.4520976, abs=1e-7)
    assert (4 * found[16.0] - found[8.0]) / 3 == pytest.approx(theory, rel=1e-3)
    assert (found[8.0] - theory) / (found[16.0] - theory) == pytest.approx(4, rel=0.2)
    assert "1.4521" in capsys.readouterr().out


def test_plates_far_away_from_a_viscous_droplet():
    """K for λ = 5 is 11 / 9 of that for λ = 1: the stresslet of a circle in a rate of strain E is
    2π μ E R² (1 + 2λ) / (1 + λ).  With W = 8, to 2 %."""
    free = cb.FreeFlow(cb.shear(dimension=2))
    bounded, alone = (
        one.simulate(flow, 0.04, 5.0, 16, 1.0).deformation[-1]
        for flow in (between_plane_plates(8.0, parts=3), free)
    )
    assert far_plates(5.0) == pytest.approx(11 / 9 * far_plates(1.0), rel=1e-12)
    assert (bounded / alone - 1) * 64 == pytest.approx(far_plates(5.0), rel=0.02)


def test_drift_to_the_middle(tmp_path):
    """A droplet that deforms moves away from the nearer plate, all the faster the nearer it is."""
    options = ["--points", "24", "--end", "0.75", "--parts", "drift"]
    runs = cb.run(one.main, ["-o", str(tmp_path), *options])
    speeds = []
    for start in (0.25, 0.5, 0.75):
        run = runs["drift", start]
        assert_sound(run)
        speeds.append(start - run.track()[1][1, -1])
    assert 0 < speeds[0] < speeds[1] < speeds[2]
    assert pictures_in(tmp_path) == {"trajectories.png"}


def test_paths_of_two_droplets_are_symmetric():
    """Half a turn about the middle maps the channel and its flow onto themselves, and droplets at
    c and -c onto each other: so it stays."""
    starts = (-1.25, 0.5), (1.25, -0.5)
    run = two.simulate(between_plane_plates(2.2, parts=6), starts, 0.2, 1.0, 16, 1e-3, 1.0)
    first, second = run.track(1)[1], run.track(2)[1]
    assert first == pytest.approx(-second, abs=1e-10)
    assert first[0, -1] > first[0, 0] + 0.2
    deformation = [
        [cb.taylor_deformation(s) for s in state.shapes.values()] for state in run.states
    ]
    assert np.diff(deformation, axis=1) == pytest.approx(0, abs=1e-10)
    assert_sound(run)


def test_two_droplets(tmp_path):
    """In unbounded shear flow u = (y, 0) a turn about the point between two equal droplets leaves
    everything as it is but for a steady flow: y1 + y2 = 1 stays, x1 + x2 grows like τ."""
    options = ["--points", "16", "--end", "0.5", "--parts", "pass"]
    runs = cb.run(two.main, ["-o", str(tmp_path), *options])
    free = runs["pass", "unbounded"]
    total = free.track(1)[1] + free.track(2)[1]
    assert total[1] == pytest.approx(1.0, abs=1e-10)
    assert total[0] == pytest.approx(-2.5 + free.times, abs=1e-10)
    assert area_change(free) < 1e-10
    assert_sound(runs["pass", "plates"])
    apart, to_plates = gaps(free)
    assert apart[0] == pytest.approx(np.hypot(2.5, 1.0) - 2, abs=1e-3)
    assert to_plates == pytest.approx(np.inf)
    assert pictures_in(tmp_path / "pass") == {
        "history.png", "movie.gif", "filmstrip.png", "trajectories.png"
    }  # fmt: skip
