"""NURBS against SciPy's B-splines, and refinements against the shape that they must keep."""

import numpy as np
import pytest
from scipy.interpolate import BSpline

from cadbem.spline import Nurbs
from cadbem.spline.basis import basis_functions, basis_matrix, greville, open_knots
from cadbem.spline.project import closest_point

DEGREES = range(1, 9)


def random_knots(degree: int, seed: int) -> np.ndarray:
    """Open knots with random breaks and random multiplicities up to the degree."""
    rng = np.random.default_rng(seed)
    breaks = np.concatenate([[0.0], np.sort(rng.random(4)), [1.0]])
    counts = np.concatenate([[degree + 1], rng.integers(1, degree + 1, 4), [degree + 1]])
    return np.repeat(breaks, counts)


def random_curve(degree: int, seed: int = 0) -> Nurbs:
    rng = np.random.default_rng(seed)
    knots = random_knots(degree, seed)
    count = len(knots) - degree - 1
    return Nurbs((degree,), (knots,), rng.random((count, 3)), rng.random(count) + 0.5)


def random_surface(p: int, q: int, seed: int = 0) -> Nurbs:
    rng = np.random.default_rng(seed)
    knots = random_knots(p, seed), random_knots(q, seed + 1)
    shape = len(knots[0]) - p - 1, len(knots[1]) - q - 1
    return Nurbs((p, q), knots, rng.random((*shape, 3)), rng.random(shape) + 0.5)


@pytest.mark.parametrize("degree", DEGREES)
def test_basis_is_a_partition_of_unity_that_agrees_with_scipy(degree):
    knots, u = random_knots(degree, degree), np.linspace(0, 1, 57)
    for order in range(min(degree, 2) + 1):
        ours = basis_matrix(degree, knots, u, order)
        scale = degree**order * 1e3**order
        for j in range(ours.shape[1]):
            one = BSpline(knots, np.eye(ours.shape[1])[j], degree)
            theirs = one(u, nu=order)
            inside = ~np.isin(u, knots)  # at knots the derivative's side is a convention
            assert abs(ours[inside, j] - theirs[inside]).max() < 1e-13 * scale
        assert abs(ours.sum(axis=1) - (order == 0)).max() < 1e-12 * scale


def test_last_span_is_closed():
    first, values = basis_functions(2, open_knots(2, [0, 0.5, 1]), [1.0])
    assert first[0] == 1
    assert values[0, :, 0] == pytest.approx([0, 0, 1])


@pytest.mark.parametrize("degree", DEGREES)
def test_rational_curve_and_derivatives(degree):
    """Homogeneous SciPy splines and the quotient rule by hand."""
    curve, u = random_curve(degree), np.linspace(0.013, 0.987, 41)
    spline = BSpline(curve.knots[0], curve.homogeneous, degree)
    h = [spline(u, nu=k) for k in range(3)]
    w = [part[:, 3:] for part in h]
    x = h[0][:, :3] / w[0]
    first = (h[1][:, :3] - w[1] * x) / w[0]
    second = (h[2][:, :3] - 2 * w[1] * first - w[2] * x) / w[0]
    ours = curve.derivatives(2, u)
    for key, exact in (((0,), x), ((1,), first), ((2,), second)):
        assert abs(ours[key].T - exact).max() < 1e-12 * max(1.0, abs(exact).max())


@pytest.mark.parametrize(("p", "q"), [(1, 1), (2, 3), (4, 2), (5, 8)])
def test_surface_derivatives_agree_with_those_of_its_isolines(p, q):
    """The mixed derivative by a six-point difference of exact first derivatives."""
    surface = random_surface(p, q)
    (u0, u1), (v0, v1) = (0.4501, 0.46), (0.5502, 0.56)
    d = surface.derivatives(2, [u0, u1], [v0, v1])
    row = BSpline(surface.knots[0], surface.homogeneous, p)(u0)
    line = Nurbs((q,), (surface.knots[1],), row[:, :3] / row[:, 3:], row[:, 3])
    along = line.derivatives(2, [v0])
    for k in range(3):
        assert d[(0, k)][:, 0] == pytest.approx(along[(k,)][:, 0], rel=1e-11, abs=1e-11)
    step = 1e-3
    offsets, factors = np.array([-3, -2, -1, 1, 2, 3]), np.array([-1, 9, -45, 45, -9, 1]) / 60
    smooth = surface.bezier_pieces()[0]
    middle = [0.5 * sum(ends) for ends in smooth.domain]
    width = step * (smooth.domain[0][1] - smooth.domain[0][0])
    firsts = smooth.derivatives(1, middle[0] + offsets * width, np.full(6, middle[1]))[(0, 1)]
    mixed = surface.derivatives(2, *middle)[(1, 1)]
    assert firsts @ factors / width == pytest.approx(mixed, rel=1e-7)


