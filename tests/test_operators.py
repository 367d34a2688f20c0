"""Identities that the layers of Stokes flow must fulfil, on flat and curved closed surfaces."""

import numpy as np
import pytest
from shapes import bulged, channel

from cadbem.boundary import Boundary, Patch
from cadbem.elements.shape import lengths
from cadbem.kernels.stokes_3d import STOKES_3D, STOKES_PRESSURE_3D
from cadbem.operators.interactions import Targets
from cadbem.operators.layers import assemble_layers, collocation_targets
from cadbem.operators.locate import locate
from cadbem.operators.potentials import Potentials
from cadbem.quadrature import Quadrature
from cadbem.space import discontinuous_space
from cadbem.spline.shapes import cylinder

FINE = Quadrature(1e-12)
SMALL = bulged().elevated(2).refined(2)
INSIDE = np.array([[0.1, 0.9, 0.0], [0.2, 0.95, 0.0], [-0.3, 0.97, 1.1]])
OUTSIDE = np.array([[1.5, 0.0, 4.0], [0.0, 1.01, 0.0], [0.0, 1.01, -2.0]])


def near_wall(boundary, depth):
    """Points at a depth (negative: outside) below odd places of every patch: (3, N)."""
    spots = []
    for patch in boundary.patches:
        (u0, u1), (v0, v1) = patch.surface.domain
        d = patch.surface.derivatives(1, u0 + 0.37 * (u1 - u0), v0 + 0.81 * (v1 - v0))
        normal = np.cross(d[1, 0], d[0, 1])
        spots.append(d[0, 0] + depth * normal / np.linalg.norm(normal))
    return np.array(spots).T


def stokeslet(x, source, force):
    """Velocity and stress (3, 3, N) of a point force 8π at a source, viscosity 1."""
    r = x - np.reshape(source, (3, 1))
    d = np.linalg.norm(r, axis=0)
    along = force @ r
    velocity = force[:, None] / d + along * r / d**3
    stress = -6 * along * r[:, None] * r[None] / d**5
    return velocity, stress, 2 * along / d**3


@pytest.mark.parametrize(
    "boundary", [SMALL, channel().elevated(2).refined(3)], ids=["curved", "flat"]
)
def test_constant_density_under_the_double_layer(boundary):
    """∫ T·n dS = 8π I inside, 4π I on, 0 outside, for n inwards (divergence theorem)."""
    space = discontinuous_space(boundary)
    layers = assemble_layers(STOKES_3D, space, collocation_targets(space), FINE)
    for axis in range(3):
        density = np.zeros((3, space.count))
        density[axis] = 1.0
        exact = np.zeros((3, space.count))
        exact[axis] = 4 * np.pi
        assert abs(layers.apply(0 * density, density) - exact).max() < 1e-10


@pytest.mark.parametrize("depth", [0.3, 1e-2, 1e-4, 1e-6])
def test_jump_of_the_double_layer_and_continuity_of_the_single_layer(depth):
    """Across the surface, at any distance: 8π I inside, 0 outside; ∫ G n dS = 0 on both sides.

    The normal is no spline, so it enters through the flat channel, where it is."""
    space = discontinuous_space(SMALL)
    one = np.zeros((3, space.count))
    one[0] = 1.0
    for side, exact in ((depth, 8 * np.pi), (-depth, 0.0)):
        targets = Targets.free(near_wall(SMALL, side))
        value = Potentials(STOKES_3D, space, targets, FINE).apply(0 * one, one)
        assert abs(value[0] - exact).max() < 1e-8
        assert abs(value[1:]).max() < 1e-8
    flat = discontinuous_space(channel().elevated(2).refined(2))
    for side in (depth, -depth):
        targets = Targets.free(near_wall(flat.boundary, side))
        at_targets = Potentials(STOKES_3D, flat, targets, FINE)
        value = at_targets.apply(flat.collocation.normal, np.zeros((3, flat.count)))
        assert abs(value).max() < 1e-9


def test_a_flow_that_the_space_holds_exactly():
    """u = (y², 0, 0), p = 2x, μ = 1 in the square channel, f = σ·n: 4πu + S f - D u = 0 at the
    thesis's 846 points."""
    boundary = channel().elevated(2).refined(size=(2 / 17, 1 / 7, 1 / 7))
    space = discontinuous_space(boundary)
    assert space.count == 846
    x, n = space.collocation.position, space.collocation.normal
    zero = 0 * x[0]
    u = np.array([x[1] ** 2, zero, zero])
    p, shear = 2 * x[0], 2 * x[1]
    stress = np.array([[-p, shear, zero], [shear, -p, zero], [zero, zero, -p]])
    f = np.einsum("ijn,jn->in", stress, n)
    layers = assemble_layers(STOKES_3D, space, collocation_targets(space), FINE)
    left = 4 * np.pi * u - layers.apply(-space.interpolate(f), space.interpolate(u))
    assert abs(left).max() / (4 * np.pi) < 1e-11


