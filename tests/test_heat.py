"""Steady heat conduction against exact temperatures, in the plane and in space."""

import json
from pathlib import Path
from runpy import run_path

import numpy as np
import pytest
from scipy.optimize import brentq

from cadbem.boundary import Boundary, Patch
from cadbem.errors import ConditionError, InputError, SelectionError
from cadbem.operators.interactions import Targets
from cadbem.operators.potentials import Potentials
from cadbem.problems.heat import HeatProblem
from cadbem.problems.heat_conditions import HeatFlux, SurfaceExchange, Temperature
from cadbem.problems.heat_source import gradient_kernel, laplace_kernel, total_source
from cadbem.quadrature import Quadrature
from cadbem.space import discontinuous_space
from cadbem.spline.outlines import circle, line, rectangle
from cadbem.spline.shapes import box, sphere

DATA = json.loads((Path(__file__).parent / "data" / "reference.json").read_text())
REFERENCE = DATA["benchmark_1_and_2"]
RADII = np.linspace(1.05, 1.95, 25)
EXCHANGE = SurfaceExchange(convection=1.0, radiation=1.0, ambient=1.0)
FINE = Quadrature(1e-10)


def named(shapes, names):
    return Boundary(tuple(Patch(s, n) for s, n in zip(shapes, names, strict=True)))


def slab(dimension, length=1.0):
    """0 < x < length, of height (and depth) 1: left, right, and the sides."""
    high = (length,) + (1.0,) * (dimension - 1)
    shapes = rectangle((0, 0), high) if dimension == 2 else box((0, 0, 0), high)
    return named(shapes, ["left", "right"] + ["sides"] * (len(shapes) - 2))


def annulus():
    """The quarter 1 < r < 2, x and y > 0, of the thesis's first benchmark."""
    arcs = circle(1.0)[0], circle(2.0, inwards=True)[-1]
    sides = line((2, 0), (1, 0)), line((0, 1), (0, 2))
    return named(arcs + sides, ["inner", "outer", "symmetry", "symmetry"])


def hollow_sphere():
    """1 < r < 2, twelve patches without poles."""
    return named(sphere(1.0) + sphere(2.0, inwards=True), ["inner"] * 6 + ["outer"] * 6)


def order(counts, errors):
    """Slope of log error against log count."""
    return -np.polyfit(np.log(counts), np.log(errors), 1)[0]


@pytest.mark.parametrize("dimension", [2, 3])
def test_green_identity(dimension):
    """G and ∂G/∂n of φ = x on a slab: c φ = -∫ G ∂φ/∂n + ∫ φ ∂G/∂n with n into the domain,
    c = 2π (plane) or 4π inside and 0 outside; the gradient kernels give (c, 0, ...) inside.
    """
    space = discontinuous_space(slab(dimension))
    surface = space.collocation
    value = space.interpolate(surface.position[:1])
    slope = space.interpolate(surface.normal[:1])
    points = np.array([[0.2, 0.6, 1.3], [0.3, 0.99, 0.5], [0.5, 0.4, 0.5]])[:dimension]
    free = 2 * np.pi * (dimension - 1)
    for kernel, exact in (
        (laplace_kernel(dimension, 2.0), free * np.array([[0.2, 0.6, 0.0]])),
        (gradient_kernel(dimension), free * np.outer(np.eye(dimension)[0], [1, 1, 0])),
    ):
        result = Potentials(kernel, space, Targets.free(points), FINE).apply(-slope, value)
        assert result == pytest.approx(exact, abs=1e-7)


@pytest.mark.parametrize("dimension", [2, 3])
def test_slab_with_radiation(dimension):
    """φ = 2 - (2 - p) x with 2 - p = (p - 1) + (p⁴ - 1): linear, so exact in the space.

    The heat that passes is 2 - p, in at the left and out at the right.
    """
    p = brentq(lambda p: (p - 1) + (p**4 - 1) - (2 - p), 1, 2, xtol=1e-15)
    conditions = {"left": Temperature(2.0), "right": EXCHANGE, "sides": HeatFlux()}
    solution = HeatProblem(slab(dimension).refined(2), 1.0, conditions, quadrature=FINE).solve()
    x = np.array([[0.0, 0.3, 0.7, 0.999, 1.0], [0.1, 0.4, 1 - 1e-6, 0.2, 0.5], [0.4] * 5])
    points = x[:dimension]
    assert solution.temperature_at(points) == pytest.approx(2 - (2 - p) * points[0], abs=1e-9)
    flux = np.outer(np.eye(dimension)[0], [2 - p] * 5)
    points[0, 2] = 1 - 1e-3
    assert solution.heat_flux_at(points) == pytest.approx(flux, abs=1e-5)
    assert solution.heat_rate("left") == pytest.approx(2 - p, abs=1e-9)
    assert solution.heat_rate("right") == pytest.approx(p - 2, abs=1e-9)


