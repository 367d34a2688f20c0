"""Bodies seen from afar, by equivalent sources instead of all their nodes."""

from dataclasses import replace

import numpy as np
import pytest
from test_closed_layers import stokeslet, wavy

import cadbem as cb
from cadbem.operators.far.equivalent import Expansion, Sources, ball_around, point_sources
from cadbem.operators.far.interactions import FarInteractions, TargetCluster, target_clusters
from cadbem.quadrature.closed import PolarRule
from cadbem.suspension.multibody.multibody import velocity_responses


def directions(dimension: int, count: int, seed: int = 0) -> np.ndarray:
    random = np.random.default_rng(seed).normal(size=(dimension, count))
    return random / np.linalg.norm(random, axis=0)


def nodes(dimension: int, centre, size: float) -> Sources:
    """A wavy body with smooth densities of both layers that have a net force and a net flux."""
    shape = wavy(dimension, 14)
    middle = np.reshape(centre, (-1, *[1] * (shape.coefficients.ndim - 1)))
    body = cb.Droplet(
        cb.ClosedSpline(shape.basis, size * shape.coefficients + middle), cb.SurfaceTension(1.0)
    ).placed(PolarRule())
    c = shape.coefficients
    force = body.layers.operator.grid.values(np.stack([*c[1:], 1 + c[0] * c[1]]))
    return body.sources((force, c + 0.5 * c[::-1] ** 2))


@pytest.mark.parametrize("dimension", [2, 3])
def test_error_falls_exponentially_with_the_order(dimension):
    """From 2.5 radii on, harmonics of order p fall at least like 2.5^-p, apart from their
    strengths; outgoing and incoming alike, by the symmetry of G."""
    centre = np.array([3.0, -1.0, 2.0])[:dimension]
    body = nodes(dimension, centre, 0.3)
    ball = ball_around(body.position)
    far = np.ascontiguousarray(ball.world(2.5 * directions(dimension, 200)))
    exact = np.zeros_like(far)
    body.add_to(far, exact)
    inside = np.ascontiguousarray(directions(dimension, 200) * 0.99)
    beyond = np.ascontiguousarray(2.5 * directions(dimension, 20, 1))
    outside = Sources(beyond, np.ones_like(beyond))
    felt = np.zeros_like(inside)
    outside.add_to(inside, felt)
    orders, errors = np.arange(4, 13, 2), []
    for order in orders:
        expansion = Expansion(dimension, int(order), 2.5)
        unit = body.in_units_of(ball)
        found, received = np.zeros_like(far), np.zeros_like(inside)
        strengths = expansion.equivalent(unit)
        Sources(ball.world(expansion.inner), strengths).add_to(far, found)
        point_sources(ball.centre[:, None], np.array([body.flux])).add_to(far, found)
        velocity = np.zeros_like(expansion.inner)
        outside.add_to(expansion.inner, velocity)
        Sources(expansion.outer, expansion.incoming(velocity)).add_to(inside, received)
        errors.append(
            [np.abs(found - exact).max() / np.abs(exact).max(),
             np.abs(received - felt).max() / np.abs(felt).max()]
        )  # fmt: skip
    slopes = np.polyfit(orders, np.log(errors), 1)[0]
    assert (slopes < -0.9 * np.log(2.5)).all()
    assert errors[-1][0] < 1e-6 and errors[-1][1] < 1e-3


def shell_flow(force: np.ndarray, radius: float, arm: np.ndarray) -> np.ndarray:
    """(G + R²/6 ∇²G) F: what a force makes that is spread evenly over a sphere."""
    square = (arm**2).sum(axis=0)
    along = (arm * force[:, None]).sum(axis=0)
    laplacian = 2 * force[:, None] / square**1.5 - 6 * arm * along / square**2.5
    return stokeslet(np.zeros(3), force, arm, arm)[0] + radius**2 / 6 * laplacian