@pytest.mark.parametrize("degree", [2, 3, 4])
def test_greens_identity_with_a_source_outside(degree):
    """A Stokeslet outside: from its boundary data the velocity inside (up to 1e-3 of the wall)
    converges with the order of the spline, degree + 1, and the pressure, a derivative of
    velocity, at least with one less (root mean squares)."""
    source, force = np.array([3.0, 2.5, 2.0]), np.array([0.3, -1.0, 0.5])
    middle = np.random.default_rng(0).uniform(-0.9, 0.9, (3, 40))
    points = np.concatenate([middle, INSIDE, near_wall(SMALL, 1e-3)], axis=1)
    exact, _, pressure = stokeslet(points, source, force)
    errors, sizes = [], [4, 6, 8]
    for spans in sizes:
        space = discontinuous_space(bulged().elevated(degree).refined(spans))
        x, n = space.collocation.position, space.collocation.normal
        u, stress, _ = stokeslet(x, source, force)
        f = np.einsum("ijn,jn->in", stress, n)
        single, double = space.interpolate(-f), space.interpolate(u)
        targets = Targets.free(points)
        ours = Potentials(STOKES_3D, space, targets, FINE).apply(single, double) / (8 * np.pi)
        at_targets = Potentials(STOKES_PRESSURE_3D, space, targets, FINE)
        ours_pressure = at_targets.apply(-single, double)[0]
        gaps = ours - exact, (ours_pressure / (8 * np.pi) - pressure)[:40]
        errors.append([np.sqrt((gap**2).mean()) for gap in gaps])
    slopes = -np.polyfit(np.log(sizes), np.log(errors), 1)[0]
    assert slopes[0] > degree + 0.8
    assert slopes[1] > degree


def test_outside_the_identity_gives_zero():
    """The same data at points outside the fluid: nothing, to the accuracy of the splines."""
    space = discontinuous_space(bulged().elevated(5).refined(4))
    u, stress, _ = stokeslet(space.collocation.position, [1.8, 1.5, 1.4], np.array([0, 1.0, 0]))
    f = np.einsum("ijn,jn->in", stress, space.collocation.normal)
    outside = Potentials(STOKES_3D, space, Targets.free(OUTSIDE), FINE)
    value = outside.apply(space.interpolate(-f), space.interpolate(u))
    assert abs(value).max() / (8 * np.pi) < 1e-5 * abs(u).max()


def test_matrices_and_potentials_agree_under_rotation_and_translation():
    """Layers turn with the surface: Q S(x) Qᵀ, and the same from the matrix-free way."""
    rng = np.random.default_rng(3)
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    turn *= np.sign(np.linalg.det(turn))
    shift = np.array([3.0, -2.0, 1.0])
    moved = Boundary(tuple(Patch(p.surface.transformed(turn, shift)) for p in SMALL.patches))
    single, double = rng.normal(size=(2, 3, discontinuous_space(SMALL).count))
    points = np.concatenate([INSIDE, near_wall(SMALL, 1e-3)], axis=1)
    here, there = discontinuous_space(SMALL), discontinuous_space(moved)
    first = assemble_layers(STOKES_3D, here, Targets.free(points), FINE).apply(single, double)
    second = Potentials(STOKES_3D, here, Targets.free(points), FINE).apply(single, double)
    assert second == pytest.approx(first, abs=1e-12 * abs(first).max())
    at_targets = Targets.free(turn @ points + shift[:, None])
    third = Potentials(STOKES_3D, there, at_targets, FINE).apply(turn @ single, turn @ double)
    assert turn.T @ third == pytest.approx(first, abs=1e-9 * abs(first).max())


def test_points_on_the_boundary_are_found():
    points = np.concatenate([near_wall(SMALL, 0.0), near_wall(SMALL, 1e-5)], axis=1)
    owner, parameters = locate(SMALL, points)
    assert list(owner) == [0, 1, 2, 3, 4, 5, -1, -1, -1, -1, -1, -1]
    assert parameters[:, :6] == pytest.approx(np.tile([[0.37], [0.81]], 6), abs=1e-8)


@pytest.mark.parametrize("side", [-np.inf, np.inf])
def test_points_a_rounding_error_off_a_panels_border(side):
    """A quarter of a cylinder, 0.008 long, is two panels, on whose border the middle points lie:
    whether they are rounded off it must not matter."""
    wall = cylinder(1.0, 4.0)[0]
    long = int(np.argmax(lengths(wall)))
    bounds = list(wall.domain)
    low, high = bounds[long]
    bounds[long] = (low, low + 0.002 * (high - low))
    space = discontinuous_space(Boundary((Patch(wall.restricted(*bounds).elevated((4, 4))),)))
    targets = collocation_targets(space)
    around = targets.parameters.copy()
    middle = 0.5 * sum(wall.domain[1 - long])
    on = abs(around[1 - long] - middle) < 1e-9
    around[1 - long, on] = np.nextafter(middle, side)
    shifted = Targets(targets.position, targets.owner, around)
    exact, found = (
        assemble_layers(STOKES_3D, space, t, Quadrature(1e-7)).entries for t in (targets, shifted)
    )
    assert on.any()
    assert np.isfinite(found).all()
    np.testing.assert_allclose(found, exact, rtol=0, atol=1e-8 * abs(exact).max())