def test_radiation_in_kelvin_without_any_given_temperature():
    """A slab heated by 5 kW/m² that only radiates to space: εσ φ⁴ = 5000 at the far side.

    φ = (5000 / εσ)^(1/4) + 5000 (1 - x) / k.  No condition fixes the temperature but radiation.
    """
    sigma, k = 5.670374419e-8, 20.0
    conditions = {
        "left": HeatFlux(5000.0), "right": SurfaceExchange(radiation=sigma), "sides": HeatFlux()
    }  # fmt: skip
    solution = HeatProblem(slab(3), k, conditions, quadrature=FINE).solve()
    exact = (5000 / sigma) ** 0.25 + 5000 * (1 - 0.3) / k
    assert solution.temperature_at([[0.3], [0.5], [0.5]]) == pytest.approx([exact], rel=1e-9)


def test_two_faces_that_radiate_to_different_surroundings():
    """Linear φ from p to q with 2 (p - q) = 16 - p⁴ = 3 (q - 1) + 0.5 (q⁴ - 1)."""

    def far(p):
        return p - (16 - p**4) / 2

    def gap(p):
        return 16 - p**4 - 3 * (far(p) - 1) - 0.5 * (far(p) ** 4 - 1)

    p = brentq(gap, 1.9, 2.0, xtol=1e-15)
    conditions = {
        "left": SurfaceExchange(radiation=1.0, ambient=2.0),
        "right": SurfaceExchange(3.0, 0.5, 1.0),
        "sides": HeatFlux(),
    }
    solution = HeatProblem(slab(2), 2.0, conditions, quadrature=FINE).solve()
    exact = [p, p + 0.3 * (far(p) - p), far(p)]
    points = np.array([[0.0, 0.3, 1.0], [0.5, 0.5, 0.5]])
    assert solution.temperature_at(points) == pytest.approx(exact, abs=1e-9)


@pytest.mark.parametrize("heat", [1e-3, 1.0, 1e6])
def test_source_that_is_radiated_away(heat):
    """φ = p + b (1 - x²) / 2k with p⁴ = b: all of the source leaves at the right."""
    conditions = {
        "left": HeatFlux(), "right": SurfaceExchange(radiation=1.0), "sides": HeatFlux()
    }  # fmt: skip
    boundary = slab(2).elevated(2)
    solution = HeatProblem(boundary, 3.0, conditions, heat, FINE).solve()
    x = np.array([0.0, 0.4, 1.0])
    exact = heat**0.25 + heat * (1 - x**2) / 6
    assert solution.temperature_at([x, 0 * x + 0.3]) == pytest.approx(exact, rel=1e-8)


def test_convection_alone_is_linear():
    """1D fin without sides: k (2 - p) = h (p - 1) gives p = (2 k + h) / (k + h)."""
    conditions = {
        "left": Temperature(2.0), "right": SurfaceExchange(4.0, ambient=1.0), "sides": HeatFlux()
    }  # fmt: skip
    solution = HeatProblem(slab(2), 3.0, conditions, quadrature=FINE).solve()
    assert solution.temperature_at([[1.0], [0.5]]) == pytest.approx([10 / 7], abs=1e-10)


def test_quarter_annulus():
    """φ = 2 + C₁ ln r, C₁ from a quartic: the mean error on the symmetry sides is below 1e-5 %
    with 72 points of degree 2 (the thesis: 132), and falls with the fourth power of the count or
    so, 3 at least.
    """
    slope = float(REFERENCE["benchmark_I"]["C1"])
    conditions = {"inner": Temperature(2.0), "outer": EXCHANGE, "symmetry": HeatFlux()}
    counts, errors = [], []
    for spans in (4, 8, 16):
        boundary = annulus().elevated(2).refined(spans)
        solution = HeatProblem(boundary, 1.0, conditions, quadrature=FINE).solve()
        space = solution.space
        sides = slice(space.offsets[2], space.offsets[4])
        exact = 2 + slope * np.log(np.linalg.norm(space.collocation.position[:, sides], axis=0))
        values = space.values(solution.temperature.coefficients)[0, sides]
        counts.append(space.count)
        errors.append(100 * abs(values / exact - 1).mean())
    assert counts[-1] == 72
    assert errors[-1] < 1e-5
    assert order(counts, errors) > 3
    inside = solution.temperature_at(np.outer([np.cos(0.6), np.sin(0.6)], RADII))
    assert inside == pytest.approx(2 + slope * np.log(RADII), rel=1e-8)
    assert solution.heat_rate("inner") == pytest.approx(-slope * np.pi / 2, rel=1e-6)


