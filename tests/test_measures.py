"""Measures of droplets against ellipsoids, and energies against exact two-phase flows.

E is the rate of strain of a linear flow, λ the viscosity ratio, μ the outer viscosity.
"""

from types import SimpleNamespace

import numpy as np
import pytest
from alone import alone
from scipy.special import ellipe, ellipeinc, ellipkinc

from cadbem.operators.closed.layers import ClosedLayers, ClosedOperator
from cadbem.spline.closed import ClosedBasis, ClosedSpline, closed_spline
from cadbem.spline.closed_shapes import (
    round_basis,
    spline_circle,
    spline_ellipse,
    spline_ellipsoid,
    spline_sphere,
)
from cadbem.suspension.bodies.droplet import Droplet
from cadbem.suspension.interface.extremes import extreme_distances
from cadbem.suspension.interface.laws import SurfaceTension, no_jump
from cadbem.suspension.multibody.measures import (
    area,
    inclination,
    inertia_axes,
    inertia_deformation,
    measure,
    taylor_deformation,
)
from cadbem.suspension.surroundings.flows import (
    at_rest,
    linear_flow,
    pipe_poiseuille,
    plane_extension,
    shear,
    uniaxial_extension,
)
from cadbem.suspension.surroundings.free_flow import FreeFlow

AXES = np.array([1.5, 0.8, 1.0])
RATIOS = (0.1, 1.0, 10.0)


def turn(seed, dim=3):
    """Some rotation."""
    q = np.linalg.qr(np.random.default_rng(seed).normal(size=(dim, dim)))[0]
    q[:, 0] *= np.sign(np.linalg.det(q))
    return q


def image(matrix, centre, points=200, degree=4, seed=None):
    """The unit sphere or circle under a matrix, with poles anywhere if a ``seed`` is given."""
    dim = len(matrix)
    first = np.eye(dim) if seed is None else turn(seed, dim)
    basis = round_basis(dim, points, degree)
    return closed_spline(basis, lambda s: matrix @ first @ s + np.reshape(centre, (-1, 1)))


def ellipsoid_area(a, b, c):
    """Legendre's formula, for a > b > c."""
    angle = np.arccos(c / a)
    m = a**2 * (b**2 - c**2) / (b**2 * (a**2 - c**2))
    first, second = ellipkinc(angle, m), ellipeinc(angle, m)
    mixed = second * np.sin(angle) ** 2 + first * np.cos(angle) ** 2
    return 2 * np.pi * (c**2 + a * b / np.sin(angle) * mixed)


def still(spline, jump=no_jump, flow=None, **options):
    """Measures of a shape that does not move."""
    flow = flow or at_rest(spline.dimension)
    return measure(spline, np.zeros_like(spline.coefficients), jump, flow, **options)


def moved(spline, function):
    """Coefficients of a velocity given as a function of positions."""
    values = function(spline.points())
    return spline.basis.fit(values.reshape(-1, *spline.basis.shape))


@pytest.mark.parametrize("seed", [None, 3, 4])
def test_extremes_are_exact(seed):
    """Distances of an ellipsoid from its centre are its semi-axes; here the spline is off by
    less than 1e-10.  Without a seed the extremes are on the poles and between grid points."""
    q, middle = turn(1), np.array([2.0, -1.0, 0.5])
    spline = image(q @ np.diag([0.8, 1.0, 1.5]), middle, points=1800, degree=6, seed=seed)
    longest, shortest, directions = extreme_distances(spline, middle)
    assert longest == pytest.approx(1.5, abs=1e-10)
    assert shortest == pytest.approx(0.8, abs=1e-10)
    np.testing.assert_allclose(np.abs(directions @ q[:, [2, 0]]), np.eye(2), atol=1e-7)


@pytest.mark.parametrize("degree", [2, 3, 4, 5])
def test_extremes_of_splines(degree):
    """On the spline itself, at any degree: no point of a much finer grid is further away or
    closer, and the nearest of them is within what its spacing allows."""
    spline = image(turn(2) @ np.diag(AXES), np.zeros(3), degree=degree, seed=5)
    off = np.array([0.2, -0.1, 0.15])
    longest, shortest, _ = extreme_distances(spline, off)
    fine = spline.evaluate(spline.basis.refined(20).parameters()) - off[:, None]
    distances = np.linalg.norm(fine, axis=0)
    assert -1e-14 < longest - distances.max() < 1e-4
    assert -1e-14 < distances.min() - shortest < 1e-4


