"""Identities that plane layers of Laplace's equation and Stokes flow must fulfil.

On a rectangle, an ellipse and a wavy curve, as a wrong sign of the double layer's value at its
own source, the curvature, passes every test on a circle.
"""

import numpy as np
import pytest

from cadbem.boundary import Boundary, Patch
from cadbem.kernels.laplace_2d import LAPLACE_2D, LAPLACE_GRADIENT_2D
from cadbem.kernels.stokes_2d import STOKES_2D, STOKES_PRESSURE_2D
from cadbem.operators.interactions import Targets
from cadbem.operators.layers import assemble_layers, collocation_targets
from cadbem.operators.locate import locate
from cadbem.operators.potentials import Potentials
from cadbem.quadrature import Quadrature
from cadbem.space import Field, discontinuous_space
from cadbem.spline import Nurbs
from cadbem.spline.basis import basis_matrix, greville, open_knots
from cadbem.spline.outlines import ellipse, rectangle

FINE = Quadrature(1e-11)
PAIRS = ((LAPLACE_2D, LAPLACE_GRADIENT_2D), (STOKES_2D, STOKES_PRESSURE_2D))
KERNELS = (LAPLACE_2D, STOKES_2D)
NAMES = ("laplace", "stokes")
MIDDLE = np.random.default_rng(0).uniform(-0.4, 0.4, (2, 30))
DEPTHS = (0.3, 1e-2, 1e-4, 1e-6)


def bounded(*curves) -> Boundary:
    return Boundary(tuple(Patch(c, "", i + 1) for i, c in enumerate(curves)))


def wavy() -> Nurbs:
    """A quintic through r(θ) = 1 + 0.15 cos 3θ + 0.1 sin 2θ, clockwise, so that n is inwards."""
    knots = open_knots(5, np.linspace(0, 1, 13))
    at = greville(5, knots)
    angle = -2 * np.pi * at
    radius = 1 + 0.15 * np.cos(3 * angle) + 0.1 * np.sin(2 * angle)
    through = radius * np.array([np.cos(angle), np.sin(angle)])
    points = np.linalg.solve(basis_matrix(5, knots, at), through.T)
    points[-1] = points[0]
    return Nurbs((5,), (knots,), points, np.ones(len(points)))


RECTANGLE = bounded(*rectangle((-1, -0.5), (1, 0.5)))
ELLIPSE = bounded(*ellipse((1.5, 0.7), inwards=True))
WAVY = bounded(wavy())
SHAPES = [RECTANGLE.elevated(2).refined(2), ELLIPSE.elevated(3).refined(2), WAVY]
IDS = ("rectangle", "ellipse", "wavy")


def near_wall(boundary, depth, shares=(0.37, 0.81, 0.97)):
    """Points at a depth (negative: outside) below odd places of every patch: (2, N)."""
    spots = []
    for patch in boundary.patches:
        ((low, high),) = patch.surface.domain
        for share in shares:
            d = patch.surface.derivatives(1, low + share * (high - low))
            normal = np.array([d[(1,)][1], -d[(1,)][0]])
            spots.append(d[(0,)] + depth * normal / np.linalg.norm(normal))
    return np.array(spots).T


def singularity(kernel, x, n):
    """Value, what belongs to it on a line with normal n, and gradient or pressure, of a source
    outside: -ln r, ∂φ/∂n and ∇φ; a point force 4π, f = σ·n and p."""
    source, force = np.array([[1.9], [1.6]]), np.array([0.3, -1.0])
    r = x - source
    square = (r**2).sum(axis=0)
    if kernel is LAPLACE_2D:
        gradient = -r / square
        return -0.5 * np.log(square)[None], (gradient * n).sum(axis=0)[None], gradient
    along = force @ r
    velocity = -0.5 * np.log(square) * force[:, None] + along * r / square
    traction = -4 * along * (r * n).sum(axis=0) * r / square**2
    return velocity, traction, 2 * along[None] / square


