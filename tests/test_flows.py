"""Background flows against their formulas, and Stokes' equations by differences."""

from dataclasses import replace

import numpy as np
import pytest

from cadbem.errors import ConditionError, InputError
from cadbem.suspension.surroundings.flows import (
    PolynomialFlow,
    UserFlow,
    at_rest,
    linear_flow,
    pipe_poiseuille,
    plane_extension,
    plane_poiseuille,
    shear,
    uniaxial_extension,
)

X, Y, Z = np.random.default_rng(0).normal(size=(3, 20))
SPACE, PLANE = np.stack([X, Y, Z]), np.stack([X, Y])
OFF_CENTRE = replace(plane_poiseuille(2.0, 1.5), about=np.array([0.3, -1.0, 0.2]))
FLOWS = [
    shear(2.0),
    shear(2.0, 2),
    plane_extension(0.7),
    plane_extension(0.7, 2),
    uniaxial_extension(3.0),
    at_rest(),
    linear_flow([[1, 2], [3, -1]], about=(1, 2), drift=(0.5, -2)),
    plane_poiseuille(2.0, 1.5),
    plane_poiseuille(2.0, 1.5, 2),
    pipe_poiseuille(2.0, 1.5),
    OFF_CENTRE,
]


def points_of(flow):
    return SPACE if flow.drift.size == 3 else PLANE


def test_formulas():
    zero = 0 * X
    cases = [
        (shear(2.0), [2 * Z, zero, zero]),
        (shear(2.0, 2), [2 * Y, zero]),
        (plane_extension(0.7), [0.7 * X, zero, -0.7 * Z]),
        (plane_extension(0.7, 2), [0.7 * X, -0.7 * Y]),
        (uniaxial_extension(3.0), [3 * X, -1.5 * Y, -1.5 * Z]),
        (at_rest(2), [zero, zero]),
        (linear_flow([[1, 2], [3, -1]], (1, 2), (0.5, -2)),
         [0.5 + (X - 1) + 2 * (Y - 2), -2 + 3 * (X - 1) - (Y - 2)]),
        (plane_poiseuille(2.0, 1.5), [2 * (1 - (Z / 1.5) ** 2), zero, zero]),
        (plane_poiseuille(2.0, 1.5, 2), [2 * (1 - (Y / 1.5) ** 2), zero]),
        (pipe_poiseuille(2.0, 1.5), [2 * (1 - (Y**2 + Z**2) / 1.5**2), zero, zero]),
        (OFF_CENTRE, [2 * (1 - ((Z - 0.2) / 1.5) ** 2), zero, zero]),
    ]  # fmt: skip
    for flow, expected in cases:
        np.testing.assert_allclose(flow.velocity(points_of(flow)), expected, atol=1e-14)


def test_poiseuille_pressure():
    """dp/dx = μ Δu: -2 peak / w² between plates, -4 peak / R² in a pipe."""
    np.testing.assert_allclose(plane_poiseuille(2.0, 1.5).pressure(SPACE), -4 / 1.5**2 * X)
    np.testing.assert_allclose(plane_poiseuille(2.0, 1.5, 2).pressure(PLANE), -4 / 1.5**2 * X)
    np.testing.assert_allclose(pipe_poiseuille(2.0, 1.5).pressure(SPACE), -8 / 1.5**2 * X)


@pytest.mark.parametrize("flow", FLOWS)
def test_stokes_equations(flow):
    """Central differences are exact, but for rounding, on polynomials of degree two:
    gradient = ∂u, div u = 0, ∇p = Δu."""
    points, h = points_of(flow), 1e-2
    dim = len(points)
    sides = [h * np.eye(dim)[:, j : j + 1] for j in range(dim)]
    gradient = np.stack(
        [(flow.velocity(points + s) - flow.velocity(points - s)) / (2 * h) for s in sides], axis=1
    )
    np.testing.assert_allclose(flow.gradient(points), gradient, atol=1e-12)
    np.testing.assert_allclose(np.einsum("iin->n", gradient), 0, atol=1e-12)
    laplacian = sum(
        flow.velocity(points + s) - 2 * flow.velocity(points) + flow.velocity(points - s)
        for s in sides
    ) / h**2  # fmt: skip
    slope = [(flow.pressure(points + s) - flow.pressure(points - s)) / (2 * h) for s in sides]
    np.testing.assert_allclose(slope, laplacian, atol=1e-10)


def test_own_function():
    """u = (sin kz, 0, 0) with gradient k cos kz in one place, for points of a droplet's size."""
    flow = UserFlow(lambda x: np.stack([np.sin(2 * x[2]), 0 * x[0], 0 * x[0]]))
    np.testing.assert_array_equal(flow.velocity(SPACE)[0], np.sin(2 * Z))
    expected = np.zeros((3, 3, 20))
    expected[0, 2] = 2 * np.cos(2 * Z)
    np.testing.assert_allclose(flow.gradient(SPACE), expected, atol=1e-8)
    np.testing.assert_allclose(flow.gradient(SPACE[:, :1]), expected[:, :, :1], atol=1e-9)
    assert flow.pressure(SPACE).shape == (20,) and not flow.pressure(SPACE).any()


@pytest.mark.parametrize(
    ("function", "message"),
    [
        (lambda x: x[0], r"array \(20,\) for points \(3, 20\)"),
        (lambda x: x.T, r"array \(20, 3\)"),
        (lambda x: np.where(x > x.max() - 1e-9, np.nan, x), r"not a finite number at \("),
    ],
)
def test_own_function_goes_wrong(function, message):
    with pytest.raises(ConditionError, match=message) as caught:
        UserFlow(function).velocity(SPACE)
    assert "\n" not in str(caught.value)


def test_impossible_flows():
    with pytest.raises(ConditionError, match="rates give it the divergence 3.0"):
        linear_flow(np.eye(3))
    with pytest.raises(InputError, match="rates has numbers that are not finite"):
        linear_flow([[1, np.inf], [0, -1]])
    with pytest.raises(InputError, match=r"about has shape \(3,\); give .* of shape \(2,\)"):
        linear_flow([[1, 0], [0, -1]], about=(0, 0, 0))
    bends = np.zeros((2, 2, 2))
    bends[0, 0, 0] = 1.0
    zero = np.zeros(2)
    with pytest.raises(ConditionError, match="bends give it the divergence"):
        PolynomialFlow(zero, np.zeros((2, 2)), bends, zero)
    bends = np.zeros((2, 2, 2))
    bends[0, 1, 0] = 1.0
    with pytest.raises(ConditionError, match="symmetric"):
        PolynomialFlow(zero, np.zeros((2, 2)), bends, zero)
