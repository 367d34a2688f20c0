"""Wall shear stress against exact flows."""

from pathlib import Path

import numpy as np
import pytest
from shapes import channel as duct
from test_stokes_2d import CHANNEL, channel

import cadbem as cb

ROOT = Path(__file__).parents[1]


def test_plane_channel():
    """6 μ U / h everywhere on the walls; the openings are not walls."""
    boundary = channel().elevated(2).refined(size=0.2)
    found = cb.wall_shear(cb.StokesProblem(boundary, 3.0, CHANNEL, cb.Quadrature(1e-9)).solve())
    exact = 6 * 3.0 * 2.0 / 0.5
    assert [found.peak, found.mean, found.percentile(50)] == pytest.approx([exact] * 3, rel=1e-8)
    assert found.name == "walls" and abs(found.place[1]) == pytest.approx(0.25)


def test_square_duct():
    """In mid-wall G W [1/2 - (4/π²) Σ 1 / (n² cosh(nπ/2))], n odd, by the series of
    ``rectangle_profile``; the mean is G W / 4 by the balance of forces."""
    ends = {"inlet": cb.Inflow(mean_velocity=1.0), "outlet": cb.Pressure(0.0)}
    solution = cb.StokesProblem(
        duct().elevated(2).refined(5), 1.0, {**ends, "walls": cb.NoSlip()}
    ).solve()
    found = cb.wall_shear(solution)
    n = np.arange(1, 40, 2)
    gradient = 28.4541537696
    top = gradient * (0.5 - 4 / np.pi**2 * (1 / (n**2 * np.cosh(n * np.pi / 2))).sum())
    assert found.peak == pytest.approx(top, rel=2e-3)
    assert found.mean == pytest.approx(gradient / 4, rel=1e-3)
    off = np.sort(abs(found.place[1:]))
    assert off == pytest.approx([0.0, 0.5], abs=0.05)
    assert found.percentile(50) < found.percentile(99) <= found.percentile(100) <= found.peak


def test_round_pipe():
    """4 μ U / R."""
    pipe = cb.read_cad(ROOT / "geometries" / "round_pipe.step").elevated(2).refined(size=0.9)
    ends = {"inlet": cb.Inflow(mean_velocity=1.0), "outlet": cb.Pressure(0.0)}
    problem = cb.StokesProblem(pipe, 2.0, {**ends, "walls": cb.NoSlip()}, cb.Quadrature(1e-4))
    found = cb.wall_shear(problem.solve(), "walls")
    assert found.mean == pytest.approx(8.0, rel=5e-3)
    assert found.percentile(50) == pytest.approx(8.0, rel=5e-3)


def test_percentiles_weigh_by_area():
    """Values 1, 2, 3 on areas 1, 2, 7: 10 % of the area lie up to 1, 30 % up to 2."""
    values, weights = np.array([3.0, 1.0, 2.0]), np.array([7.0, 1.0, 2.0])
    shear = cb.WallShear(3.0, np.zeros(3), "walls", 1, values, weights)
    found = [shear.percentile(p) for p in (5, 10, 20, 29, 31, 100)]
    assert found == [1.0, 1.0, 2.0, 2.0, 3.0, 3.0]
    assert shear.mean == pytest.approx(2.6)


def test_unknown_names():
    boundary = channel().elevated(2).refined(2)
    solution = cb.StokesProblem(boundary, 3.0, CHANNEL).solve()
    with pytest.raises(cb.SelectionError, match="no face is named 'lid'"):
        cb.wall_shear(solution, "lid")
