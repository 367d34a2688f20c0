"""Singular and nearly singular rules against tables of 15 and more digits and closed forms."""

import json
from math import asinh, atan2, cos, pi, sin, sqrt
from pathlib import Path

import numpy as np
import pytest
from shapes import octant, quarter_cylinder, unit_square

from cadbem.operators.panels import split_patch, tensor_nodes
from cadbem.quadrature import Quadrature, UniformSubdivision, near
from cadbem.quadrature.gauss import gauss_on_breaks, gauss_unit
from cadbem.spline.shapes import sphere_octants
from cadbem.verification.rules import even_rule, near_rule

REFERENCE = json.loads((Path(__file__).parent / "data" / "reference.json").read_text())
TOLERANCES = (1e-6, 1e-8, 1e-10)


def distance(position, target):
    return np.linalg.norm(position - np.reshape(target, (3, 1)), axis=0)


@pytest.mark.parametrize("order", [1, 4, 9, 64])
def test_gauss_is_exact_for_polynomials(order):
    """∫₀¹ t^k dt = 1 / (k + 1) for k up to 2 order - 1."""
    nodes, weights = gauss_unit(order)
    powers = np.arange(2 * order)
    assert nodes ** powers[:, None] @ weights == pytest.approx(1 / (powers + 1), rel=1e-12)
    table = near.gauss_table()
    assert table[0, order, :order] == pytest.approx(nodes, abs=1e-15)
    broken, shares = gauss_on_breaks(order, np.array([0, 0.3, 1]))
    assert broken ** (2 * order - 1) @ shares == pytest.approx(1 / (2 * order), rel=1e-12)


@pytest.mark.parametrize("tolerance", TOLERANCES)
def test_cylinder_table(tolerance):
    """∫ dS / 4πr on a quarter cylinder (thesis, table 2.1), sources down to 1e-3 away."""
    table = REFERENCE["table_2_1"]
    for delta, exact in zip(table["delta"], table["I"], strict=True):
        source = [cos(pi / 4), delta, sin(pi / 4)]
        position, weight = near_rule(quarter_cylinder(), source, tolerance)
        value = weight @ (1 / (4 * pi * distance(position, source)))
        assert value == pytest.approx(float(exact), rel=tolerance)


@pytest.mark.parametrize("tolerance", TOLERANCES)
def test_octant_table(tolerance):
    """∫ (x - x₀) / 4πr³ dS on a sphere's octant with a pole (thesis, table 2.2)."""
    table = REFERENCE["table_2_2"]
    for share, exact in zip(table["theta_over_pi_32"], table["I"], strict=True):
        theta = int(share) * pi / 32
        source = np.array([cos(theta), sin(theta), 1.0]) * sqrt(0.5)
        position, weight = near_rule(octant(), source, tolerance)
        r = distance(position, source)
        value = weight @ ((position[0] - source[0]) / (4 * pi * r**3))
        assert value == pytest.approx(float(exact), rel=tolerance)


@pytest.mark.parametrize("tolerance", TOLERANCES)
def test_plane_table(tolerance):
    """Weakly singular ∫ (x - x₀) / r² dS on a 2 × 4 rectangle (thesis, table 2.3)."""
    plane = unit_square().transformed(np.diag([2.0, 4.0, 1.0]), [-1.0, 0.0, 0.0])
    table = REFERENCE["table_2_3"]
    for xi, exact in zip(table["xi"], table["I"], strict=True):
        source = [2 * xi - 1, 4 * table["eta"], 0]
        position, weight = near_rule(plane, source, tolerance, own=(xi, table["eta"]))
        value = weight @ ((position[0] - source[0]) / distance(position, source) ** 2)
        assert value == pytest.approx(float(exact), rel=tolerance)


def corner_solid_angle(a, b, height):
    """Solid angle of the rectangle 0 < x < a, 0 < y < b seen from (0, 0, height)."""
    return atan2(a * b, height * sqrt(a * a + b * b + height * height))


def corner_potential(a, b, height):
    """∫ dS / r over the same rectangle, by integrating 1/r twice."""
    r = sqrt(a * a + b * b + height * height)
    logs = a * asinh(b / sqrt(a * a + height * height)) + b * asinh(
        a / sqrt(b * b + height * height)
    )
    return logs - height * atan2(a * b, height * r)


