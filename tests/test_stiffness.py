"""Linearly implicit steps: their order, the matrix that they use, and what they cost.

Radius 1 and outer viscosity 1 in unbounded fluid; λ is inner over outer viscosity and
Ca = rate / tension.
"""

from dataclasses import astuple
from itertools import pairwise

import h5py
import numpy as np
import pytest

import cadbem as cb
from cadbem.quadrature.closed import PolarRule
from cadbem.results.encode import read_checkpoint, write_checkpoint
from cadbem.suspension.time.relaxation import Relaxation, round_relaxation
from cadbem.suspension.time.rosenbrock import ALPHA, GAMMA, LOWER, WEIGHTS, WEIGHTS_LOW
from cadbem.suspension.time.stepping import Adaptive, Errors, Lengths, rosenbrock

SPHERE = (4 * np.pi / 3) ** (1 / 3)  # size of a sphere of radius 1


def relaxation_rate(degree, ratio):
    """(1 + λ)(l - 1) l (l + 1)(l + 2)(2l + 1) / {[(2l² + 4l + 3) λ + 2l (l + 2)]
    [2 (l² - 1) λ + 2l² + 1]} times tension / (μ R): Lamb's solution inside and outside."""
    l, k = degree, ratio  # noqa: E741
    above = (1 + k) * (l - 1) * l * (l + 1) * (l + 2) * (2 * l + 1)
    below = ((2 * l**2 + 4 * l + 3) * k + 2 * l * (l + 2)) * (2 * (l**2 - 1) * k + 2 * l**2 + 1)
    return above / below


def test_conditions_of_order_three_for_any_matrix():
    """Taylor's expansion of a W-method: Σ b = 1, Σ b α = 1/2, Σ b γ = 0, Σ b α² = 1/3,
    Σ b α_ij α_j = 1/6, and the three mixed sums of second order with γ are 0 (Hairer and Wanner
    1996, IV.7); the estimate's method has those up to order two; the last stage is the result."""
    gamma = LOWER + GAMMA * np.eye(4)
    a, g = ALPHA.sum(axis=1), gamma.sum(axis=1)
    for b in (WEIGHTS, WEIGHTS_LOW):
        assert [b.sum(), b @ a, b @ g] == pytest.approx([1, 1 / 2, 0], abs=1e-15)
    b = WEIGHTS
    third = [b @ a**2, b @ ALPHA @ a, b @ ALPHA @ g, b @ gamma @ a, b @ gamma @ g]
    assert third == pytest.approx([1 / 3, 1 / 6, 0, 0, 0], abs=1e-15)
    assert (ALPHA + gamma)[-1] == pytest.approx(b, abs=1e-15)


def test_a_step_has_order_three_with_a_wrong_matrix_and_its_ends_two():
    """y' = (y_2, -sin y_1) from (1, 0), a pendulum, with a matrix that is not its Jacobian: errors
    of a step fall with h^4, those of cubic interpolation halfway with h³, against SciPy."""
    from scipy.integrate import solve_ivp

    wrong = np.array([[-0.7, 0.4], [0.3, -1.5]])

    def rate(y):
        return np.array([y[1], -np.sin(y[0])])

    start, ends, middles = np.array([1.0, 0.2]), [], []
    lengths = np.array([0.2, 0.1, 0.05])
    for h in lengths:
        matrix = np.linalg.inv(np.eye(2) - GAMMA * h * wrong)
        step = rosenbrock(rate, start, rate(start), h, lambda v, m=matrix: m @ v)
        exact = solve_ivp(
            lambda _, y: rate(y), (0, h), start, "DOP853", (h / 2, h), rtol=1e-13, atol=1e-14
        ).y.T
        first, last = step.ends
        middle = (start + step.state) / 2 + h / 8 * (first - last)
        ends.append(np.linalg.norm(step.state - exact[1]))
        middles.append(np.linalg.norm(middle - exact[0]))
    assert np.polyfit(np.log(lengths), np.log(ends), 1)[0] == pytest.approx(4, abs=0.3)
    assert np.polyfit(np.log(lengths), np.log(middles), 1)[0] == pytest.approx(3, abs=0.3)


@pytest.mark.parametrize("ratio", [0.1, 1.0, 10.0])
def test_matrix_has_the_rates_of_a_relaxing_sphere(ratio):
    """The slowest rates of axisymmetric waves are those of Lamb's solution for l = 2 and 3, to the
    accuracy of splines; l = 0 and 1, volume and place, do not relax; nothing grows."""
    shape = cb.spline_sphere(points=200)
    found = round_relaxation(
        shape.basis, cb.SurfaceTension(1.0), ratio, SPHERE, 1.0, PolarRule(), cb.affine_velocity
    )
    rates = np.sort(-np.linalg.eigvals(found.rates[0]).real)
    assert rates[:2] == pytest.approx([0, 0], abs=1e-3)
    assert rates[2:4] == pytest.approx([relaxation_rate(n, ratio) for n in (2, 3)], rel=3e-3)
    assert max(np.linalg.eigvals(m).real.max() for m in found.rates) < 1e-3