def test_a_shell_of_force_and_a_shell_of_sources():
    """A sphere with q = F / (4πR²) and u = n; the double layer of n is 8πR² (x - c) / |x - c|³, as
    n n is I / 3 in the mean.  Two more bodies that make nothing, and clusters at all distances."""
    radius, centre, force = 0.7, np.array([1.0, 2.0, -1.0]), np.array([0.3, -1.0, 0.5])
    body = cb.Droplet(cb.spline_sphere(radius, centre, points=800), cb.SurfaceTension(1.0)).placed(
        PolarRule(1e-9)
    )
    area = 4 * np.pi * radius**2
    shape = body.layers.spline.coefficients
    density = np.repeat(force[:, None] / area, body.samples.shape[1], axis=1)
    source = body.sources((density, (shape - centre[:, None, None]) / radius))
    reach = np.random.default_rng(0).uniform(0.4, 3.5, 3000)
    points = centre[:, None] + radius * np.exp(reach) * directions(3, 3000)
    ball = ball_around(source.position)
    clusters = target_clusters(points)
    interactions = FarInteractions(cb.FarField().expansions(3), [ball] * 3, points, clusters)
    found = interactions.apply([1], lambda i: source)
    arm = points - centre[:, None]
    exact = shell_flow(force, radius, arm)
    exact += 2 * area * arm / np.linalg.norm(arm, axis=0) ** 3
    seen = np.setdiff1d(np.arange(3000), interactions.near(1))
    assert 2000 < len(seen) < 2900
    assert np.abs(found - exact)[:, seen].max() < 1e-6 * np.abs(exact).max() * np.e
    assert not found[:, interactions.near(1)].any()


def test_a_pushed_sphere_from_afar():
    """A rigid sphere moves with F / (6πμR) and makes (G + R²/6 ∇²G) F / 8πμ outside."""
    force = np.array([0.0, 1.0, 2.0])
    ball = replace(cb.rigid_sphere(0.5, (1.0, 0.0, 0.0), spans=1), force=force)
    state = cb.Simulation(cb.FreeFlow(cb.at_rest(), 2.0), ball).start
    points = np.array([[1.0], [0.0], [0.0]]) + directions(3, 600) * np.linspace(0.6, 8.0, 600)
    exact = shell_flow(force, 0.5, points - [[1.0], [0.0], [0.0]]) / (16 * np.pi)
    assert state.velocity_at(points) == pytest.approx(exact, abs=1e-5 * np.abs(exact).max())


def suspension(dimension: int, ratio: float) -> list:
    """20 bodies on a skewed lattice with gaps from 0.1 diameters on, of two kinds in 3D."""
    grid = (5, 4) if dimension == 2 else (3, 3, 2)
    skew = np.eye(dimension) + 0.1 * np.eye(dimension, k=1)
    bodies = []
    for i, place in enumerate(np.ndindex(*grid)):
        centre = 2.6 * skew @ np.array(place)
        axes = np.roll((1.2, 1.0, 0.8)[:dimension], i)
        shape = cb.spline_ellipsoid(axes, centre, points=32 if dimension == 2 else 72)
        bodies.append(cb.Droplet(shape, cb.SurfaceTension(1.0), ratio))
    if dimension == 3:
        sphere = cb.rigid_sphere(0.8, spans=1)
        turn = [0.0, 0.0, 0.0, 1.0]
        bodies += [sphere.at(np.array([x, -3.0, 1.0, *turn])) for x in (0.0, 3.0)]
    return bodies


@pytest.mark.parametrize("dimension, ratio", [(2, 5.0), (3, 1.0), (3, 5.0)])
def test_many_bodies_against_direct_sums(dimension, ratio):
    """All velocities to a few times the far fields' tolerance, relative to the fastest."""
    placed = [b.placed(PolarRule()) for b in suspension(dimension, ratio)]
    flow = cb.FreeFlow(cb.shear(dimension=dimension))

    def velocities(far):
        return np.concatenate(
            [r.velocity.ravel() for r in velocity_responses(flow, placed, far=far)]
        )

    exact = velocities(None)
    for tolerance in (1e-4, 1e-6, 1e-8):
        error = np.abs(velocities(cb.FarField(tolerance)) - exact).max() / np.abs(exact).max()
        assert 0 < error < 2 * tolerance


def test_target_clusters():
    """Each point is in one cluster, and clusters are compact."""
    points = np.random.default_rng(0).uniform(0, 1, (3, 5000))
    clusters = target_clusters(points, first=7)
    assert (np.sort(np.concatenate([c.numbers for c in clusters])) == 7 + np.arange(5000)).all()
    assert max(len(c.numbers) for c in clusters) <= 128
    volume = sum(np.prod(np.ptp(points[:, c.numbers - 7], axis=1)) for c in clusters)
    assert volume < 1.0
    alone = FarInteractions((), [], points, [TargetCluster(np.arange(5000))])
    assert not alone.apply([], lambda i: Sources(points)).any()


def test_impossible_tolerances_are_refused():
    with pytest.raises(cb.InputError, match="from 1e-09 to 0.01"):
        cb.FarField(0.5)
