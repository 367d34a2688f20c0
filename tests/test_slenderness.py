"""Ducts with elements much longer than wide."""

import pytest

import cadbem as cb
from cadbem.problems.slenderness import slenderness

POISEUILLE = 28.454  # -dp/dx W² / (μ U) in a square duct (White, Viscous Fluid Flow, Eq. 3-48)


def drop(length: float, storage: cb.Dense | cb.Compressed) -> float:
    """The pressure gradient, by elements as long as half the duct."""
    names = ("inlet", "outlet", "walls", "walls", "walls", "walls")
    sides = zip(cb.box((0, 0, 0), (length, 1, 1)), names, strict=True)
    duct = cb.Boundary(tuple(cb.Patch(s, n) for s, n in sides)).elevated(3).refined(2)
    data = {"walls": cb.NoSlip(), "inlet": cb.Inflow(1.0), "outlet": cb.Pressure(0.0)}
    flow = cb.StokesProblem(duct, 1.0, data, storage=storage).solve()
    return flow.mean_pressure("inlet") / length


@pytest.mark.filterwarnings("error::cadbem.errors.AccuracyWarning")
@pytest.mark.parametrize("storage", [cb.Dense(), cb.Compressed()])
def test_elements_a_hundred_times_as_long_as_wide_will_do(storage: cb.Dense | cb.Compressed):
    assert drop(100.0, storage) == pytest.approx(POISEUILLE, rel=2e-3)


@pytest.mark.parametrize("length", [1e3, 2e5])
@pytest.mark.parametrize("storage", [cb.Dense(), cb.Compressed()])
def test_what_is_wrong_is_warned_about(storage: cb.Dense | cb.Compressed, length: float):
    with pytest.warns(cb.AccuracyWarning, match=r"may be (far )?off"):
        wrong = drop(length, storage)
    assert abs(wrong / POISEUILLE - 1) > 0.01


def test_slenderness():
    sides = cb.box((0, 0, 0), (6.0, 2.0, 1.0))
    assert max(slenderness(s) for s in sides) == pytest.approx(6.0)
    for side in sides:
        assert slenderness(side.swapped()) == pytest.approx(slenderness(side))
    assert slenderness(sides[4].inserted([[0.5], []])) == pytest.approx(1.5)
