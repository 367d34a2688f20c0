"""Closed splines: approximation, smoothness at the poles, curvature, surface derivatives."""

import numpy as np
import pytest
from scipy.special import sph_harm_y

from cadbem.closed_points import ClosedGrid
from cadbem.errors import ShapeError
from cadbem.post.style.plots import fitted_order
from cadbem.spline.closed import ClosedBasis, ClosedSpline, closed_spline, unit_point
from cadbem.spline.closed_shapes import (
    spline_circle,
    spline_ellipse,
    spline_ellipsoid,
    spline_sphere,
)

RANDOM = np.random.default_rng(1)
ANYWHERE = np.array([[np.pi], [2 * np.pi]]) * RANDOM.uniform(size=(2, 400))
ROWS = np.array([8, 12, 16, 24])


def collocation(spline: ClosedSpline) -> ClosedGrid:
    return ClosedGrid(spline.basis, spline.basis.axes())


def between(basis: ClosedBasis) -> ClosedGrid:
    """A grid that meets neither knots nor centres."""
    return ClosedGrid(basis, [a + 0.21 * (a[1] - a[0]) for a in basis.axes()])


@pytest.mark.parametrize("degree", [2, 3, 4, 5, 6])
def test_sphere_converges_with_degree_plus_one(degree):
    errors = [
        np.abs(spline_sphere(points=2 * n**2, degree=degree).evaluate(ANYWHERE)
               - unit_point(*ANYWHERE)).max()
        for n in ROWS
    ]  # fmt: skip
    assert fitted_order(ROWS, errors) > degree + 0.8


@pytest.mark.parametrize("degree", [2, 3, 4, 5])
def test_splines_are_smooth_across_the_poles(degree):
    """A function that is C^(p-1) at a pole has a d-th derivative along meridians, d < p, that
    contains only the azimuthal modes d, d - 2, ...; here of a fit to noise, at the columns of
    the basis.  Between them the longitude's splines stand for e^{imφ} to their own accuracy."""
    basis = ClosedBasis(degree, (10, 20))
    noise = basis.fit(RANDOM.uniform(-1, 1, basis.shape))
    assert basis.smoothed(noise) == pytest.approx(noise, abs=1e-13)
    longitude = basis.axes()[1]
    for order in range(degree):
        matrices = basis.axis_matrices([np.array([0.0, np.pi]), longitude], (order, 0))
        modes = np.abs(np.fft.rfft(basis.on_grid(noise, matrices), axis=1))
        allowed = [m for m in range(order, -1, -2)]
        rest = np.delete(modes, allowed, axis=1)
        assert rest.max() < 1e-11 * modes.max(), order


def test_tangent_plane_at_the_poles():
    """It is one plane, whichever meridian it is seen from, and the pole one point."""
    surface = closed_spline(
        ClosedBasis(3, (10, 20)), lambda u: u + 0.05 * np.sin(3 * u[::-1] + u)
    )
    longitude = np.linspace(0, 2 * np.pi, 50)
    for pole in (0.0, np.pi):
        at = np.stack([np.full(50, pole), longitude])
        assert np.ptp(surface.evaluate(at), axis=1).max() < 1e-13
        meridians = surface.evaluate(at, (1, 0))
        assert np.linalg.svd(meridians)[1][2] < 1e-12


def test_poles_carry_no_short_waves():
    """Near a pole at most 1.5 times the azimuthal waves that evenly spread points would carry,
    or degree + 1, which resolve anything smooth."""
    basis = ClosedBasis(4, (20, 40))
    noise = basis.fit(RANDOM.uniform(-1, 1, basis.shape))
    modes = np.abs(np.fft.rfft(noise, axis=1))
    for row, colatitude in enumerate(basis.axes()[0]):
        room = int(max(5, 1.5 * 20 * np.sin(colatitude)))
        assert modes[row, room + 1 :].max(initial=0.0) < 1e-12


@pytest.mark.parametrize("degree", [2, 4, 6])
def test_curvature_of_a_sphere(degree):
    """c = 2 and K = 1, to the order degree - 1 between the points and better at them."""
    errors = []
    for n in ROWS:
        sphere = spline_sphere(points=2 * n**2, degree=degree)
        points = between(sphere.basis).points(sphere)
        errors.append(max(abs(points.curvature - 2).max(), abs(points.gaussian - 1).max()))
    assert fitted_order(ROWS, errors) > degree - 1.3