def test_matrix_has_the_rates_of_a_relaxing_circle():
    """n γ / (2 μ (1 + λ) R) for waves n ≥ 2 (Lamb's solution in a plane), and 0 for n = 0 and 1."""
    basis, ratio, radius = cb.spline_circle(points=48).basis, 2.0, 0.5
    found = round_relaxation(
        basis, cb.SurfaceTension(3.0), ratio, radius * np.sqrt(np.pi), 0.7, PolarRule(),
        cb.affine_velocity,
    )  # fmt: skip
    rates = -found.rates[:6, 0, 0].real
    expected = np.array([0, 0, 2, 3, 4, 5]) * 3.0 / (2 * 0.7 * (1 + ratio) * radius)
    assert rates == pytest.approx(expected, rel=3e-3, abs=1e-2)


@pytest.mark.parametrize("motion", [cb.affine_velocity, cb.normal_velocity])
def test_damping_solves_for_an_ellipsoidal_wave(motion):
    """A displacement by the harmonic 3 cos² θ - 1 on a sphere shrinks by 1 + s rate under
    (I - s A)^-1, nearly to nothing for large s, and a shift of the whole stays as it is."""
    droplet = cb.Droplet(cb.spline_sphere(points=200), cb.SurfaceTension(1.0), 10.0)
    simulation = cb.Simulation(cb.FreeFlow(cb.at_rest(3)), droplet)
    relaxation = Relaxation(simulation.start, (droplet,), motion)
    points = droplet.placed(PolarRule()).layers.targets
    height = 3 * points.position[2] ** 2 - 1
    wave = droplet.shape.basis.fit((height * points.normal).reshape(3, *droplet.shape.basis.shape))
    shift = np.ones_like(wave) * np.array([0.3, 0.2, -0.1])[:, None, None]
    for scale in (0.1, 3.0, 30.0, 1e5):
        damped = relaxation.damping(scale)((wave + shift).ravel()).reshape(wave.shape)
        left = points.grid.values(damped - shift)
        share = (left * points.normal).sum(axis=0) @ height / (height @ height)
        assert share == pytest.approx(
            1 / (1 + scale * relaxation_rate(2, 10.0)), rel=1e-2, abs=2e-3
        )


def sheared(capillary, ratio, end, **options):
    """State of a droplet, round at first, after a time in shear."""
    droplet = cb.Droplet(cb.spline_sphere(points=128), cb.capillary_tension(capillary), ratio)
    *_, state = cb.Simulation(cb.FreeFlow(cb.shear()), droplet, **options).run(end)
    assert not state.stopped
    return state


def explicit_cost(state):
    """Evaluations of Chebyshev steps until a state: 12 for 0.65 (12² - 1) over the largest rate."""
    run = cb.Simulation(state.flow, state.bodies)
    return 12 * state.time * run.march.fastest(state) / (0.65 * 143)


@pytest.mark.parametrize("ratio", [0.1, 1.0, 10.0])
def test_cost_does_not_grow_with_tension(ratio):
    """A sheared droplet with Ca = 1e-4 takes less than a tenth of the evaluations that stable
    explicit steps need, and no more than with Ca = 1e-3.  It ends with Taylor's deformation
    Ca (19 λ + 16) / (16 λ + 16), whose error is of order Ca² (Taylor 1934), but for what splines
    make of it, 1 %."""
    stiff, softer = sheared(1e-4, ratio, 1.0), sheared(1e-3, ratio, 1.0)
    assert stiff.evaluations < explicit_cost(stiff) / 10
    assert stiff.evaluations <= softer.evaluations
    theory = 1e-4 * (19 * ratio + 16) / (16 * ratio + 16)
    assert stiff.measures[0].deformation == pytest.approx(theory, rel=1e-2)


def test_a_stiff_circle_in_a_plane():
    """D = Ca for small Ca and any λ in two dimensions: the wave n = 2 grows at rate / (1 + λ) and
    decays at γ / (μ (1 + λ) R)."""
    droplet = cb.Droplet(cb.spline_circle(points=32), cb.capillary_tension(1e-4), 3.0)
    *_, state = cb.Simulation(cb.FreeFlow(cb.shear(dimension=2)), droplet).run(1.0)
    assert state.evaluations < explicit_cost(state) / 5
    assert state.measures[0].deformation == pytest.approx(1e-4, rel=5e-3)