@pytest.mark.parametrize("boundary", SHAPES, ids=IDS)
@pytest.mark.parametrize("kernel", KERNELS, ids=NAMES)
def test_constant_density_under_the_double_layer(kernel, boundary):
    """2π inside, π on, 0 outside for Laplace, twice that (times I) for Stokes, n inwards; at any
    distance from the curve down to 1e-6 (divergence theorem)."""
    assert kernel.free_term == pytest.approx(np.pi * kernel.components)
    space = discontinuous_space(boundary)
    layers = assemble_layers(kernel, space, collocation_targets(space), FINE)
    for axis in range(kernel.components):
        one = np.zeros((kernel.components, space.count))
        one[axis] = 1.0
        assert abs(layers.apply(0 * one, one) - kernel.free_term * one).max() < 1e-10
        for depth in DEPTHS:
            for side, exact in ((depth, 2 * kernel.free_term), (-depth, 0.0)):
                targets = Targets.free(near_wall(boundary, side))
                value = Potentials(kernel, space, targets, FINE).apply(0 * one, one)
                value[axis] -= exact
                assert abs(value).max() < max(1e-10, 1e-15 / depth)


@pytest.mark.parametrize("depth", [*DEPTHS, 0.0])
def test_stokes_single_layer_of_the_normal(depth):
    """∮ G n ds = 0 inside, outside and on: the pressure of a closed curve moves nothing.

    The normal is a spline on the rectangle; on the ellipse it is one nearly."""
    bent = ELLIPSE.elevated(8).refined(20)
    for boundary, bound in ((RECTANGLE.refined(2), 1e-11), (bent, 1e-9)):
        space = discontinuous_space(boundary)
        single = space.interpolate(space.collocation.normal)
        sides = [Targets.free(near_wall(boundary, side)) for side in (depth, -depth)]
        targets = sides if depth else [collocation_targets(space)]
        for target in targets:
            value = Potentials(STOKES_2D, space, target, FINE).apply(single, 0 * single)
            assert abs(value).max() < bound


@pytest.mark.parametrize("degree", [2, 3, 4])
@pytest.mark.parametrize(("kernel", "companion"), PAIRS, ids=NAMES)
def test_greens_identity_with_a_source_outside(kernel, companion, degree):
    """Values, and gradient or pressure, inside an ellipse from the boundary data of a source
    outside converge (root mean square) with the order of the spline, degree + 1; values do so up
    to 1e-6 of the curve."""
    places = np.random.default_rng(2).uniform(0, 1, 20)
    close = np.concatenate([near_wall(ELLIPSE, d, places) for d in (0.3, 1e-3, 1e-6)], axis=1)
    exact = singularity(kernel, close, 0 * close)[0]
    exact_companion = singularity(kernel, MIDDLE, 0 * MIDDLE)[2]
    errors, sizes = [], [12, 16, 24, 32]
    for spans in sizes:
        space = discontinuous_space(ELLIPSE.elevated(degree).refined(spans))
        points = space.collocation
        values, fluxes, _ = singularity(kernel, points.position, points.normal)
        single, double = space.interpolate(-fluxes), space.interpolate(values)
        inside = 2 * kernel.free_term
        ours = Potentials(kernel, space, Targets.free(close), FINE).apply(single, double) / inside
        sign = 1 if kernel is LAPLACE_2D else -1
        inner = Potentials(companion, space, Targets.free(MIDDLE), FINE)
        other = inner.apply(sign * single, double)
        gaps = ours - exact, other / inside - exact_companion
        errors.append([np.sqrt((gap**2).mean()) for gap in gaps])
    slopes = -np.polyfit(np.log(sizes), np.log(errors), 1)[0]
    assert slopes.min() > degree + 0.8


@pytest.mark.parametrize("kernel", KERNELS, ids=NAMES)
def test_outside_the_identity_gives_zero(kernel):
    """The same data at points outside, from 1 to 1e-6 away."""
    space = discontinuous_space(ELLIPSE.elevated(8).refined(20))
    values, fluxes, _ = singularity(kernel, space.collocation.position, space.collocation.normal)
    single, double = space.interpolate(-fluxes), space.interpolate(values)
    for depth in (1.0, *DEPTHS):
        targets = Targets.free(near_wall(ELLIPSE, -depth))
        assert abs(Potentials(kernel, space, targets, FINE).apply(single, double)).max() < 5e-9


