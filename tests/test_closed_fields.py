"""Layers of closed splines off themselves, and the velocity in and around droplets."""

from types import SimpleNamespace

import numpy as np
import pytest
from test_closed_layers import layers_of, stokeslet, wavy

import cadbem as cb
from cadbem.operators.closed.field import OffSurface
from cadbem.operators.closed.nearest import nearest_points, signed_distance
from cadbem.quadrature.closed import PolarRule


@pytest.mark.parametrize("dimension, n, tolerance", [(2, 14, 2e-5), (3, 14, 2e-4)])
def test_greens_representation_at_any_distance(dimension, n, tolerance):
    """The flow of a point force outside: (S[σ·n] - D[u]) / 2h is u inside and 0 outside, from
    half a radius to a ten-thousandth of it."""
    layers = layers_of(wavy(dimension, n), PolarRule(1e-6))
    basis, at = layers.operator.basis, layers.targets
    source = np.array([1.5, 1.2, 0.9])[:dimension]
    strength = np.array([0.3, -1.0, 0.7])[:dimension]
    velocity, _, sums = stokeslet(source, strength, at.position, at.normal)
    double = basis.fit(velocity.reshape(-1, *basis.shape))
    single = stokeslet(source, strength, layers.points.position, layers.points.normal)[1]
    some = slice(3, None, at.position.shape[1] // 6)
    for depth in (0.5, 0.1, 1e-2, 1e-4):
        for side in (-1, 1):
            points = at.position[:, some] + side * depth * at.normal[:, some]
            result = OffSurface(layers, points).apply(single, -double) / (2 * sums.free_term)
            exact = stokeslet(source, strength, points, points)[0] if side < 0 else 0.0
            assert np.abs(result - exact).max() < tolerance


@pytest.mark.parametrize("ratio", [0.2, 5.0])
@pytest.mark.parametrize("dimension", [2, 3])
def test_linear_flow_through_an_interface(dimension, ratio):
    """With Δf = 2 (1 - λ) E·n a linear flow is undisturbed inside and outside."""
    flow = cb.shear(dimension=dimension)
    strain = flow.gradient(np.zeros((dimension, 1)))[..., 0]
    strain = (strain + strain.T) / 2

    def jump(points):
        return 2 * (1 - ratio) * strain @ points.normal

    law = SimpleNamespace(close=lambda layers, velocity_response: (velocity_response(jump), jump))
    shape = wavy(dimension, 14)
    run = cb.Simulation(cb.FreeFlow(flow), cb.Droplet(shape, law, ratio))
    state = run.start
    points = np.random.default_rng(0).uniform(-2, 2, (dimension, 40))
    assert state.velocity_at(points) == pytest.approx(flow.velocity(points), abs=3e-4)


def test_inside_and_nearest():
    """An ellipse and an ellipsoid with their poles; (x/a)² + ... < 1 inside."""
    random = np.random.default_rng(1)
    for axes in ((2.0, 0.7), (1.6, 1.0, 0.7)):
        shape = cb.spline_ellipsoid(axes, points=200)
        points = random.uniform(-2, 2, (len(axes), 200))
        exact = ((points / np.reshape(axes, (-1, 1))) ** 2).sum(axis=0) < 1
        assert ((signed_distance(shape, points) < 0) == exact).all()
        beyond = np.zeros((len(axes), 1))
        beyond[-1] = 1.0
        foot = shape.evaluate(nearest_points(shape, beyond))
        assert foot[-1] == pytest.approx(axes[-1], abs=1e-4)
