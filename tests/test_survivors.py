"""Small mistakes that no other test would notice: each test fails with the one that it names."""

import warnings
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from test_results import EVERY, channel_with_a_mixture, gone_through, plane_droplet, same_tables

import cadbem as cb
from cadbem.results import open_run, run_folder
from cadbem.results.encode import read_state, write_state
from cadbem.results.hdf5 import Writing, reading
from cadbem.results.series import run_row
from cadbem.spline.outlines import rectangle
from cadbem.suspension.multibody.contact import Gap
from cadbem.suspension.time.limits import too_far


def between_plates(low: tuple[int, int], high: tuple[int, int]) -> cb.Boundary:
    """A rectangle whose short sides are the inlet, at low x, and the outlet."""
    sides = cb.Boundary(tuple(cb.Patch(side) for side in rectangle(low, high)))
    return sides.named(
        rest="walls", inlet=lambda x, n: x[0] == low[0], outlet=lambda x, n: x[0] == high[0]
    )


@pytest.mark.parametrize("rest", [b"0.5,1,2\n", b"9," * 100_000, b""])
def test_tables_are_valid_as_far_as_the_checkpoint_says(tmp_path: Path, rest: bytes):
    """What a killed process wrote beyond it is not read, is written over, and nothing of it stays:
    the checkpoint's byte counts count, and a table is cut off behind what is written."""
    gone_through(tmp_path / "whole", plane_droplet(), end=0.3)
    states = run_folder(tmp_path / "run").run(plane_droplet(), 0.3, EVERY)
    for _ in range(4):
        next(states)
    states.close()
    for name in ("run.csv", "bodies.csv"):
        with (tmp_path / "run" / name).open("ab") as table:
            table.write(rest)
    run = open_run(tmp_path / "run")
    assert len(run.run_table["time"]) == len(run.body_table["time"]) == len(run.times)
    gone_through(tmp_path / "run", plane_droplet(), resume=True, end=0.3)
    assert same_tables(tmp_path / "whole", tmp_path / "run")
    assert b"9,9,9" not in (tmp_path / "run" / "run.csv").read_bytes()


def test_guesses_of_the_iteration_are_kept(tmp_path: Path):
    """To the last bit: a run that begins its iteration elsewhere ends it elsewhere."""
    *_, last = plane_droplet().run(0.1, EVERY)
    guess = tuple(np.array(r.unknown) for r in last.responses)
    state = replace(last, guess=guess)
    assert any(part.size for part in guess)
    with Writing(tmp_path / "state.h5") as place:
        write_state(place, state)
    with reading(tmp_path / "state.h5") as place:
        found = read_state(place, plane_droplet())
    assert len(found.guess) == len(guess)
    for kept, expected in zip(found.guess, guess, strict=True):
        np.testing.assert_array_equal(kept, expected)


def test_pressures_and_flow_rates_of_each_opening():
    """In run.csv under the name of their own opening: of an empty duct, but for a small droplet,
    p = 12 μ U L / H² between plates at the inlet, the pressure given at the outlet, and flow rates
    U H of either sign (into the channel)."""
    duct = between_plates((0, 0), (6, 1)).elevated(4).refined(6)
    data = {"walls": cb.NoSlip(), "inlet": cb.Inflow(1.0), "outlet": cb.Pressure(5.0)}
    drop = cb.Droplet(cb.spline_circle(0.02, (3.0, 0.5), points=16), cb.SurfaceTension(1.0))
    flow = cb.ChannelFlow(cb.StokesProblem(duct, 1.0, data))
    row = run_row(cb.Simulation(flow, drop).start, 0.0)
    assert row["pressure inlet"] == pytest.approx(5.0 + 12 * 6, rel=0.02)
    assert row["pressure outlet"] == pytest.approx(5.0, rel=0.02)
    assert row["flow_rate inlet"] == pytest.approx(1.0, rel=1e-3)
    assert row["flow_rate outlet"] == pytest.approx(-1.0, rel=1e-3)