def test_extremes_in_a_plane():
    """The distance of (a cos t, b sin t) from (e, 0) is largest at t = π and smallest where
    cos t = a e / (a² - b²), b sqrt(1 - e² / (a² - b²))."""
    spline = spline_ellipse((2, 1), points=200, degree=6)
    longest, shortest, directions = extreme_distances(spline, np.array([0.3, 0.0]))
    assert longest == pytest.approx(2.3, abs=1e-10)
    assert shortest == pytest.approx(np.sqrt(1 - 0.09 / 3), abs=1e-10)
    np.testing.assert_allclose(directions[0], [-1, 0], atol=1e-7)


def test_symmetric_shapes():
    """Many points equally far: a sphere, and a body of revolution about its poles."""
    assert taylor_deformation(spline_sphere(2.0)) < 1e-6
    body = spline_ellipsoid((0.5, 0.5, 2.0), points=800)
    assert taylor_deformation(body) == pytest.approx(0.6, abs=1e-6)
    assert inclination(body) == pytest.approx(90, abs=1e-4)


def test_ellipsoid_converges():
    """Volume, area, distances and semi-axes; errors fall like h^6, 64 times from 200 to 800
    points, for degree 4."""
    a, b, c = 1.5, 1.0, 0.8
    exact = np.array([4 * np.pi / 3 * a * b * c, ellipsoid_area(a, b, c), a, c, a, b, c])
    errors = []
    for points in (200, 800):
        m = still(spline_ellipsoid(AXES, points=points))
        got = np.array([m.volume, m.area, m.longest, m.shortest, *m.semi_axes])
        errors.append(np.abs(got - exact))
    assert errors[1].max() < 2e-7
    assert (errors[0] > 40 * errors[1]).all()
    assert m.deformation == pytest.approx((a - c) / (a + c), abs=1e-7)
    assert m.inertia_deformation == pytest.approx((a - c) / (a + c), abs=1e-7)


def test_turned_and_shifted():
    """Turned about y by 30 degrees, the long axis x points 30 degrees off x."""
    angle = np.radians(30)
    q = np.array([[np.cos(angle), 0, -np.sin(angle)], [0, 1, 0], [np.sin(angle), 0, np.cos(angle)]])
    middle = np.array([3.0, -2.0, 10.0])
    spline = image(q @ np.diag(AXES), middle, points=800, seed=7)
    m = still(spline)
    np.testing.assert_allclose(m.centre, middle, atol=1e-7)
    assert m.inclination == pytest.approx(30, abs=1e-4)
    assert inclination(spline) == m.inclination
    np.testing.assert_allclose(m.semi_axes, [1.5, 1.0, 0.8], atol=1e-6)
    np.testing.assert_allclose(np.abs(m.axes @ q[:, [0, 2, 1]]), np.eye(3), atol=1e-5)
    np.testing.assert_allclose(np.abs(m.directions @ q[:, [0, 1]]), np.eye(2), atol=1e-5)
    assert taylor_deformation(spline) == pytest.approx(0.7 / 2.3, abs=1e-6)
    assert inertia_deformation(spline) == pytest.approx(0.7 / 2.3, abs=1e-6)


def test_ellipse():
    """Length 4 a E(1 - b² / a²), area π a b; turned by 60 degrees."""
    angle = np.radians(60)
    q = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    spline = image(q @ np.diag([2.0, 1.0]), (1.0, 5.0), points=100, degree=5)
    m = still(spline)
    assert m.volume == pytest.approx(2 * np.pi, rel=1e-9)
    assert m.area == pytest.approx(8 * ellipe(0.75), rel=1e-8)
    assert area(spline) == m.area
    np.testing.assert_allclose(m.centre, [1, 5], atol=1e-12)
    np.testing.assert_allclose(inertia_axes(spline)[0], [2, 1], rtol=1e-8)
    assert m.deformation == pytest.approx(1 / 3, abs=1e-8)
    assert m.inclination == pytest.approx(60, abs=1e-5)
    assert (m.smallest_angle, m.size_ratio) == (90, pytest.approx(2, rel=1e-3))