def test_relaxation_in_a_transient():
    """From a sphere D grows as 1 - exp(-rate t) times Taylor's, with the closed rate of l = 2, at
    the times between steps, too: to 2 %, of which splines make 1 %."""
    capillary, ratio = 1e-3, 1.0
    droplet = cb.Droplet(cb.spline_sphere(points=128), cb.capillary_tension(capillary), ratio)
    flow, stepper = cb.FreeFlow(cb.uniaxial_extension()), Adaptive(1e-5)
    run = cb.Simulation(flow, droplet, stepper).run(0.02, every=0.001)
    states = [s for s in run if s.time > 0]
    times = np.array([s.time for s in states])
    steady = capillary * 3 * (19 * ratio + 16) / (32 * (ratio + 1))
    expected = steady * (1 - np.exp(-relaxation_rate(2, ratio) / capillary * times))
    found = np.array([s.measures[0].deformation for s in states])
    assert np.abs(found - expected).max() < 2e-2 * steady


def test_particles_do_not_relax_beside_stiff_droplets():
    """A rigid sphere far from a stiff droplet in shear drifts with the flow at its place, u = z,
    but for the disturbance of the other, a stresslet, of order 1 / distance²."""
    drop = cb.Droplet(cb.spline_sphere(points=98), cb.capillary_tension(1e-3))
    bodies = [drop, cb.rigid_sphere(0.5, (0.0, 8.0, 1.0), spans=1)]
    *_, state = cb.Simulation(cb.FreeFlow(cb.shear()), bodies).run(0.4)
    assert state.evaluations < 150
    assert state.bodies[1].centre == pytest.approx([0.4, 8.0, 1.0], abs=2e-2)


def test_the_cheaper_method_takes_the_step():
    """An implicit step costs 6 evaluations, a Chebyshev step of s stages s and covers at most
    0.65 (s² - 1) / rate: 93 / rate with twelve; implicit steps are taken from 47 / rate on."""
    stepper = Adaptive()
    assert stepper.choose(Lengths(1.0, 40 / 1e4), 1.0, 1e4)[0] is False
    assert stepper.choose(Lengths(1.0, 50 / 1e4), 1.0, 1e4) == (True, 50 / 1e4)
    assert stepper.choose(Lengths(1.0, 0.0), 1.0, 1e4) == (False, 0.65 * 143 / 1e4)
    assert stepper.choose(Lengths(1.0, 1.0), 0.5, 0.0) == (False, 0.5)


def test_failed_implicit_steps_recover_slowly():
    """An error eight times the tolerance cuts an implicit length of order 3 to 0.8 / 2 of it;
    explicit steps after it let it grow by a tenth each, however small their errors."""
    stepper, lengths = Adaptive(1e-3), Lengths(0.1, 1.0)
    accepted, lengths = stepper.next_lengths(lengths, 1.0, Errors(1e-3, 8e-3), 3, True)
    assert not accepted and astuple(lengths) == pytest.approx((0.1, 0.4, 0.4))
    accepted, lengths = stepper.next_lengths(lengths, 0.5, Errors(1e-9, 1e-9), 3, False)
    assert accepted and astuple(lengths) == pytest.approx((1.0, 0.44, 0.44))


def test_a_stored_run_goes_on_to_the_last_bit(tmp_path):
    """From each checkpoint of a stiff run, written and read back, the next step is the one that the
    run takes: all that it needs is kept, lengths of implicit steps and guesses included."""
    droplet = cb.Droplet(cb.spline_circle(points=32), cb.capillary_tension(1e-4), 3.0)
    simulation = cb.Simulation(cb.FreeFlow(cb.shear(dimension=2)), droplet)
    kept = [checkpoint for _, checkpoint in simulation.advance(0.3)]
    assert any(c.ends for c in kept)
    for before, after in pairwise(kept):
        with h5py.File(tmp_path / "kept.h5", "w") as place:
            write_checkpoint(place, before)
        with h5py.File(tmp_path / "kept.h5") as place:
            back = read_checkpoint(place, simulation)
        _, again = next(simulation.advance(0.3, since=back))
        assert again.lengths == after.lengths and again.state.time == after.state.time
        assert np.array_equal(again.slope, after.slope)
        assert np.array_equal(again.state.droplet.coordinates, after.state.droplet.coordinates)


def test_membranes_with_unknown_tension_stay_explicit():
    """How an inextensible membrane relaxes depends on a tension that is found from the flow."""
    droplet = cb.Droplet(cb.spline_circle(points=24), cb.InextensibleMembrane(0.1))
    simulation = cb.Simulation(cb.FreeFlow(cb.shear(dimension=2)), droplet)
    assert not Relaxation(simulation.start, (droplet,), cb.affine_velocity).known
