"""A droplet between parallel plates that move, as the workflow computes it (thesis Fig. 4.7, 4.8).

Ca = 0.2, λ = 1, R / W = 0.8; true D(τ), its peak of 0.3586 at τ = 3.4 and its steady value 0.34884
come from a spectral computation.
"""

import sys
from pathlib import Path

import numpy as np
import pytest
from pictures_in import pictures_in

import cadbem as cb
from cadbem.verification.figures import plates
from cadbem.verification.theory import shapira_haber
from cadbem.verification.true_series import PLATES

sys.path.insert(0, str(Path(__file__).parents[1] / "workflows"))

import droplet_between_plates as workflow  # noqa: E402


def test_droplet_between_close_plates(tmp_path, capsys):
    """D(0.5) to 1e-3; without plates it is 0.032 less."""
    options = ["--end", "0.5", "--points", "72", "--degree", "4", "--tolerance", "3e-3"]
    runs = cb.run(workflow.main, ["-o", str(tmp_path), *options])
    run = runs["time", 0.8]
    times, true = plates.true_series(run)
    assert times == pytest.approx([0.5])
    assert run.deformation[-1] == pytest.approx(true[0], abs=1e-3)
    assert plates.case_of(run) == pytest.approx(plates.TRUE_CASE)
    assert pictures_in(tmp_path) == {"deformation.png", "movie.gif", "filmstrip.png"}
    assert "0.3548" in capsys.readouterr().out


def test_theory_of_far_plates():
    """Shapira and Haber's plates add the cube of R / W to Taylor's D: for λ = 1, W = 10 R it is
    Ca 35 / 32 (1 + 5.69961743634 × 3.5 / 2 / 20³)."""
    assert shapira_haber(0.2, 1.0, 0.0) == pytest.approx(0.21875, rel=1e-12)
    assert shapira_haber(0.2, 1.0, 0.1) == pytest.approx(0.21902273, abs=1e-8)


@pytest.mark.long
def test_plates_far_away():
    """D for R / W = 0.4 over that without plates, 0.2231154: small deformation says 1.0798; at
    Ca = 0.2 the excess is larger, though by less than half."""
    runs = cb.run(workflow.main, ["-o", "", "--parts", "confinement", "--confinements", "0.4"])
    found = runs["confinement", 0.4].deformation[-1] / plates.FREE - 1
    theory = shapira_haber(0.2, 1.0, 0.4) / 0.21875 - 1
    assert theory < found < 1.5 * theory


@pytest.mark.long
def test_overshoot_and_steady_shape():
    """The whole series, the peak and the steady value to 2e-3."""
    run = cb.run(workflow.main, ["-o", ""])["time", 0.8]
    times, true = plates.true_series(run)
    assert np.abs(plates.kept(run, times) - true).max() < 2e-3
    assert run.deformation.max() == pytest.approx(plates.PEAK[1], abs=2e-3)
    assert run.times[run.deformation.argmax()] == pytest.approx(plates.PEAK[0], abs=0.25)
    assert run.deformation[-1] == pytest.approx(PLATES.steady, abs=2e-3)
    assert abs(run.volume - run.volume[0]).max() < 1e-12
