"""Interface laws on round and wavy shapes: forces, energies, relaxation of small waves.

A jump Δf is the rate at which an energy grows per area and normal displacement.  On the unit sphere
r = 1 + ε Y_l, div n = 2 + (l - 1)(l + 2) ε Y_l to first order, so surface tension γ has the jump
γ [2 + (l - 1)(l + 2) ε Y_l] n; bending has c³/2 - 2 K c + Δ_s c = -(l - 1) l (l + 1) (l + 2) ε Y_l,
as the first term is that of two equal curvatures and the last one -l (l + 1) times div n.

On the unit circle r = 1 + ε cos nθ, c = 1 + (n² - 1) ε cos nθ, and c³/2 + c_ss is
1/2 + (3/2 - n²) (n² - 1) ε cos nθ.

Uniform pressures do not move the fluid.  Therefore bending relaxes small waves h l (l + 1) / γ
times as fast as tension does in space, and h (n² - 3/2) / γ times in a plane.
"""

from dataclasses import replace

import numpy as np
import pytest
from alone import alone
from scipy.special import eval_legendre

from cadbem.closed_points import ClosedGrid
from cadbem.operators.closed.layers import ClosedLayers, ClosedOperator
from cadbem.quadrature.closed import PolarRule, fejer_weights
from cadbem.spline.closed import ClosedBasis, closed_spline, unit_point
from cadbem.suspension.bodies.droplet import Droplet
from cadbem.suspension.interface.laws import Bending, SurfaceTension
from cadbem.suspension.surroundings.flows import at_rest
from cadbem.suspension.surroundings.free_flow import FreeFlow

H = 0.7


def layers(spline, tolerance=1e-8):
    return ClosedLayers(ClosedOperator(spline.basis, PolarRule(tolerance)), spline)


def tilted(unit):
    """Cosine of the angle to an axis that is not that of the parameters."""
    return np.array([0.48, 0.6, 0.64]) @ unit


def waves(degree):
    """A surface harmonic of the unit sphere or circle."""
    return lambda unit: (
        eval_legendre(degree, tilted(unit))
        if len(unit) == 3
        else np.cos(degree * np.arctan2(unit[1], unit[0]))
    )


def bumpy(basis, function, amplitude):
    return closed_spline(basis, lambda unit: unit * (1 + amplitude * function(unit)))


def normal_jump(law, at, spline):
    jump = law.jump_of(layers(spline))
    return (jump(at) * at.normal).sum(axis=0)


def uneven(unit):
    """A sphere of radius 2 with unevenly spread parameters."""
    moved = unit * np.array([[1.0], [1.2], [0.9]]) + np.array([[0.1], [0.0], [0.2]])
    return 2 * moved / np.linalg.norm(moved, axis=0)


@pytest.mark.parametrize(("degree", "order", "last"), [(4, 2.5, 3e-3), (6, 5.5, 1e-4)])
def test_sphere_does_not_bend_back(degree, order, last):
    """Δf = 0 on a sphere; with splines of degree 6 soon much better than with degree 4."""
    errors, rows = [], np.array([12, 18, 27, 40])
    for count in rows:
        sphere = closed_spline(ClosedBasis(degree, (count, 2 * count)), uneven)
        errors.append(np.abs(normal_jump(Bending(1.0), layers(sphere).points, sphere)).max())
    assert -np.polyfit(np.log(rows), np.log(errors), 1)[0] > order
    assert errors[-1] < last


def bump_jumps(basis, degree):
    """Bending's normal jump at collocation points of a bumpy shape: the mean over two opposite
    bumps, and their difference per amplitude."""
    tiny, forces = 1e-4, []
    for sign in (1, -1):
        spline = bumpy(basis, waves(degree), sign * tiny)
        forces.append(normal_jump(Bending(H), layers(spline).targets, spline))
    return (forces[0] + forces[1]) / 2, (forces[0] - forces[1]) / (2 * tiny)


@pytest.mark.parametrize("degree", [2, 3, 4])
def test_bending_of_a_bumpy_sphere(degree):
    """Δf = h (l - 1) l (l + 1) (l + 2) ε Y_l n."""
    basis = ClosedBasis(6, (20, 40))
    size = H * (degree - 1) * degree * (degree + 1) * (degree + 2)
    mean, change = bump_jumps(basis, degree)
    expected = size * waves(degree)(unit_point(*basis.parameters()))
    assert mean == pytest.approx(0.0, abs=1e-4)
    assert change == pytest.approx(expected, abs=3e-4 * size)


@pytest.mark.parametrize("waviness", [2, 3, 5])
def test_bending_of_a_bumpy_circle(waviness):
    """Δf = -h [1/2 + (3/2 - n²) (n² - 1) ε cos nθ] n."""
    basis = ClosedBasis(6, (96,))
    size = H * (waviness**2 - 1) * (waviness**2 - 1.5)
    mean, change = bump_jumps(basis, waviness)
    assert mean == pytest.approx(-H / 2, abs=1e-4)
    assert change == pytest.approx(size * np.cos(waviness * basis.axes()[0]), abs=1e-4 * size)


