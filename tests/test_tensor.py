"""Tensor rules of low order for panels far away."""

from math import pi

import numpy as np
import pytest
from shapes import octant, quarter_cylinder, unit_square

from cadbem.kernels.laplace_3d import LAPLACE_3D
from cadbem.kernels.stokes_3d import STOKES_3D
from cadbem.operators.accumulators import MatrixAccumulator
from cadbem.operators.interactions import Targets, interact, interact_pairs
from cadbem.operators.orders import reaches
from cadbem.operators.panels import split_patch, tensor_nodes
from cadbem.operators.tensor import TARGETS, add_tensor, by_blocks
from cadbem.points import surface_points
from cadbem.quadrature import Quadrature
from cadbem.quadrature.gauss import gauss_unit
from cadbem.space import rational_basis


def matrix(kernel, surface, targets, tolerance):
    """All entries (entries, T, F) of one patch."""
    panels = split_patch(surface)
    entries = np.zeros((kernel.entries, targets.shape[1], surface.weights.size))
    accumulator = MatrixAccumulator(entries, surface.weights.shape[1])
    interact(kernel, panels, 0, Targets.free(targets), Quadrature(tolerance), accumulator)
    return entries


def directions(count):
    found = np.random.default_rng(1).normal(size=(3, count))
    return found / np.linalg.norm(found, axis=0)


@pytest.mark.parametrize("shape", [octant, quarter_cylinder, unit_square])
@pytest.mark.parametrize("tolerance", [1e-4, 1e-6, 1e-8, 1e-10])
def test_every_order_meets_the_tolerance(shape, tolerance):
    """Entries at distances of a few to hundreds of panels against those of a far tighter
    tolerance, relative to the kernel's largest there."""
    third = np.array([1, 2]) / 3
    surface = shape().elevated((2, 2)).inserted((third, third))
    targets = directions(200) * np.geomspace(1.2, 100.0, 200) + 0.5
    exact = matrix(STOKES_3D, surface, targets, 1e-13)
    found = matrix(STOKES_3D, surface, targets, tolerance)
    for part in (slice(0, 6), slice(6, 12)):
        scale = abs(exact[part]).sum(axis=2).max(axis=0)
        error = abs(found[part] - exact[part]).max(axis=(0, 2)) / scale
        assert error.max() < 2 * tolerance


def test_shapes_rule_orders_out():
    """A flat square is polynomial: all orders resolve it from afar.  On an eighth of a sphere with
    a pole some do not: 3 x 3 nodes miss its area, π/2, by 1e-7."""
    orders = 3, 4, 5, 6, 7
    flat, round_ = (split_patch(shape().elevated((2, 2))) for shape in (unit_square, octant))
    assert np.isfinite(reaches(flat, orders, Quadrature(1e-8))).all()
    assert np.isinf(reaches(round_, orders, Quadrature(1e-8))[0]).all()
    assert np.isfinite(reaches(round_, orders, Quadrature(1e-8))[-1]).all()
    one = np.ones((1, *round_.surface.weights.shape))
    areas = [tensor_nodes(round_, m).densities(round_, one).sum() for m in (3, 7)]
    assert areas[0] - pi / 2 == pytest.approx(-1.0e-7, rel=0.1)
    assert areas[1] == pytest.approx(pi / 2, rel=1e-8)


def test_far_rule_is_the_sum_over_its_nodes():
    """∫ R_f / r dS by 5 x 5 Gauss nodes, summed one by one."""
    surface = unit_square()
    targets = directions(150) * 20.0
    panels = split_patch(surface)
    entries = np.zeros((2, 150, surface.weights.size))
    pairs = by_blocks(np.ones((150, 1), dtype=bool))
    accumulator = MatrixAccumulator(entries, surface.weights.shape[1])
    add_tensor(LAPLACE_3D, panels, 5, targets, *pairs, accumulator)
    t, w = gauss_unit(5)
    u, v = (g.ravel() for g in np.meshgrid(t, t, indexing="ij"))
    points = surface_points(surface, u, v)
    functions = np.asarray(rational_basis(surface, np.stack([u, v])).todense())
    weighted = (np.outer(w, w).ravel() * points.jacobian)[:, None] * functions
    distance = np.linalg.norm(points.position[:, None] - targets[:, :, None], axis=0)
    assert entries[0] == pytest.approx((1 / distance) @ weighted, rel=1e-13)


def test_orders_grow_towards_the_panel():
    """Lower orders reach less near; none is left out between them and the lowest one close by."""
    for degree in (1, 2, 3, 4):
        for tolerance in (1e-4, 1e-8, 1e-12):
            rules = Quadrature(tolerance)
            orders = *rules.far_orders(degree), *rules.orders(degree)[1:]
            reaches = [rules.reach(m, degree) for m in orders]
            assert list(orders) == sorted(set(orders))
            assert reaches == sorted(reaches, reverse=True)
            assert all(2 * m - 1 > degree for m in orders)


def test_blocks_of_pairs():
    """Every chosen pair once; within a block of targets the panels ascend."""
    chosen = np.random.default_rng(0).random((3 * TARGETS + 5, 7)) < 0.3
    target, panel = by_blocks(chosen)
    again = np.zeros_like(chosen)
    again[target, panel] = True
    assert np.array_equal(again, chosen) and len(target) == chosen.sum()
    order = (target // TARGETS) * 7 + panel
    assert (np.diff(order) >= 0).all()


def test_chosen_pairs_are_the_same_pairs():
    """All pairs given one by one, in any order, make the same matrix."""
    surface = quarter_cylinder().elevated((2, 2))
    targets = Targets.free(directions(40) * np.geomspace(1.2, 30.0, 40) + 0.5)
    panels = split_patch(surface)
    count, columns = surface.weights.size, surface.weights.shape[1]
    whole, parts = (MatrixAccumulator(np.zeros((12, 40, count)), columns) for _ in range(2))
    rules = Quadrature(1e-8)
    interact(STOKES_3D, panels, 0, targets, rules, whole)
    grid = np.indices((40, len(panels.flat_nets))).reshape(2, -1)
    target, panel = grid[:, np.random.default_rng(0).permutation(grid.shape[1])]
    interact_pairs(STOKES_3D, panels, 0, targets, (target, panel), rules, parts)
    assert parts.entries == pytest.approx(whole.entries, rel=1e-12, abs=1e-14)