@pytest.mark.parametrize("tolerance", [1e-6, 1e-10])
def test_any_distance_from_a_pole(tolerance):
    """A sphere of octants, whose edges shrink to points: ∫ dS / r = 4π / max(1, |x₀|), over and
    beside the pole, at most 20 000 points an octant."""
    for direction in ([0, 0, 1], [1e-4, 2e-4, 1], [0.01, 0.003, 1], [0.1, 0.2, 1], [1, 0, 0]):
        unit = np.array(direction) / np.linalg.norm(direction)
        for away in (0.3, 0.1, 1e-2, 1e-3, 1e-4, 1e-5, -1e-3):
            source = (1 + away) * unit
            total = 0.0
            for surface in sphere_octants():
                position, weight = near_rule(surface, source, tolerance)
                assert len(weight) < 20_000
                total += weight @ (1 / distance(position, source))
            assert total == pytest.approx(4 * pi / max(1, 1 + away), rel=tolerance)


@pytest.mark.parametrize(("tolerance", "most"), [(1e-6, 2304), (1e-10, 20_000)])
@pytest.mark.parametrize("stretch", [1.0, 10.0])
def test_any_distance_above_and_beside_a_square(tolerance, most, stretch):
    """Solid angle and potential at 0.3 to 1e-5 of the size, above the middle, by an edge, near
    a corner, and beyond the edges, also of a rectangle ten times as long as wide."""
    surface = unit_square().transformed(np.diag([stretch, 1.0, 1.0]))
    spots = [(0.37, 0.61), (0.01, 0.4), (1e-3, 1e-4), (0.0, 0.3), (1.02, 0.5), (-0.1, -0.05)]
    for (x, y), height in [(s, h) for s in spots for h in (0.3, 0.1, 1e-2, 1e-3, 1e-4, 1e-5)]:
        source = np.array([x * stretch, y, height])
        sides = [(x * stretch, (1 - x) * stretch), (y, 1 - y)]
        signed = [(a, b) for a in sides[0] for b in sides[1]]
        solid = sum(corner_solid_angle(a, b, height) for a, b in signed)
        potential = sum(
            np.sign(a * b) * corner_potential(abs(a), abs(b), height) for a, b in signed
        )
        position, weight = near_rule(surface, source, tolerance)
        r = distance(position, source)
        assert len(weight) <= most
        assert weight @ (1 / r) == pytest.approx(potential, rel=tolerance)
        scale = weight @ (1 / r**2) * height / r.min()
        assert abs(weight @ (height / r**3) - solid) < tolerance * max(solid, scale)


@pytest.mark.parametrize("tolerance", [1e-4, 1e-8, 1e-12])
@pytest.mark.parametrize("degree", [1, 2, 5])
def test_tensor_rules_hold_their_promise(tolerance, degree):
    """Each order of the ladder, at its reach, integrates 1/r and 1/r³ times a polynomial of the
    degree (at most 1) like 60 × 60 Gauss points, relative to the kernel's integral."""
    quadrature = Quadrature(tolerance)
    panels = split_patch(unit_square())
    fine = tensor_nodes(panels, 60)
    for order in quadrature.orders(degree):
        nodes = tensor_nodes(panels, order)
        for direction in ((0, 0, 1), (0, 0.6, 0.8), (0, 1, 0)):
            reach = quadrature.reach(order, degree)
            source = np.array([0.5, 0.5 + 0.5 * direction[1], 0]) + reach * np.array(direction)
            for power in (1, 3):
                ours, exact, kernel = (
                    (
                        part.position[1] ** k
                        / distance(part.position.reshape(3, -1), source) ** power
                    ).ravel()
                    @ part.weight.ravel()
                    for part, k in ((nodes, degree), (fine, degree), (fine, 0))
                )
                assert abs(ours - exact) < tolerance * kernel


def test_uniform_subdivision_fails_where_its_limit_bites():
    """At 1e-3 of the element the solid angle is wrong by more than a half, with 20 × 20 parts;
    the default rule is right."""
    rules = UniformSubdivision()
    assert rules.pieces(np.ones(3), np.array([1.0, 0.1, 1e-3])).tolist() == [1, 3, 20]
    position, weight = even_rule(unit_square(), 20)
    source = [0.525, 0.525, 1e-3]
    value = weight @ (1e-3 / distance(position, source) ** 3)
    sides = (0.525, 0.475)
    exact = sum(corner_solid_angle(a, b, 1e-3) for a in sides for b in sides)
    assert abs(value / exact - 1) > 0.5
    position, weight = near_rule(unit_square(), source, 1e-8)
    assert weight @ (1e-3 / distance(position, source) ** 3) == pytest.approx(exact, rel=1e-8)


def test_tolerance_out_of_range_is_refused():
    with pytest.raises(ValueError, match="tolerance"):
        Quadrature(0.5)
