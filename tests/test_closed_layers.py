"""Layer potentials of closed splines on themselves: identities and exact flows."""

from types import SimpleNamespace

import numpy as np
import pytest
from alone import alone
from scipy.special import sph_harm_y

from cadbem.errors import InputError
from cadbem.kernels.stokes_sums import stokes_sums
from cadbem.operators.closed.layers import ClosedLayers, ClosedOperator
from cadbem.post.style.plots import fitted_order
from cadbem.quadrature.closed import PolarRule, SingularitySubtraction, closed_rule
from cadbem.spline.closed import ClosedBasis, ClosedSpline, closed_spline
from cadbem.spline.closed_shapes import spline_ellipsoid
from cadbem.suspension.bodies.droplet import Droplet
from cadbem.suspension.interface.laws import SurfaceTension
from cadbem.suspension.surroundings.flows import at_rest, shear
from cadbem.suspension.surroundings.free_flow import FreeFlow

FINE = PolarRule(1e-8)
ROWS = np.array([8, 12, 16])
RATIOS = (0.01, 0.1, 1.0, 10.0, 100.0)


def wavy(dimension: int, n: int, degree: int = 4) -> ClosedSpline:
    """A smooth shape without any symmetry."""

    def shape(u):
        x, z = u[0], u[-1]
        return u * (1 + 0.15 * (x**3 - 0.6 * x) + 0.1 * x * z + 0.12 * z**2) * [
            [1.2], *[[1.0]] * (dimension - 2), [0.8]]  # fmt: skip

    return closed_spline(ClosedBasis(degree, (4 * n,) if dimension == 2 else (n, 2 * n)), shape)


def layers_of(spline: ClosedSpline, rule=FINE) -> ClosedLayers:
    return ClosedLayers(ClosedOperator(spline.basis, rule), spline)


def stokeslet(source: np.ndarray, strength: np.ndarray, points: np.ndarray, normal: np.ndarray):
    """Velocity G·F and traction T·n·F (viscosity 1) of a point force F at a source."""
    sums = stokes_sums(len(points))
    r = points - source[:, None]
    square = (r**2).sum(axis=0)
    along = (r * strength[:, None]).sum(axis=0)
    if len(points) == 3:
        velocity = strength[:, None] / np.sqrt(square) + r * along / square**1.5
        return velocity, -6 * r * along * (r * normal).sum(axis=0) / square**2.5, sums
    velocity = -0.5 * strength[:, None] * np.log(square) + r * along / square
    return velocity, -4 * r * along * (r * normal).sum(axis=0) / square**2, sums


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("inside", [True, False])
def test_greens_identity(dimension, inside):
    """With the source outside, the flow inside obeys h u = S[σ·n] - D[u]; with the source
    inside, the flow outside obeys h u = -S[σ·n] + D[u]; n outwards, h = 4π or 2π."""
    source = np.full(dimension, 0.1) if inside else np.array([1.5, 1.2, 0.9])[:dimension]
    strength = np.array([0.3, -1.0, 0.7])[:dimension]
    errors = []
    for n in ROWS:
        layers = layers_of(wavy(dimension, n))
        basis, points, at = layers.operator.basis, layers.points, layers.targets
        _, traction, sums = stokeslet(source, strength, points.position, points.normal)
        velocity = stokeslet(source, strength, at.position, at.normal)[0]
        double = layers.double(basis.fit(velocity.reshape(-1, *basis.shape)))
        sign = -1 if inside else 1
        result = sign * (layers.single(traction, at.curvature) - double) / sums.free_term
        errors.append(np.abs(result - velocity).max())
    # at a corner of the coarsest grid the source is about one element away
    assert fitted_order(ROWS, errors) > 3
    assert errors[-1] < (2e-5 if dimension == 2 else 1e-3)


@pytest.mark.parametrize("dimension", [2, 3])
def test_single_layer_of_the_normal_vanishes(dimension):
    """∫ G n dS = 0 (Eq. 4.3a), to the rule's tolerance; ``single`` takes it out by itself, so
    the plain sum is tested."""
    for tolerance in (1e-4, 1e-6, 1e-8):
        layers = layers_of(wavy(dimension, 16, degree=6), PolarRule(tolerance))
        assert np.abs(layers._single(layers.area)).max() < 30 * tolerance**0.75


