"""Identities of the layers of Laplace's equation on a curved closed surface."""

import numpy as np
import pytest
from shapes import bulged
from test_operators import INSIDE, OUTSIDE, near_wall

from cadbem.kernels.laplace_3d import LAPLACE_3D
from cadbem.operators.interactions import Targets
from cadbem.operators.layers import assemble_layers, collocation_targets
from cadbem.operators.potentials import Potentials
from cadbem.quadrature import Quadrature
from cadbem.space import discontinuous_space

FINE = Quadrature(1e-12)
SPACE = discontinuous_space(bulged().elevated(2).refined(2))
ONE = np.ones((1, SPACE.count))


def test_constant_density():
    """∮ ∂G/∂n dS = 4π inside, 2π on, 0 outside, for n inwards (Gauss), at any distance."""
    on = assemble_layers(LAPLACE_3D, SPACE, collocation_targets(SPACE), FINE)
    assert abs(on.apply(0 * ONE, ONE) - 2 * np.pi).max() < 1e-10
    for points, exact in (
        (INSIDE, 4 * np.pi), (OUTSIDE, 0.0),
        (near_wall(SPACE.boundary, 1e-5), 4 * np.pi), (near_wall(SPACE.boundary, -1e-5), 0.0),
    ):  # fmt: skip
        value = Potentials(LAPLACE_3D, SPACE, Targets.free(points), FINE).apply(0 * ONE, ONE)
        assert abs(value - exact).max() < 1e-9


def test_single_layer_is_continuous():
    """Its values 1e-7 to either side of the wall differ by 4π 2e-7 at most, for density 1."""
    sides = [
        Potentials(LAPLACE_3D, SPACE, Targets.free(points), FINE).apply(ONE, 0 * ONE)
        for points in (near_wall(SPACE.boundary, d) for d in (1e-7, -1e-7))
    ]
    assert abs(sides[0] - sides[1]).max() < 4 * np.pi * 2.1e-7


@pytest.mark.parametrize("degree", [2, 3])
def test_greens_identity_with_a_source_outside(degree):
    """φ = 1/|x - a|: 4π φ = -∫ G ∂φ/∂n + ∫ φ ∂G/∂n inside, with the order of the spline."""
    source = np.array([[3.0], [2.5], [2.0]])
    middle = np.random.default_rng(0).uniform(-0.9, 0.9, (3, 40))
    points = np.concatenate([middle, INSIDE, near_wall(SPACE.boundary, 1e-3)], axis=1)
    exact = 1 / np.linalg.norm(points - source, axis=0)
    errors, sizes = [], [6, 8, 12, 16]
    for spans in sizes:
        space = discontinuous_space(bulged().elevated(degree).refined(spans))
        r = space.collocation.position - source
        size = np.linalg.norm(r, axis=0)
        slope = -(r * space.collocation.normal).sum(axis=0) / size**3
        single, double = space.interpolate(-slope[None]), space.interpolate(1 / size[None])
        value = Potentials(LAPLACE_3D, space, Targets.free(points), FINE).apply(single, double)[0]
        errors.append(np.sqrt(((value / (4 * np.pi) - exact) ** 2).mean()))
    assert -np.polyfit(np.log(sizes), np.log(errors), 1)[0] > degree + 0.8