@pytest.mark.parametrize("kernel", KERNELS, ids=NAMES)
def test_two_sides_of_the_curve(kernel):
    """Across a wavy curve the double layer of any density jumps by 2 free terms times the
    density, the single layer not at all; the mean of both sides is the value on the curve."""
    space = discontinuous_space(WAVY)
    x = space.collocation.position
    density = space.interpolate(np.array([np.cos(x[0]), np.sin(x[1])])[: kernel.components])
    at = (0.37, 0.81, 0.97)
    on = Targets(near_wall(WAVY, 0.0, at), np.zeros(3, dtype=np.int64), np.array([at]))
    jump = 2 * kernel.free_term * Field(space, density).on_patch(0, at)
    for single, double in ((density, 0 * density), (0 * density, density)):
        sides = [Targets.free(near_wall(WAVY, depth, at)) for depth in (1e-8, -1e-8)]
        inner, outer, value = (
            Potentials(kernel, space, at, FINE).apply(single, double) for at in (*sides, on)
        )
        assert abs(inner - outer - (jump if double.any() else 0)).max() < 5e-7
        assert abs(0.5 * (inner + outer) - value).max() < 1e-7


def test_a_flow_that_the_space_holds_exactly():
    """u = (y², 0), p = 2x, μ = 1 in a rectangle: 2πu + S f - D u = 0, and harmonic
    φ = x² - y²: πφ + S ∂φ/∂n - D φ = 0."""
    space = discontinuous_space(RECTANGLE.elevated(2).refined(size=0.1))
    (x, y), n = space.collocation.position, space.collocation.normal
    u = np.array([y**2, 0 * x])
    f = np.array([-2 * x * n[0] + 2 * y * n[1], 2 * y * n[0] - 2 * x * n[1]])
    phi, slope = (x**2 - y**2)[None], (2 * x * n[0] - 2 * y * n[1])[None]
    for kernel, values, fluxes in ((STOKES_2D, u, f), (LAPLACE_2D, phi, slope)):
        layers = assemble_layers(kernel, space, collocation_targets(space), FINE)
        left = kernel.free_term * values
        left -= layers.apply(-space.interpolate(fluxes), space.interpolate(values))
        assert abs(left).max() / kernel.free_term < 1e-11


@pytest.mark.parametrize("kernel", KERNELS, ids=NAMES)
def test_matrices_and_potentials_agree_under_rotation_and_translation(kernel):
    """Layers turn with the curve: Q S(x) Qᵀ, and the same from the matrix-free way.

    Both are of functions, so no constant enters with the logarithm."""
    rng = np.random.default_rng(3)
    cosine, sine = np.cos(0.7), np.sin(0.7)
    turn, shift = np.array([[cosine, -sine], [sine, cosine]]), np.array([3.0, -2.0])
    moved = Boundary(tuple(Patch(p.surface.transformed(turn, shift)) for p in SHAPES[1].patches))
    here, there = discontinuous_space(SHAPES[1]), discontinuous_space(moved)
    single, double = rng.normal(size=(2, kernel.components, here.count))
    points = np.concatenate([MIDDLE, near_wall(ELLIPSE, 1e-3)], axis=1)
    first = assemble_layers(kernel, here, Targets.free(points), FINE).apply(single, double)
    second = Potentials(kernel, here, Targets.free(points), FINE).apply(single, double)
    assert second == pytest.approx(first, abs=1e-12 * abs(first).max())
    frame = turn if kernel.components == 2 else np.eye(1)
    targets = Targets.free(turn @ points + shift[:, None])
    third = Potentials(kernel, there, targets, FINE).apply(frame @ single, frame @ double)
    assert frame.T @ third == pytest.approx(first, abs=1e-9 * abs(first).max())


def test_points_on_a_curve_are_found():
    points = np.concatenate([near_wall(ELLIPSE, 0.0), near_wall(ELLIPSE, 1e-5)], axis=1)
    owner, parameters = locate(ELLIPSE, points)
    assert list(owner) == [0] * 3 + [1] * 3 + [2] * 3 + [3] * 3 + [-1] * 12
    assert parameters[:, :12] == pytest.approx(np.tile([[0.37, 0.81, 0.97]], 4), abs=1e-8)