def relaxation(law, basis, function, viscosity_ratio):
    """Decay rate of a small wave on the unit circle or sphere: -u_n / ε where the wave is ε."""
    operator, tiny = ClosedOperator(basis, PolarRule(1e-8)), 1e-4
    speeds = []
    for sign in (1, -1):
        spline = bumpy(basis, function, sign * tiny)
        drop, of = Droplet(spline, law, viscosity_ratio), ClosedLayers(operator, spline)
        velocity = alone(FreeFlow(at_rest(basis.dimension)), drop, of).velocity
        speeds.append((operator.collocation.values(velocity) * of.targets.normal).sum(axis=0))
    wave = function(unit_point(*basis.parameters()))
    return -(wave @ (speeds[0] - speeds[1])) / (2 * tiny * wave @ wave)


@pytest.mark.parametrize("viscosity_ratio", [0.2, 1.0, 5.0])
@pytest.mark.parametrize("degree", [2, 4])
def test_relaxation_of_a_bumpy_sphere(degree, viscosity_ratio):
    """Tension: γ / (μ R) times (1+λ) (l-1) l (l+1) (l+2) (2l+1) divided by
    [(2l²+4l+3) λ + 2l (l+2)] [2 (l²-1) λ + 2l²+1], from Lamb's solution; bending: h l (l+1) / γ
    times that."""
    number, ratio = degree, viscosity_ratio
    outer = (2 * number**2 + 4 * number + 3) * ratio + 2 * number * (number + 2)
    inner = 2 * (number**2 - 1) * ratio + 2 * number**2 + 1
    product = (number - 1) * number * (number + 1) * (number + 2)
    rate = (1 + ratio) * product * (2 * number + 1) / (outer * inner)
    basis = ClosedBasis(6, (14, 28))
    tension = relaxation(SurfaceTension(2.0), basis, waves(degree), ratio)
    bending = relaxation(Bending(H), basis, waves(degree), ratio)
    assert tension == pytest.approx(2.0 * rate, rel=1e-4)
    assert bending == pytest.approx(H * number * (number + 1) * rate, rel=5e-4)


@pytest.mark.parametrize("viscosity_ratio", [0.2, 1.0, 5.0])
@pytest.mark.parametrize("waviness", [2, 4])
def test_relaxation_of_a_bumpy_circle(waviness, viscosity_ratio):
    """Tension: n / (2 (1 + λ)) γ / (μ R); bending: n (n² - 3/2) / (2 (1 + λ)) h / (μ R³)."""
    rate = waviness / (2 * (1 + viscosity_ratio))
    basis = ClosedBasis(6, (64,))
    tension = relaxation(SurfaceTension(2.0), basis, waves(waviness), viscosity_ratio)
    bending = relaxation(Bending(H), basis, waves(waviness), viscosity_ratio)
    assert tension == pytest.approx(2.0 * rate, rel=1e-5)
    assert bending == pytest.approx(H * (waviness**2 - 1.5) * rate, rel=1e-4)


def energies(spline):
    """∮ dS and (1/2) ∮ c² dS."""
    points = ClosedGrid(spline.basis, spline.basis.refined(4).axes()).points(spline)
    weights = points.jacobian * round_weights(spline.basis.refined(4))
    return np.array([weights.sum(), 0.5 * points.curvature**2 @ weights])


def round_weights(basis):
    """Of the collocation points, on the unit circle or sphere."""
    if basis.dimension == 2:
        return np.full(basis.count, 2 * np.pi / basis.count)
    return np.repeat(fejer_weights(basis.shape[0]), basis.shape[1]) * 2 * np.pi / basis.shape[1]


@pytest.mark.parametrize("shape", [(96,), (20, 40)])
def test_jumps_are_derivatives_of_energies(shape):
    """∮ Δf · δx dS = δE for γ ∮ dS and (h/2) ∮ c² dS, any δx, by central differences."""
    basis = ClosedBasis(6, shape)
    spline = bumpy(basis, lambda x: x[0] * x[1] + 0.5 * x[-1] ** 3, 0.2)
    move = basis.fit((0.3 + np.sin(spline.points()[::-1] + 0.5)).reshape(-1, *shape))
    step = 1e-3
    ends = [replace(spline, coefficients=spline.coefficients + s * move) for s in (step, -step)]
    expected = (energies(ends[0]) - energies(ends[1])) / (2 * step)
    of = layers(spline)
    moved = of.points.grid.values(move) * of.weights
    jumps = (SurfaceTension(1.0).jump, Bending(1.0).jump_of(of))
    work = [(jump(of.points) * moved).sum() for jump in jumps]
    assert work[0] == pytest.approx(expected[0], rel=1e-5)
    assert work[1] == pytest.approx(expected[1], rel=3e-4)
