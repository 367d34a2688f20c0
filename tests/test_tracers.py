"""Passive tracers in flows whose paths are known."""

from pathlib import Path

import numpy as np
import pytest
from shapes import channel as duct
from test_stokes_2d import CHANNEL, channel

import cadbem as cb

ROOT = Path(__file__).parents[1]


@pytest.fixture(scope="module")
def plane() -> cb.StokesSolution:
    """u = 3 (1 - (4 y)²), 2 long and 0.5 wide."""
    boundary = channel().elevated(2).refined(size=0.2)
    return cb.StokesProblem(boundary, 3.0, CHANNEL, cb.Quadrature(1e-9)).solve()


@pytest.fixture(scope="module")
def stem() -> cb.StokesSolution:
    """A plane T-junction, mirror symmetric about x = 0, with 1 in through its stem."""
    plan = cb.read_outline(ROOT / "geometries" / "t_junction.step").elevated(2).refined(size=0.3)
    ends = {"inlet_b": cb.Inflow(flow_rate=1.0)}
    ends |= {"inlet_a": cb.Pressure(0.0), "outlet": cb.Pressure(0.0), "walls": cb.NoSlip()}
    return cb.StokesProblem(plan, 1.0, ends).solve()


def test_plane_poiseuille(plane):
    """t = L / u(y) along straight lines; at the wall, where u = 0, the time limit ends it."""
    y = np.array([0.0, 0.1, -0.2, 0.25])
    tracers = cb.trace(plane, [np.full(4, -0.9), y], time_limit=20.0)
    assert tracers.openings == ("outlet", "outlet", "outlet", "")
    exact = 1.9 / (3 * (1 - (4 * y[:3]) ** 2))
    assert tracers.times[:3] == pytest.approx(exact, rel=1e-6)
    assert tracers.times[3] == pytest.approx(20.0)
    assert tracers.ended[2:] == ("left through 'outlet'", "still inside at the time limit")
    assert tracers.left.tolist() == [True] * 3 + [False]
    for path, moments, start in zip(tracers.paths, tracers.moments, y, strict=True):
        assert path.shape == (2, len(moments))
        assert abs(path[1] - start).max() < 1e-5
        assert (np.diff(moments) > 0).all()
    assert [path[0, -1] for path in tracers.paths[:3]] == pytest.approx([1.0] * 3, abs=1e-9)


def test_residence_times_from_an_inlet(plane):
    """The mean is V / Q = 1; the share that left up to t is (3η - η³) / 2 with t = L / u(η),
    to within what a pair of tracers stands for."""
    tracers = cb.trace(plane, cb.inlet_points(plane, "inlet", count=30))
    assert tracers.mean_time == pytest.approx(1.0, rel=1e-5)
    assert tracers.flow_rates.sum() == pytest.approx(1.0, rel=1e-6)
    assert tracers.shares == pytest.approx({"outlet": 1.0})
    times, shares = tracers.distribution
    eta = np.sqrt(1 - 2 / (3 * times))
    assert shares == pytest.approx((3 * eta - eta**3) / 2, abs=0.08)
    assert shares[-1] == pytest.approx(1.0)


def test_square_duct():
    """Mean residence time V / Q = 2, from 16 points in space."""
    ends = {"inlet": cb.Inflow(mean_velocity=1.0), "outlet": cb.Pressure(0.0)}
    boundary = duct().elevated(2).refined(4)
    solution = cb.StokesProblem(
        boundary, 1.0, {**ends, "walls": cb.NoSlip()}, cb.Quadrature(1e-5)
    ).solve()
    tracers = cb.trace(solution, cb.inlet_points(solution, count=16))
    assert tracers.mean_time == pytest.approx(2.0, rel=5e-3)
    assert set(tracers.openings) == {"outlet"}


def test_mirror_images_part_ways(stem):
    """Left of the plane of symmetry to the left, right of it to the right, at the same times."""
    tracers = cb.trace(stem, [[-0.3, -0.1, 0.1, 0.3], [-2.5] * 4])
    assert tracers.openings == ("inlet_a", "inlet_a", "outlet", "outlet")
    assert tracers.times == pytest.approx(tracers.times[::-1], rel=1e-3)


def test_shares_are_those_of_the_flow(stem):
    """Half of what enters leaves through either end."""
    tracers = cb.trace(stem, cb.inlet_points(stem, count=12), time_limit=60.0)
    assert tracers.shares["inlet_a"] == pytest.approx(tracers.shares["outlet"], abs=1e-6)
    assert sum(tracers.shares.values()) == pytest.approx(1.0)


def test_mistakes(plane):
    with pytest.raises(cb.ConditionError, match="no fluid enters through 'outlet'"):
        cb.inlet_points(plane, "outlet")
    with pytest.raises(cb.InputError, match=r"shape \(3, 1\); give .* \(2, N\)"):
        cb.trace(plane, [[0.0], [0.0], [0.0]])
    for y in (0.3, 9.0):
        with pytest.raises(cb.ConditionError, match=rf"starts at \(0, {y:g}\), outside the fluid"):
            cb.trace(plane, [[0.0], [y]])
    with pytest.raises(cb.UnitsError, match="time_limit: '1 mm' is a length; give a time"):
        cb.trace(plane, [[0.0], [0.1]], time_limit=cb.Units()("1 mm"))
    with pytest.raises(cb.SelectionError, match="no face is named 'drain'"):
        cb.inlet_points(plane, "drain")