def test_mesh_quality():
    """A sphere has right angles and equal sizes.  Under diag(a, b, c) areas stretch by a b, b c,
    c a at the ends of the axes, and at the poles on z the diagonals of a rhombus cross,
    at 2 arctan(b / a)."""
    m = still(spline_sphere())
    assert m.smallest_angle == pytest.approx(90, abs=0.1)
    assert m.size_ratio == pytest.approx(1, abs=1e-3)
    m = still(spline_ellipsoid(AXES, points=800))
    assert m.smallest_angle == pytest.approx(2 * np.degrees(np.arctan(0.8 / 1.5)), abs=0.01)
    assert m.size_ratio == pytest.approx(1.5 / 0.8, rel=1e-3)


def test_velocity_of_the_centre():
    """The mean of a linear field is its value at the centre, whatever the shape."""
    for flow in (linear_flow([[1, 2, 0], [0, 1, 3], [1, 0, -2]], drift=(1, 2, 3)), shear(1.0, 2)):
        dim = flow.drift.size
        spline = image(turn(1, dim) @ np.diag(AXES[:dim]), np.arange(1.0, dim + 1))
        m = measure(spline, moved(spline, flow.velocity), no_jump, flow)
        np.testing.assert_allclose(m.velocity, flow.velocity(m.centre[:, None])[:, 0], atol=1e-6)


def test_power_is_the_growth_of_surface_energy():
    """γ dA/dt of an ellipsoid whose axes grow at rates (1, 1/2, -3/2), from the closed form of
    its area; the same for the length of an ellipse."""
    rates, step, tension = np.array([1.0, 0.5, -1.5]), 1e-4, 0.7
    axes = np.array([1.5, 1.0, 0.8])
    flow = linear_flow(np.diag(rates))
    spline = spline_ellipsoid(axes, points=800)
    areas = [ellipsoid_area(*(axes * np.exp(s * rates))) for s in (step, -step)]
    m = measure(spline, moved(spline, flow.velocity), SurfaceTension(tension).jump, flow)
    assert m.power == pytest.approx(tension * (areas[0] - areas[1]) / (2 * step), rel=1e-5)
    flow, spline = plane_extension(1.0, 2), spline_ellipse((2, 1), points=200)
    lengths = [8 * np.exp(s) * ellipe(1 - np.exp(-4 * s) / 4) for s in (step, -step)]
    m = measure(spline, moved(spline, flow.velocity), SurfaceTension(tension).jump, flow)
    assert m.power == pytest.approx(tension * (lengths[0] - lengths[1]) / (2 * step), rel=1e-5)


@pytest.mark.parametrize("ratio", [*RATIOS, 1e6])
def test_dissipation_of_a_sphere_that_begins_to_deform(ratio):
    """A constant jump along n does no work, and the inside strains evenly (Eshelby) at
    5 / (2λ + 3) E.  With that, S = (λ - 1) μ ∮ (u n + n u) dS = (40π/3) μ R³ (λ - 1) / (2λ + 3) E;
    λ → ∞ gives Einstein's 20π/3."""
    flow, spline, radius, viscosity = uniaxial_extension(0.5), spline_sphere(2.0), 2.0, 3.0
    velocity = 5 / (2 * ratio + 3) * moved(spline, flow.velocity)
    m = measure(spline, velocity, SurfaceTension(1.0).jump, flow, viscosity, ratio)
    strain = 0.5**2 * 1.5
    stresslet = 40 * np.pi / 3 * viscosity * radius**3 * (ratio - 1) / (2 * ratio + 3)
    assert m.power == pytest.approx(0, abs=1e-4)
    assert m.dissipation == pytest.approx(stresslet * strain, rel=1e-5, abs=1e-4)