def test_curvature_of_an_ellipsoid():
    """With the axes a_i, s = Σ x_i² / a_i⁴ and p = Π a_i: K = 1 / (p² s²),
    c = (Σ a_i² - |x|²) / (p² s^(3/2)); slope at least 4 at the collocation points, degree 4."""
    axes = np.array([1.6, 1.0, 0.7])
    errors = []
    for n in ROWS:
        spline = spline_ellipsoid(axes, points=2 * n**2)
        points = collocation(spline).points(spline)
        s = (points.position**2 / axes[:, None] ** 4).sum(axis=0)
        square = (points.position**2).sum(axis=0)
        gaussian = 1 / (axes.prod() ** 2 * s**2)
        total = ((axes**2).sum() - square) / (axes.prod() ** 2 * s**1.5)
        errors.append(
            max(abs(points.curvature - total).max(), abs(points.gaussian - gaussian).max())
        )
    assert fitted_order(ROWS, errors) > 3.5
    normal = points.position / axes[:, None] ** 2
    assert points.normal == pytest.approx(normal / np.linalg.norm(normal, axis=0), abs=1e-6)


def test_curvature_of_an_ellipse():
    """κ = ab / (a² sin² t + b² cos² t)^(3/2), positive, with n outwards."""
    errors = []
    for n in ROWS:
        spline = spline_ellipse((2.0, 1.0), points=4 * n)
        points = collocation(spline).points(spline)
        x, y = points.position[0] / 2, points.position[1]
        errors.append(abs(points.curvature - 2 / (4 * y**2 + x**2) ** 1.5).max())
    assert fitted_order(ROWS, errors) > 3.5
    assert ((points.normal * points.position).sum(axis=0) > 0).all()


def test_surface_laplacian_of_spherical_harmonics():
    """Δ_s Y = -l (l + 1) Y on the unit sphere, for l = 3, m = 2."""

    def harmonic(parameters):
        return sph_harm_y(3, 2, *parameters).real

    errors = []
    for n in ROWS:
        sphere = spline_sphere(points=2 * n**2)
        field = sphere.basis.fit(harmonic(sphere.basis.parameters()).reshape(sphere.basis.shape))
        grid = collocation(sphere)
        points = grid.points(sphere)
        errors.append(abs(points.laplacian(field) + 12 * grid.values(field)).max())
    assert fitted_order(ROWS, errors) > 2.5


def test_surface_divergence_theorem():
    """div_s of the position is the dimension of the surface, 2 or 1."""
    for spline in (spline_ellipsoid((1.6, 1, 0.7)), spline_ellipse((2, 1))):
        points = collocation(spline).points(spline)
        divergence = points.divergence(spline.coefficients)
        assert divergence == pytest.approx(spline.dimension - 1, abs=1e-12)


@pytest.mark.parametrize("degree", [2, 3, 4, 5])
def test_patch_is_the_same_surface(degree):
    surface = spline_ellipsoid((1.6, 1, 0.7), degree=degree, pole=0)
    curve = spline_ellipse((2, 1), points=20, degree=degree)
    assert surface.patch().evaluate(*ANYWHERE) == pytest.approx(
        surface.evaluate(ANYWHERE), abs=1e-13
    )
    assert curve.patch().evaluate(ANYWHERE[1]) == pytest.approx(
        curve.evaluate(ANYWHERE[1:]), abs=1e-13
    )
    poles = surface.patch().points[[0, -1]]
    assert np.ptp(poles, axis=1).max() < 1e-14


def test_transpose_of_evaluation():
    for basis in (ClosedBasis(4, (10, 20)), ClosedBasis(3, (12,))):
        grid = between(basis)
        values, coefficients = RANDOM.normal(size=basis.count), RANDOM.normal(size=basis.shape)
        assert (grid.transposed(values) * coefficients).sum() == pytest.approx(
            values @ grid.values(coefficients)
        )


def test_any_shape():
    """A peanut, its radius 1 + 0.4 cos 2θ in polar angle, is met to the splines' accuracy."""

    def peanut(unit):
        return unit * (1 + 0.4 * (2 * unit[-1] ** 2 - 1))

    spline = closed_spline(ClosedBasis(4, (16, 32)), peanut)
    assert spline.evaluate(ANYWHERE) == pytest.approx(peanut(unit_point(*ANYWHERE)), abs=2e-5)
    assert spline_circle(2.0, (1.0, 0.0)).points()[0].max() == pytest.approx(3.0, abs=0.01)


@pytest.mark.parametrize("degree, shape", [(4, (4, 8)), (1, (10, 20)), (4, (10, 21)), (3, (3,))])
def test_too_few_points_are_refused(degree, shape):
    with pytest.raises(ShapeError, match="degree"):
        ClosedBasis(degree, shape)