def test_hollow_sphere():
    """φ = C₁ / r + C₂ on 25 points of two rays; 300 points, below 1e-8; heat 4π C₁ enters.

    Constants on a sphere are in the space, so only the quadrature errs here.
    """
    exact = REFERENCE["benchmark_II"]
    conditions = {"inner": Temperature(2.0), "outer": EXCHANGE}
    solution = HeatProblem(hollow_sphere(), 1.0, conditions).solve()
    assert solution.space.count == 300
    temperature = float(exact["C1"]) / RADII + float(exact["C2"])
    for ray in (np.array([0, 0, 1]), np.array([1, 2, 3]) / np.sqrt(14)):
        assert solution.temperature_at(np.outer(ray, RADII)) == pytest.approx(temperature, rel=1e-8)
    assert solution.heat_rate("inner") == pytest.approx(float(exact["heat_rate_4pi_C1"]), rel=1e-9)
    assert abs(solution.net_heat()) < 1e-9


def test_uneven_temperature_in_a_hollow_sphere_converges():
    """φ = 1 / |x - a|, a inside the hole; inner temperature and outer flux are given.

    The heat that enters is 4π; inside, the error falls faster than with the first power of the
    number of points (second order in the width of elements).
    """
    a = np.array([[0.3], [0.2], [0.1]])
    points = np.outer(np.array([1, 2, 3]) / np.sqrt(14), RADII)

    def exact(x):
        return 1 / np.linalg.norm(x - a, axis=0)

    def entering(x):  # q = -∂φ/∂n with n = -x/2 on the outer sphere
        return -(x / 2 * (x - a)).sum(axis=0) * exact(x) ** 3

    counts, errors = [], []
    for spans in (1, 2, 3):
        conditions = {"inner": Temperature(exact), "outer": HeatFlux(entering)}
        boundary = hollow_sphere().refined(spans)
        problem = HeatProblem(boundary, 1.0, conditions, quadrature=Quadrature(1e-6))
        solution = problem.solve()
        counts.append(solution.space.count)
        errors.append(abs(solution.temperature_at(points) / exact(points) - 1).max())
    assert errors[-1] < 5e-5
    assert order(counts, errors) > 2
    assert solution.heat_rate("inner") == pytest.approx(4 * np.pi, rel=1e-6)


@pytest.mark.parametrize("dimension", [2, 3])
def test_constant_source(dimension):
    """2 φ'' + 3 = 0, φ(0) = 0, no heat through the rest: φ = 1.5 (x - x²/2), exact in degree 2.

    All of the heat, 3, leaves at the left.
    """
    conditions = {"left": Temperature(0.0), "right": HeatFlux(), "sides": HeatFlux()}
    boundary = slab(dimension).elevated(2)
    solution = HeatProblem(boundary, 2.0, conditions, source=3.0, quadrature=FINE).solve()
    points = np.array([[0.0, 0.3, 0.999, 1.0], [0.2, 0.9, 0.4, 0.5], [0.4] * 4])[:dimension]
    x = points[0]
    assert solution.temperature_at(points) == pytest.approx(1.5 * (x - x**2 / 2), abs=1e-8)
    exact = np.outer(np.eye(dimension)[0], 3 * (x - 1))
    assert solution.heat_flux_at(points) == pytest.approx(exact, abs=2e-6)
    assert solution.heat_rate("left") == pytest.approx(-3.0, abs=1e-8)
    assert abs(solution.net_heat()) < 1e-8


@pytest.mark.parametrize("dimension", [2, 3])
def test_exponential_source(dimension):
    """φ = exp(x - y/2) solves 2 ∇²φ + b = 0 with b = -2.5 φ, which is no polynomial."""

    def exact(x):
        return np.exp(x[0] - x[1] / 2)

    boundary = slab(dimension).elevated(3).refined(8 if dimension == 2 else 2)
    conditions = {name: Temperature(exact) for name in boundary.names}
    solution = HeatProblem(boundary, 2.0, conditions, lambda x: -2.5 * exact(x)).solve()
    points = np.random.default_rng(4).random((dimension, 20))
    assert solution.temperature_at(points) == pytest.approx(exact(points), rel=5e-5)
    gradient = np.outer([1, -0.5, 0][:dimension], np.ones(20)) * exact(points)
    assert solution.heat_flux_at(points) == pytest.approx(-2 * gradient, abs=1e-3)