@pytest.mark.parametrize(
    ("before", "after", "expected"),
    [
        (0.1, 0.06, False),
        (0.1, 0.04, True),
        (0.1, 0.0, True),
        (0.1, -0.01, True),
        (9.0, 2.0, False),
    ],
)
def test_a_step_that_goes_too_far(before: float, after: float, expected: bool):
    """Overlap, or less than half of a gap that is narrower than the points' spacing of 1 then."""

    def at(length: float) -> SimpleNamespace:
        return SimpleNamespace(gaps=[Gap(1, length, "'wall'", 1.0, 9.0, "", 1.0, 0.0)])

    assert too_far(at(before), at(after)) == expected  # type: ignore[arg-type]


@pytest.mark.parametrize("step", [0.02, 0.3])
def test_no_step_goes_through_a_wall(step: float):
    """A disc that is pushed onto a wall, by fixed steps in which it would pass it: they are
    shortened, no state overlaps, and the run ends before the gap is closed."""
    plates = between_plates((-4, -1), (4, 1)).elevated(3).refined(size=0.4)
    data = {"walls": cb.NoSlip(), "inlet": cb.Pressure(1e-9), "outlet": cb.Pressure(0.0)}
    disc = cb.rigid_ellipsoid((0.3, 0.3), (0.0, -0.3))
    flow = cb.ChannelFlow(cb.StokesProblem(plates, 1.0, data))
    pushed = replace(disc, force=(0.0, -40.0))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        states = list(cb.Simulation(flow, pushed, stepper=cb.Euler(step)).run(30.0))
    depths = [state.bodies[0].centre[1] for state in states]
    assert min(depths) > -0.7
    assert states[-1].stopped.startswith("body 1 is 0.0")
    assert depths[-1] < -0.6


def test_a_channel_is_read_back(tmp_path: Path):
    """Its walls, and pressures of both openings that differ."""
    gone_through(tmp_path / "run", channel_with_a_mixture(), end=EVERY)
    run = open_run(tmp_path / "run")
    assert run.channel is not None
    assert run.channel.volume() == pytest.approx(16.0)
    table = run.run_table
    assert (table["pressure inlet"] > 10 * abs(table["pressure outlet"])).all()


def test_pressure_around_a_body_that_deforms():
    """An ellipsoid whose surface moves as in the flow of a point force F = 8πμ e_x at a = (1, 0, 0)
    within it: u = e/r + r (r·e)/r³, σ·n = -6 μ r (r·e)(r·n)/r⁵, and p -> 0 far away fixes the mean
    of f·n, to which the pressure of the deformation contributes."""
    at, force = np.array([1.0, 0.0, 0.0])[:, None], np.array([1.0, 0.0, 0.0])

    def velocity(x: np.ndarray) -> np.ndarray:
        r = x - at
        distance = np.linalg.norm(r, axis=0)
        return force[:, None] / distance + r * (force @ r) / distance**3

    sides = tuple(cb.Patch(side, "ball") for side in cb.ellipsoid((2.0, 1.0, 1.0)))
    ball = cb.Boundary(sides).elevated(5).refined(3)
    flow = cb.StokesProblem(ball, 2.0, {"ball": cb.Velocity(velocity)}).solve()
    found = exact = size = 0.0
    for i in range(len(ball.patches)):
        values, points, weights = flow.traction.quadrature(i)
        r = points.position - at
        across = (r * points.normal).sum(axis=0)
        stress = -12.0 * r * (force @ r) * across / np.linalg.norm(r, axis=0) ** 5
        found += float((values * points.normal).sum(axis=0) @ weights)
        exact += float((stress * points.normal).sum(axis=0) @ weights)
        size += float(np.linalg.norm(stress, axis=0) @ weights)
    assert abs(exact) > 0.05 * size
    assert found == pytest.approx(exact, abs=2e-3 * size)