@pytest.mark.parametrize("ratio", RATIOS)
def test_dissipation_of_a_sphere_held_by_tension(ratio):
    """Taylor 1932: with u·n = 0, u = (E·n - n n·E·n) / (1 + λ) and
    Δf = (19λ + 16) / (2 (λ + 1)) μ (n·E·n) n, the stresslet is
    (8π/3) (1 + 5/2 λ) / (1 + λ) μ R³ E."""
    flow, spline, viscosity = shear(2.0), spline_sphere(points=800), 3.0
    strain = np.array([[0, 0, 1.0], [0, 0, 0], [1, 0, 0]])

    def jump(points):
        pull = np.einsum("in,ij,jn->n", points.normal, strain, points.normal)
        return viscosity * (19 * ratio + 16) / (2 * (ratio + 1)) * pull * points.normal

    def velocity(n):
        pull = strain @ n
        return (pull - n * (n * pull).sum(axis=0)) / (1 + ratio)

    m = measure(spline, moved(spline, velocity), jump, flow, viscosity, ratio)
    stresslet = 8 * np.pi / 3 * (1 + 2.5 * ratio) / (1 + ratio) * viscosity
    assert m.power == pytest.approx(0, abs=1e-4)
    assert m.dissipation == pytest.approx(2 * stresslet, rel=1e-4)


@pytest.mark.parametrize("ratio", RATIOS)
def test_dissipation_of_a_computed_flow(ratio):
    """The same stresslet where the velocity is the solution for that jump: u·n vanishes."""
    spline, strain = spline_sphere(), np.array([[0, 0, 0.5], [0, 0, 0], [0.5, 0, 0]])

    def jump(points):
        pull = np.einsum("in,ij,jn->n", points.normal, strain, points.normal)
        return (19 * ratio + 16) / (2 * (ratio + 1)) * pull * points.normal

    layers = ClosedLayers(ClosedOperator(spline.basis), spline)
    law = SimpleNamespace(close=lambda layers, velocity_response: (velocity_response(jump), jump))
    response = alone(FreeFlow(shear()), Droplet(spline, law, ratio), layers)
    m = measure(spline, response.velocity, response.jump, shear(), 1.0, ratio)
    stresslet = 8 * np.pi / 3 * (1 + 2.5 * ratio) / (1 + ratio)
    assert m.power == pytest.approx(0, abs=1e-3)
    assert m.dissipation == pytest.approx(0.5 * stresslet, rel=1e-3)


@pytest.mark.parametrize("ratio", RATIOS)
def test_dissipation_of_a_circle(ratio):
    """In a plane the inside strains at 2 / (1 + λ) E: S = 4π μ R² (λ - 1) / (1 + λ) E."""
    flow, spline = plane_extension(0.5, 2), spline_circle(2.0)
    velocity = 2 / (1 + ratio) * moved(spline, flow.velocity)
    m = measure(spline, velocity, SurfaceTension(1.0).jump, flow, 3.0, ratio)
    exact = 4 * np.pi * 3.0 * 4 * (ratio - 1) / (ratio + 1) * 0.5
    assert m.dissipation == pytest.approx(exact, rel=1e-8, abs=1e-7)


def test_pressure_does_work():
    """∮ u∞·σ∞·n dS is what the undisturbed flow dissipates inside, μ ∫ |∂u_x|² dV
    = (32π/15) μ peak² a⁵ / R⁴ for a sphere of radius a on the axis of a pipe of radius R."""
    flow, spline = pipe_poiseuille(2.0, 3.0), spline_sphere(points=800)
    m = measure(spline, moved(spline, flow.velocity), no_jump, flow, 0.5, 4.0)
    assert m.dissipation == pytest.approx(3 * 0.5 * 32 * np.pi / 15 * 4 / 81, rel=1e-6)


def test_at_rest_dissipation_is_what_the_interface_gives_back():
    spline = spline_ellipsoid(AXES)
    velocity = -moved(spline, plane_extension().velocity)
    m = measure(spline, velocity, SurfaceTension(1.0).jump, at_rest(), 1.0, 5.0)
    assert m.dissipation == -m.power > 0


def test_measures_of_few_points():
    """The coarsest spline there is can be measured."""
    basis = ClosedBasis(2, (3, 6))
    spline = ClosedSpline(basis, closed_spline(basis, lambda s: s).coefficients)
    assert still(spline).volume == pytest.approx(4 * np.pi / 3, rel=0.2)