def test_points_on_a_grid_are_those_point_by_point():
    """Grids are evaluated by matrix products: the same up to rounding, in any order of points."""
    surface = random_surface(3, 5)
    u, v = np.meshgrid(np.linspace(0, 1, 13), np.linspace(0, 1, 17), indexing="ij")
    shuffled = np.random.default_rng(3).permutation(u.size)
    u, v = u.ravel()[shuffled], v.ravel()[shuffled]
    grid = surface.derivatives(2, u, v)
    for k in range(0, u.size, 7):
        single = surface.derivatives(2, u[k], v[k])
        for key, value in single.items():
            assert grid[key][:, k] == pytest.approx(value, rel=1e-11, abs=1e-10)


@pytest.mark.parametrize("degree", DEGREES)
def test_refinement_keeps_the_curve(degree):
    curve, u = random_curve(degree, 5), np.linspace(0, 1, 101)
    exact = curve.evaluate(u)
    rng = np.random.default_rng(1)
    for same in (
        curve.inserted([rng.random(5)]),
        curve.elevated((degree + 1,)),
        curve.elevated((degree + 3,)),
        curve.elevated((degree + 2,)).inserted([rng.random(7)]),
    ):
        assert abs(same.evaluate(u) - exact).max() < 1e-14
    assert abs(curve.reversed().evaluate(1 - u) - exact).max() < 1e-14


@pytest.mark.parametrize(("p", "q"), [(1, 2), (3, 2), (4, 5)])
def test_refinement_keeps_the_surface(p, q):
    surface = random_surface(p, q, 3)
    u, v = np.random.default_rng(0).random((2, 200))
    exact = surface.evaluate(u, v)
    richer = surface.elevated((p + 1, q + 2)).inserted([[0.2, 0.7], [0.1]])
    assert abs(richer.evaluate(u, v) - exact).max() < 1e-14
    assert abs(surface.swapped().evaluate(v, u) - exact).max() < 1e-14
    part = surface.restricted((0.1, 0.4), (0.3, 1.0))
    u, v = 0.1 + 0.3 * u, 0.3 + 0.7 * v
    assert abs(part.evaluate(u, v) - surface.evaluate(u, v)).max() < 1e-14
    pieces = surface.bezier_pieces()
    assert len(pieces) == 25
    for piece in pieces:
        middle = [0.5 * sum(ends) for ends in piece.domain]
        assert piece.evaluate(*middle) == pytest.approx(surface.evaluate(*middle), abs=1e-14)
        assert piece.weights.shape == (p + 1, q + 1)


def test_quarter_circle_is_exact():
    half = np.sqrt(0.5)
    knots = np.array([0, 0, 0, 1, 1, 1.0])
    points = np.array([[1, 0], [1, 1], [0, 1.0]])
    arc = Nurbs((2,), (knots,), points, np.array([1, half, 1]))
    finer = arc.elevated((5,)).inserted([np.linspace(0.1, 0.9, 9)])
    x = finer.evaluate(np.linspace(0, 1, 100))
    assert abs(np.linalg.norm(x, axis=0) - 1).max() < 1e-14


def test_greville_abscissae():
    assert greville(2, np.array([0, 0, 0, 0.5, 1, 1, 1])) == pytest.approx([0, 0.25, 0.75, 1])


def test_closest_point_on_a_cylinder():
    """A point at radius 3 is 2 away from the unit cylinder, at the same angle."""
    half = np.sqrt(0.5)
    knots = np.array([0, 0, 0, 1, 1, 1.0]), np.array([0, 0, 1, 1.0])
    rim = np.array([[1, 0, 0], [1, 1, 0], [0, 1, 0.0]])
    points = np.stack([rim, rim + [0, 0, 2.0]], axis=1)
    surface = Nurbs((2, 1), knots, points, np.array([[1, 1], [half, half], [1, 1.0]]))
    target = 3 * np.array([np.cos(0.3), np.sin(0.3), 0.5])
    parameters, distance = closest_point(surface, target)
    assert distance == pytest.approx(2, abs=1e-12)
    foot = surface.evaluate(*parameters).ravel()
    assert foot == pytest.approx([np.cos(0.3), np.sin(0.3), 1.5], abs=1e-7)
    assert closest_point(surface, [0.5, -1.0, 0.0])[1] == pytest.approx(np.hypot(0.5, 1))


def test_shapes_that_do_not_fit_are_refused():
    knots = np.array([0, 0, 1, 1.0])
    with pytest.raises(ValueError, match="ask for"):
        Nurbs((1,), (knots,), np.zeros((3, 2)), np.ones(3))
    with pytest.raises(ValueError, match="positive"):
        Nurbs((1,), (knots,), np.zeros((2, 2)), np.array([1.0, 0.0]))
