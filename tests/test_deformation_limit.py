"""The capillary number that a limit of deformation allows."""

import json
from pathlib import Path

import pytest

import cadbem as cb

REFERENCE = json.loads((Path(__file__).parent / "data" / "reference.json").read_text())


def test_roots_of_functions():
    """D = 2 Ca reaches 0.1 at 0.05 from any guess; with a break-up at 0.2 it reaches 0.9 there."""

    def broken(capillary: float) -> float:
        return 2 * capillary if capillary < 0.2 else float("inf")

    for guess in (None, 1e-3, 10.0):
        assert cb.largest_capillary(0.1, broken, guess) == pytest.approx(0.05, rel=1e-3)
        assert cb.largest_capillary(0.9, broken, guess) == pytest.approx(0.2, rel=1e-3)


@pytest.mark.parametrize("ratio", [1.0, 4.0])
def test_small_deformation(ratio):
    """Taylor: D = (19 λ + 16) / (16 λ + 16) Ca, up to terms of order Ca²."""
    measured = cb.ShearDeformation(ratio, end=0.7, points=72, every=0.7)
    found = cb.largest_capillary(0.02, measured)
    assert found == pytest.approx(0.02 * (16 * ratio + 16) / (19 * ratio + 16), rel=0.01)


def test_large_deformation():
    """A spectral computation has D(5) = 0.4124 for Ca = 0.35, λ = 1, where D still grows."""
    limit = REFERENCE["drop_3d_shear_Ca0.35_lambda1"]["D"][0]
    measured = cb.ShearDeformation(end=5.0, points=128, every=5.0)
    found = cb.largest_capillary(limit, measured, guess=0.3)
    assert found == pytest.approx(0.35, rel=2e-3)


def test_break_up_counts_as_too_much():
    """At Ca = 2, far above the critical one, a drop of λ = 1 cannot be followed to τ = 100."""
    drop = cb.Droplet(cb.spline_sphere(points=50), cb.capillary_tension(2.0))
    run = cb.Simulation(cb.FreeFlow(cb.shear()), drop, stepper=cb.Adaptive(1e-2)).run(100.0, 2.0)
    assert cb.largest_deformation(run) == float("inf")


def test_mistakes():
    with pytest.raises(cb.InputError, match="limit is 1.5"):
        cb.largest_capillary(1.5)
    with pytest.raises(cb.CadbemError, match="no capillary number between 0.1 and"):
        cb.largest_capillary(0.5, lambda capillary: 0.1, guess=0.1)
