"""How well points resolve a surface, and their number and layout chosen anew."""

from functools import partial

import numpy as np
import pytest
from scipy.special import ellipeinc
from test_closed_layers import wavy
from test_closeness import drop, plane_channel
from test_results import EVERY, gone_through, same_tables, stored_numbers

import cadbem as cb
from cadbem.errors import InputError
from cadbem.operators.closed.nearest import signed_distance
from cadbem.quadrature.closed import PolarRule
from cadbem.results import open_run, render, run_folder
from cadbem.spline.closed import ClosedBasis, closed_spline
from cadbem.spline.closed_layout import (
    interpolation_error,
    laid_out,
    longest_axis,
    relaid,
    spline_residuals,
)


@pytest.mark.parametrize("degree", [4, 5, 6])
def test_error_of_a_wave(degree):
    """Against the splines through cos kx at 24 points, measured in between; at the shortest waves,
    where more than two terms of the series count, the estimate is up to 1.5 times as large."""
    basis = ClosedBasis(degree, (24,))
    between = np.linspace(0, 2 * np.pi, 2001)[None, :-1]
    for wave in (2, 5, 8, 11):
        spline = basis.interpolate(np.cos(wave * basis.axes()[0]))
        missed = basis.evaluate(spline, between) - np.cos(wave * between[0])
        measured = np.sqrt(2 * (missed**2).mean())
        estimate = interpolation_error(degree, np.array([wave / 24]))[0]
        assert 0.6 < estimate / measured < 1.6


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("count", [9, 12, 16])
def test_estimate_against_the_true_shape(dimension, count):
    """The shape of ``wavy`` is known: its splines are wrong by the estimate, within a factor of 4,
    from 1e-2 to 1e-6."""
    spline = wavy(dimension, count // (3 - dimension + 1) + 2 * (dimension == 2), 5)
    fine = wavy(dimension, 40, 5)
    at = fine.basis.parameters()
    missed = np.linalg.norm(spline.evaluate(at) - fine.points(), axis=0)
    measured = np.sqrt((missed**2).mean())
    estimate = np.linalg.norm(spline_residuals(spline.basis, spline.coefficients))
    assert 0.25 < estimate / measured < 4.0


def test_layout_along_an_axis():
    """A prolate ellipsoid 2 : 1 : 1 with its poles aside: laid out anew they are at its tips, the
    rows as far apart as each other along the meridian (the elliptic integral 2 E(π/2 - t, 3/4)
    from the equator), and the surface is the same."""
    spline = cb.spline_ellipsoid((2.0, 1.0, 1.0), (1.0, 2.0, 3.0), points=800, degree=6, pole=2)
    axis = longest_axis(spline)
    assert np.abs(axis) == pytest.approx([1.0, 0.0, 0.0], abs=1e-9)
    new = laid_out(spline, ClosedBasis(6, (24, 12)), axis)
    tips = new.evaluate([[0.0, np.pi], [0.0, 0.0]]) - [[1.0], [2.0], [3.0]]
    assert np.abs(tips[0]) == pytest.approx([2.0, 2.0], abs=1e-4)
    points = new.points() - [[1.0], [2.0], [3.0]]
    assert pytest.approx(1.0, abs=1e-3) == (points**2).T @ [0.25, 1.0, 1.0]
    rows = points.reshape(3, 24, 12)[:, :, 0]
    latitude = np.arctan2(rows[0] / 2, np.hypot(rows[1], rows[2]))
    # x = 2 sin t, r = cos t: length ∫ √(4 cos² + sin²) dt = 2 E(t | 3/4)
    lengths = np.sort(2 * ellipeinc(latitude, 0.75))
    assert np.diff(lengths) == pytest.approx(np.diff(lengths).mean(), rel=0.03)
    assert np.abs(signed_distance(spline, new.points())).max() < 1e-3


def test_more_points_do_not_change_the_shape():
    """Splines of an even degree on twice as many points contain those on the points before, as
    their knots do."""
    for degree in (4, 6):
        spline = wavy(2, 8, degree)
        assert relaid(spline, spline.basis.refined(2)).evaluate(
            np.linspace(0, 6, 50)[None]
        ) == pytest.approx(spline.evaluate(np.linspace(0, 6, 50)[None]), abs=1e-12)


def test_walls_feel_no_force_of_a_droplet():
    """∮ c n dS = 0: what a droplet does to walls and others has no net force, to the accuracy of
    the quadrature (a spline through the jump at the collocation points has one of 1 % or more)."""
    shape = wavy(3, 10)
    placed = cb.Droplet(shape, cb.SurfaceTension(1.0)).placed(PolarRule())
    equation = placed.equation(1.0, True)
    force = placed.sources(equation.fixed_densities).single.sum(axis=1)
    assert np.linalg.norm(force) < 1e-3 * np.abs(equation.fixed_densities[0]).max()


@pytest.mark.parametrize("shape", [(28, 12), (12, 40)])
def test_short_waves_on_uneven_points(shape):
    """On a sphere with many rows and few columns, or the other way, P_l of the colatitude decays at
    Lamb's rate for λ = 1, 2 (l-1)l(l+1)(l+2)(2l+1) / [(4l² + 8l + 3) (4l² - 1)] γ / (μ R)."""
    degree = shape[0] // 4

    def bumpy(size, u):
        return u * (1 + size * np.polynomial.legendre.Legendre.basis(degree)(u[2]))

    rates = []
    for size in (1e-4, -1e-4):
        spline = closed_spline(ClosedBasis(6, shape), partial(bumpy, size))
        simulation = cb.Simulation(
            cb.FreeFlow(cb.at_rest()), cb.Droplet(spline, cb.SurfaceTension(1.0)), volume=None
        )
        velocity = simulation.start.responses[0].velocity
        unit = spline.points() / np.linalg.norm(spline.points(), axis=0)
        values = spline.basis.evaluate(velocity, spline.basis.parameters())
        wave = np.polynomial.legendre.Legendre.basis(degree)(unit[2])
        share = np.sin(spline.basis.parameters()[0]) * wave
        rates.append(-((values * unit).sum(axis=0) @ share) / (size * wave @ share))
    n = degree
    exact = 2 * (n - 1) * n * (n + 1) * (n + 2) * (2 * n + 1)
    exact /= (4 * n**2 + 8 * n + 3) * (4 * n**2 - 1)
    assert np.mean(rates) == pytest.approx(exact, rel=2e-3)


def stretched(accuracy: float = 1e-7, most: int = 2000) -> cb.Simulation:
    """A plane drop in an extension, which becomes long."""
    droplet = cb.Droplet(cb.spline_circle(points=24), cb.capillary_tension(0.3), 2.0)
    flow, points = cb.FreeFlow(cb.plane_extension(dimension=2)), cb.AdaptivePoints(accuracy, most)
    return cb.Simulation(flow, droplet, points=points)


def test_number_of_points_changes_during_a_run(tmp_path):
    """A run that gains points is stored with the shapes of each frame, goes on after a pause with
    the same bits, keeps its area, and is drawn."""
    whole, pieces = tmp_path / "whole", tmp_path / "pieces"
    states = gone_through(whole, stretched(), end=0.5)
    counts = [s.droplet.shape.basis.count for s in states]
    assert counts[0] == 24 < counts[-1]
    assert all(abs(s.droplet.volume / states[0].droplet.volume - 1) < 1e-12 for s in states)
    begun = run_folder(pieces).run(stretched(), 0.5, EVERY)
    for _ in range(5):
        next(begun)
    begun.close()
    again = gone_through(pieces, stretched(), resume=True, end=0.5)
    for state, other in zip(states, again, strict=True):
        np.testing.assert_array_equal(state.droplet.coordinates, other.droplet.coordinates)
    frames = open_run(whole).frames
    assert [f.shapes[1].basis.count for f in frames] == counts
    expected, found = stored_numbers(whole), stored_numbers(pieces)
    assert all((expected[name] == found[name]).all() for name in expected)
    assert same_tables(whole, pieces)
    assert any(path.name == "filmstrip.png" for path in render(whole))


def test_no_more_points_than_allowed():
    """The same run with at most 26 points ends, and says what to do."""
    *_, last = stretched(1e-8, most=26).run(0.5)
    assert last.droplet.shape.basis.count <= 26 and last.time < 0.5
    assert "AdaptivePoints(most=...)" in last.stopped and "body 1" in last.stopped


def test_a_droplet_that_leaves_is_not_refined():
    """The last step of a run whose only droplet leaves has advanced, and counts."""
    simulation = cb.Simulation(plane_channel(), drop(2.0, 0.0), points=cb.AdaptivePoints(1e-2))
    *_, last = simulation.run(10.0)
    assert "left through 'outlet'" in last.stopped
    assert last.droplet.shape.basis.count < 100


def test_accuracy_that_makes_no_sense():
    with pytest.raises(InputError, match="accuracy is 0.5; give a number"):
        cb.AdaptivePoints(0.5)