@pytest.mark.parametrize("ratio", RATIOS)
@pytest.mark.parametrize("dimension", [2, 3])
def test_manufactured_two_phase_flow(dimension, ratio):
    """A linear flow u∞ with strain rate E fills drop and surroundings alike if the interface
    exerts Δf = (σ_out - σ_in)·n = 2 (1 - λ) E·n; then u = u∞ on any shape."""
    flow = shear(dimension=dimension)
    strain = flow.gradient(np.zeros((dimension, 1)))[..., 0]
    strain = (strain + strain.T) / 2

    def jump(points):
        return 2 * (1 - ratio) * strain @ points.normal

    law = SimpleNamespace(close=lambda layers, velocity_response: (velocity_response(jump), jump))
    errors = []
    for n in ROWS:
        spline = wavy(dimension, n)
        layers = layers_of(spline, PolarRule(1e-6))
        velocity = alone(FreeFlow(flow), Droplet(spline, law, ratio), layers).velocity
        exact = flow.velocity(layers.targets.position)
        errors.append(np.abs(layers.operator.collocation.values(velocity) - exact).max())
    assert fitted_order(ROWS, errors) > 2.5 or errors[-1] < 1e-7
    assert errors[-1] < (1e-5 if dimension == 2 else 1e-4)


@pytest.mark.parametrize("ratio", RATIOS)
def test_sphere_in_shear(ratio):
    """At first u·n = 5 / (2λ + 3) n·E·n (3D), 2 / (1 + λ) n·E·n (2D)."""
    for dimension, factor, points in ((3, 5 / (2 * ratio + 3), 200), (2, 2 / (1 + ratio), 32)):
        spline = spline_ellipsoid((1.0,) * dimension, points=points)
        layers = layers_of(spline, PolarRule(1e-6))
        drop = Droplet(spline, SurfaceTension(1.0), ratio)
        velocity = alone(FreeFlow(shear(dimension=dimension)), drop, layers).velocity
        u, n = layers.operator.collocation.values(velocity), layers.targets.position
        assert (u * n).sum(axis=0) == pytest.approx(factor * n[0] * n[-1], abs=3e-6)


@pytest.mark.parametrize("ratio", [1.0, 10.0])
@pytest.mark.parametrize("degree", [2, 4])
def test_sphere_in_shear_converges(degree, ratio):
    """As above, with a slope of at least the degree, though curvature takes two derivatives."""
    errors = []
    for n in (10, 14, 20):
        spline = spline_ellipsoid((1.0, 1.0, 1.0), points=2 * n**2, degree=degree)
        layers = layers_of(spline, PolarRule(1e-11))
        drop = Droplet(spline, SurfaceTension(1.0), ratio)
        velocity = alone(FreeFlow(shear()), drop, layers).velocity
        u, at = layers.operator.collocation.values(velocity), layers.targets.position
        exact = 5 / (2 * ratio + 3) * at[0] * at[2]
        errors.append(np.abs((u * at).sum(axis=0) - exact).max())
    assert fitted_order([10, 14, 20], errors) > degree - 0.05


@pytest.mark.parametrize("ratio", [0.1, 1.0, 10.0])
def test_relaxation_rates_in_2d(ratio):
    """A ripple cos nθ on a circle decays at the rate n / (2 (1 + λ)) γ / (μ R)."""
    for n in (2, 3, 4):
        spline = closed_spline(
            ClosedBasis(4, (64,)),
            lambda u, n=n: u * (1 + 1e-4 * np.cos(n * np.arctan2(u[1], u[0]))),
        )
        rate = _decay(spline, np.cos(n * spline.basis.parameters()[0]), 1e-4, 2, ratio)
        assert rate == pytest.approx(n / (2 * (1 + ratio)), rel=1e-4)


@pytest.mark.parametrize("ratio", [0.1, 1.0, 10.0])
def test_relaxation_rates_in_3d(ratio):
    """A spherical harmonic of degree l on a sphere decays at the rate, in γ / (μ R),

    (1+λ)(l-1)l(l+1)(l+2)(2l+1) / {[(2l²+4l+3)λ + 2l(l+2)] [2(l²-1)λ + 2l²+1]}

    (Lamb's solution; 40(1+λ) / ((2λ+3)(19λ+16)) for l = 2).  The difference of two amplitudes of
    opposite sign leaves out what the discretised sphere does by itself, and second order terms.
    """
    for degree, order in ((2, 0), (2, 2), (3, 1)):
        rates = []
        for size in (1e-3, -1e-3):

            def shape(u, size=size, degree=degree, order=order):
                angles = np.arccos(np.clip(u[2], -1, 1)), np.arctan2(u[1], u[0])
                return u * (1 + size * sph_harm_y(degree, order, *angles).real)

            spline = closed_spline(ClosedBasis(6, (14, 28)), shape)
            mode = sph_harm_y(degree, order, *spline.basis.parameters()).real
            rates.append(_decay(spline, mode, size, 3, ratio))
        n, k = degree, ratio
        exact = (1 + k) * (n - 1) * n * (n + 1) * (n + 2) * (2 * n + 1)
        exact /= (2 * n**2 + 4 * n + 3) * k + 2 * n * (n + 2)
        exact /= 2 * (n**2 - 1) * k + 2 * n**2 + 1
        assert np.mean(rates) == pytest.approx(exact, rel=1e-4)


