"""Workflows of bodies in channels from CAD files, run coarse: what holds whatever the resolution,
and one number each that is known."""

import sys
from pathlib import Path

import numpy as np
import pytest
from pictures_in import pictures_in

import cadbem as cb
from cadbem.suspension.time.history import plane_angle

sys.path.insert(0, str(Path(__file__).parents[1] / "workflows"))

import constriction_droplet  # noqa: E402
import droplet_train  # noqa: E402
import serpentine_mixture  # noqa: E402

PICTURES = {"along.png", "filmstrip.png", "movie.gif", "paths.png", "series.png"}
COARSE = ["--points", "50", "--tolerance", "1e-2"]


def assert_sound(run: cb.History) -> None:
    """In each frame mass is conserved, droplets keep their volume, all bodies are in the fluid and
    apart from each other, and what is symmetric about the plane z = 0 stays so."""
    for state in run.states:
        assert abs(state.walls.net_flux()) < 1e-4
        flow, start = state.flow, run.states[0]
        for number, body, placed in zip(state.numbers, state.bodies, state.placed, strict=True):
            assert flow.nearest(placed.targets, np.inf).distance.min() > 0
            assert abs(body.centre[2]) < 1e-6
            if isinstance(body, cb.Droplet):
                assert body.volume == pytest.approx(start.bodies[number - 1].volume, rel=1e-10)
                assert asymmetry(body.shape) < 1e-6
        assert all(gap.length > 0 for gap in state.gaps)


def asymmetry(shape: cb.ClosedSpline) -> float:
    """How far coefficients are from their mirror images in z = 0, where the poles are on z."""
    mirrored = shape.coefficients[:, ::-1] * np.array([1.0, 1.0, -1.0])[:, None, None]
    return abs(shape.coefficients - mirrored).max()


def assert_left(run: cb.History, numbers: set[int]) -> None:
    """The run ended because all have left through the outlet."""
    left = run.last.left
    assert set(left) == numbers
    assert all(f"body {n} left through 'outlet'" in left[n] for n in numbers)
    assert run.last.stopped == "; ".join(left.values())


@pytest.mark.long
def test_droplet_train(tmp_path):
    """Droplets leave in their order, and in a straight channel nearly at the distance that they
    started at: each is carried as the one before it.  The plane y = 0 is one of symmetry too."""
    options = ["--front", "4.5", "--distance", "0.5", "--droplets", "2", "--element-size", "0.6"]
    options += ["--throat-size", "0.6", "--tension", "5", "--every", "0.1", *COARSE]
    run = cb.run(droplet_train.main, ["-o", str(tmp_path), *options])
    assert_sound(run)
    assert_left(run, {1, 2})
    assert list(run.last.left) == [1, 2]
    (times, first), (_, second) = run.track(1), run.track(2)
    assert abs(first[1]).max() < 1e-6
    assert first[0] - second[0, : len(times)] == pytest.approx(0.5, rel=0.05)
    assert pictures_in(tmp_path) == PICTURES


def test_constriction_droplet(tmp_path):
    """A round droplet with λ = 1 adds nothing to the flow: there is no extra pressure, and its
    centre has the mean velocity of the flow in it, u + R² ∇²u / 10 = u + R² ∇p / (10 μ), as u is
    biharmonic.  In the narrowing channel it gets faster and longer."""
    options = ["--start", "-1.3", "--radius", "0.25", "--element-size", "0.5", "--end", "0.1"]
    run = cb.run(
        constriction_droplet.main, ["-o", str(tmp_path), *options, "--every", "0.05", *COARSE]
    )
    assert_sound(run)
    passage = run.course()
    flow = run.states[0].flow.empty
    step = 1e-3
    ends = flow.pressure_at([[-1.3 - step, -1.3 + step], [0, 0], [0, 0]])
    gradient = (ends[1] - ends[0]) / (2 * step)
    expected = flow.velocity_at([[-1.3], [0], [0]])[0, 0] + 0.25**2 * gradient / 10
    assert passage.speed[0] == pytest.approx(expected, rel=5e-4)
    assert abs(passage.extra_drop()[0]) < 1e-4 * flow.mean_pressure("inlet")
    assert (np.diff(passage.speed) > 0).all()
    assert (np.diff(passage.deformation) > 0).all()
    assert pictures_in(tmp_path) == PICTURES


def test_extra_pressure():
    """What a droplet with λ = 1 adds to the pressure drop at a given flow rate Q is, by the
    reciprocal theorem with the flow u of the empty channel, ∮ Δf·u dS / Q with Δf = γ c n."""
    flow = constriction_droplet.empty_channel(0.4, viscosity=1.0, mean_velocity=1.0)
    shape = cb.spline_ellipsoid((0.36, 0.27, 0.28), (-1.0, 0.0, 0.0), points=128)
    state = cb.Simulation(flow, cb.Droplet(shape, cb.SurfaceTension(20.0))).start
    points, weights = state.layers[0].points, state.layers[0].weights
    through = (flow.empty.velocity_at(points.position) * points.normal).sum(axis=0)
    expected = 20.0 * float((points.curvature * through) @ weights) / flow.empty.flow_rate("inlet")
    assert cb.History((state,)).course().extra_drop()[0] == pytest.approx(expected, rel=5e-3)


def test_droplet_leaves_the_constriction():
    """The run ends when the droplet reaches the outlet."""
    options = ["--start", "3.3", "--radius", "0.3", "--element-size", "0.6", "--every", "0.1"]
    run = cb.run(constriction_droplet.main, ["-o", "", *options, *COARSE])
    assert_sound(run)
    assert_left(run, {1})


def test_serpentine_mixture():
    """Particles turn with the flow's vorticity: that of the ellipsoid, below the centreline, is
    negative, that of the sphere, above it, positive.  Nothing leaves the mid-plane z = 0."""
    options = ["--element-size", "1", "--particle-spans", "1", "--end", "0.05", *COARSE]
    run = cb.run(serpentine_mixture.main, ["-o", "", *options, "--every", "0.05"])
    assert_sound(run)
    spins = [run.states[0].responses[n - 1].angular_velocity for n in (4, 3)]
    assert spins[0][2] < 0 < spins[1][2]
    assert abs(np.array(spins)[:, :2]).max() < 1e-6
    long_axis = run.turn(4)[:, 0]
    assert abs(long_axis[2]).max() < 1e-6
    assert (np.diff(plane_angle(long_axis, period=180.0)) < 0).all()