def test_source_in_a_body_that_is_not_convex():
    """An annulus with b = k = 1 and φ = 0 on both circles.

    ∇²φ = -1: φ = (4 - r²) / 4 + C ln(r / 2), C = (3/4) / ln 2; the source's total is 3π.
    """
    boundary = named(circle(1.0) + circle(2.0, inwards=True), ["rims"] * 8)
    boundary = boundary.elevated(3).refined(3)
    assert total_source(1.0, boundary) == pytest.approx(3 * np.pi, rel=1e-12)
    problem = HeatProblem(boundary, 1.0, {"rims": Temperature(0.0)}, 1.0, FINE)
    exact = (4 - RADII**2) / 4 + 0.75 / np.log(2) * np.log(RADII / 2)
    temperature = problem.solve().temperature_at(np.outer([np.cos(1), np.sin(1)], RADII))
    assert temperature == pytest.approx(exact, abs=1e-8)


def test_unit_circle_has_no_special_scale():
    """With -ln r alone the single layer on the unit circle has no inverse; φ = x² - y²."""
    boundary = named(circle(1.0, inwards=True), ["rim"] * 4).elevated(3).refined(16)
    rim = Temperature(lambda x: x[0] ** 2 - x[1] ** 2)
    solution = HeatProblem(boundary, 1.0, {"rim": rim}, quadrature=FINE).solve()
    points = np.array([[0.3, -0.5, 0.1], [0.2, 0.6, -0.9]])
    exact = points[0] ** 2 - points[1] ** 2
    assert solution.temperature_at(points) == pytest.approx(exact, abs=1e-6)


@pytest.mark.parametrize("name", ["annulus_heat", "hollow_sphere_heat"])
def test_workflow(name, tmp_path, capsys):
    """The heat that passes: (π/2) C₁ (a quarter) and 4π C₁; a table and a plot."""
    workflow = run_path(str(Path(__file__).parents[1] / "workflows" / f"{name}.py"))
    solution = workflow["main"](output=str(tmp_path), finest=1)
    annulus_heat = -np.pi / 2 * float(REFERENCE["benchmark_I"]["C1"])
    sphere_heat = float(REFERENCE["benchmark_II"]["heat_rate_4pi_C1"])
    exact = annulus_heat if name == "annulus_heat" else sphere_heat
    assert solution.heat_rate("inner") == pytest.approx(exact, rel=1e-3)
    assert (tmp_path / f"{name}.png").stat().st_size > 10_000
    assert "points" in capsys.readouterr().out


def test_mistakes():
    insulated = {"left": HeatFlux(1.0), "right": HeatFlux(), "sides": HeatFlux()}
    with pytest.raises(ConditionError, match="temperature is open; give one of 'left'"):
        HeatProblem(slab(2), 1.0, insulated)
    with pytest.raises(ConditionError, match="'right' has 3 for a condition; give one of Temp"):
        HeatProblem(slab(2), 1.0, insulated | {"right": 3})
    with pytest.raises(ConditionError, match="'sides' .* has no condition|no condition.*'sides'"):
        HeatProblem(slab(2), 1.0, {"left": Temperature(0.0), "right": HeatFlux()})
    given = insulated | {"left": Temperature(1.0)}
    with pytest.raises(InputError, match="conductivity is 0"):
        HeatProblem(slab(2), 0.0, given)
    with pytest.raises(ConditionError, match="nor both zero"):
        SurfaceExchange()
    with pytest.raises(ConditionError, match="absolute"):
        SurfaceExchange(radiation=1.0, ambient=-20.0)
    with pytest.raises(ConditionError, match="heat source is not resolved"):
        HeatProblem(slab(2), 1.0, given, lambda x: np.sign(np.sin(60 * x[0]))).solve()
    with pytest.raises(SelectionError, match="no face is named 'lid'"):
        HeatProblem(slab(2), 1.0, given).solve().heat_rate("lid")


def test_radiation_that_finds_no_balance():
    """More heat is taken out than the surroundings at φ∞ = 0 can give back: φ|φ|³ < 0 there,
    which the extended law balances at a negative temperature; an error says so."""
    conditions = {
        "left": HeatFlux(-1.0), "right": SurfaceExchange(radiation=1.0), "sides": HeatFlux()
    }  # fmt: skip
    with pytest.raises(ConditionError, match="below absolute zero"):
        HeatProblem(slab(2), 1.0, conditions).solve()