def _decay(spline, mode, size, dimension, ratio):
    """Rate at which the interface's velocity takes a mode of the given size away."""
    layers = layers_of(spline, PolarRule(1e-7))
    drop = Droplet(spline, SurfaceTension(1.0), ratio)
    velocity = alone(FreeFlow(at_rest(dimension)), drop, layers).velocity
    u = layers.operator.collocation.values(velocity)
    weights = layers.operator.collocation.measure
    normal = (u * layers.targets.normal).sum(axis=0)
    return -((normal * mode) @ weights) / (mode**2 @ weights) / size


def test_velocity_on_an_ellipsoid():
    """λ = 1, γ = 1, at rest, axes 1.6 : 1 : 0.7, against 968 points of degree 8: rms at most 3e-5
    at 200 points and 4e-6 at 800."""

    def velocity(points, degree, rule):
        spline = spline_ellipsoid((1.6, 1.0, 0.7), points=points, degree=degree)
        layers = layers_of(spline, rule)
        drop = Droplet(spline, SurfaceTension(1.0))
        return spline, alone(FreeFlow(at_rest(3)), drop, layers).velocity

    fine, truth = velocity(968, 8, PolarRule(1e-9))
    for points, bound in ((200, 3e-5), (800, 4e-6)):
        coarse, result = velocity(points, 4, PolarRule(1e-5))
        at = coarse.basis.parameters()
        error = coarse.basis.evaluate(result, at) - fine.basis.evaluate(truth, at)
        assert np.sqrt((error**2).sum(axis=0).mean()) < bound


def test_deflation_bounds_the_iterations():
    """At extreme viscosity ratios GMRES needs fewer iterations with deflation."""
    spline = spline_ellipsoid((1.6, 1.0, 0.7))
    layers = layers_of(spline, PolarRule(1e-5))
    for ratio in (0.01, 100.0):
        drop = Droplet(spline, SurfaceTension(1.0), ratio)
        counts = [alone(FreeFlow(shear(), deflated=d), drop, layers) for d in (True, False)]
        assert counts[0].iterations <= 16
        assert counts[0].iterations < counts[1].iterations


def test_singularity_subtraction_converges_slowly():
    """The thesis's rule on a sphere at rest with a ripple: some digits at λ = 1, and far fewer
    than the polar rule with fewer nodes."""
    spline = spline_ellipsoid((1.6, 1.0, 0.7))
    velocities = []
    for rule in (FINE, PolarRule(1e-5), SingularitySubtraction(4)):
        drop = Droplet(spline, SurfaceTension(1.0), 10.0)
        layers = layers_of(spline, rule)
        velocities.append(alone(FreeFlow(at_rest(3)), drop, layers).velocity)
    errors = [np.abs(v - velocities[0]).max() / np.abs(velocities[0]).max() for v in velocities]
    assert errors[1] < 1e-4
    assert 3e-4 < errors[2] < 3e-2


def test_rules_integrate_over_the_sphere():
    """∫ dω = 4π, ∫ x² dω = 4π / 3 and ∫ x⁴ dω = 4π / 5 over the grid."""
    for rule in (PolarRule(), SingularitySubtraction(4)):
        nodes = closed_rule(rule, (10, 20))
        theta, phi = np.meshgrid(*nodes.axes, indexing="ij")
        x = (np.sin(theta) * np.cos(phi)).ravel()
        for power, exact in ((0, 4 * np.pi), (2, 4 * np.pi / 3), (4, 4 * np.pi / 5)):
            assert nodes.weights.ravel() @ x**power == pytest.approx(exact, rel=1e-6)


@pytest.mark.parametrize("rule", [lambda: PolarRule(0.5), lambda: SingularitySubtraction(0)])
def test_impossible_rules_are_refused(rule):
    with pytest.raises(InputError, match="give a (whole )?number from"):
        rule()
