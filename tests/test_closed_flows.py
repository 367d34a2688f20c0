"""Flows whose velocity is given all around, and the mass that others conserve."""

from pathlib import Path

import numpy as np
import pytest
from shapes import channel

import cadbem as cb
from cadbem.boundary import Boundary, Patch
from cadbem.errors import ConditionError
from cadbem.problems.regions import regions
from cadbem.spline.outlines import circle, rectangle
from cadbem.spline.shapes import sphere

GEOMETRIES = Path(__file__).parents[1] / "geometries"
FINE = cb.Quadrature(1e-11)


def named(surfaces, name):
    return Boundary(tuple(Patch(s, name) for s in surfaces))


def container(dimension, low=-1.0):
    """From ``low`` to low + 2 along x, ±1 across."""
    half = np.ones(dimension)
    shift = np.array([low + 1, 0, 0])[:dimension]
    faces = channel(shift - half, shift + half).patches if dimension == 3 else None
    surfaces = [p.surface for p in faces] if faces else rectangle(shift - half, shift + half)
    return named(surfaces, "walls").elevated(2).refined(2)


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("power", [1, 2])
def test_shear_and_parabola(dimension, power):
    """u = (yᵖ, 0), p = 2μ(x - c) for the parabola, 0 for shear: in splines of degree 2 exactly.
    As n·E·n = 0 on the sides, ∮ f·n dS = -∮ p dS = 0 puts c in the middle, x = 3."""
    boundary = container(dimension, 2.0)
    given = cb.Velocity(lambda x: np.array([x[1] ** power, *(0 * x[1:])]))
    solution = cb.StokesProblem(boundary, 3.0, {"walls": given}, FINE).solve()
    points = np.array([[2.1, 3.5, 3.0], [-0.3, 0.999, 0.2], [0.1, 0.3, -0.9]])[:dimension]
    exact = np.array([points[1] ** power, *(0 * points[1:])])
    assert solution.velocity_at(points) == pytest.approx(exact, abs=1e-8)
    pressure = 6 * (points[0] - 3) * (power == 2)
    assert solution.pressure_at(points) == pytest.approx(pressure, abs=1e-6)
    assert solution.mean_pressure("walls") == pytest.approx(0.0, abs=1e-8)
    assert abs(solution.net_flux()) < 1e-12


def test_between_cylinders():
    """Circular Couette flow: u = (A r + B/r) θ, A = (4 Ω₂ - Ω₁)/3, B = (Ω₁ - Ω₂) 4/3 for radii 1
    and 2, no pressure, torque -4πμB on the inner.  Traction and velocity are linear on circles,
    which their splines hold: only quadrature is left of the error."""
    inner, outer = 0.7, -0.2
    patches = named(circle(2.0, inwards=True), "outer").patches + named(circle(), "inner").patches
    turns = {"inner": inner, "outer": outer}
    conditions = {n: cb.RigidMotion(angular_velocity=t) for n, t in turns.items()}
    boundary = Boundary(patches).elevated(3).refined(3)
    solution = cb.StokesProblem(boundary, 1.5, conditions, FINE).solve()
    a, b = (4 * outer - inner) / 3, (inner - outer) * 4 / 3
    points = np.array([[1.2, 0.0, -1.5], [0.3, -1.99, 1.0]])
    exact = (a + b / (points**2).sum(axis=0)) * np.array([-points[1], points[0]])
    assert solution.velocity_at(points) == pytest.approx(exact, abs=1e-10)
    assert solution.pressure_at(points) == pytest.approx([0, 0, 0], abs=1e-8)
    for name, sign in (("inner", -1), ("outer", 1)):
        torque = sign * 4 * np.pi * 1.5 * b
        assert solution.torque(name, (0, 0))[0] == pytest.approx(torque, rel=1e-10)


def stokeslet_flow(x):
    """Velocity (3, N) around the unit sphere that moves with speed 1 along x (Stokes 1851)."""
    r, e = np.linalg.norm(x, axis=0), np.array([[1.0], [0], [0]])
    return 0.75 * (e / r + x * x[0] / r**3) + 0.25 * (e / r**3 - 3 * x * x[0] / r**5)


def test_sphere_in_a_closed_box():
    """The box |x - (0.5, 0, 0)| < 3 moves as the fluid around a sphere does in unbounded fluid:
    its drag is 6πμ, the pressure 1.5 x/r³ up to a constant.  The drag's error falls at a fitted
    slope of at least 3 (degree 2 on the box)."""
    spans, errors = [2, 3, 5], []
    for n in spans:
        box = named([p.surface for p in channel((-2.5, -3, -3), (3.5, 3, 3)).patches], "box")
        ball = named(sphere(), "ball").elevated(4)
        boundary = Boundary(box.elevated(2).refined(n).patches + ball.patches)
        conditions = {"box": cb.Velocity(stokeslet_flow), "ball": cb.RigidMotion((1.0, 0.0, 0.0))}
        solution = cb.StokesProblem(boundary, 1.0, conditions).solve()
        errors.append(abs(solution.force("ball")[0] / (-6 * np.pi) - 1))
    assert -np.polyfit(np.log(spans), np.log(errors), 1)[0] > 3
    assert errors[-1] < 2e-3
    points = np.array([[1.5, -2.0], [0.2, 1.0], [-0.4, 0.3]])
    assert abs(solution.velocity_at(points) - stokeslet_flow(points)).max() < 2e-3
    pressure = 1.5 * points[0] / np.linalg.norm(points, axis=0) ** 3
    assert np.ptp(solution.pressure_at(points) - pressure) < 1e-2


@pytest.mark.parametrize("dimension", [2, 3])
def test_reflection_in_a_closed_container(dimension):
    """A rotlet u = e × x/rᵈ in the middle of a circle or sphere of radius 3: walls at rest add the
    rigid rotation -e × x/3ᵈ and no pressure."""
    shape = circle(3.0, inwards=True) if dimension == 2 else sphere(3.0, inwards=True)
    boundary = named(shape, "walls").elevated(4).refined(6 if dimension == 2 else 2)
    problem = cb.StokesProblem(boundary, 1.0, {"walls": cb.Velocity(lambda x: 0 * x)})

    def turned(x):
        return np.array([-x[1], x[0], *(0 * x[2:])])

    position = problem.space.collocation.position
    added = problem.reflection(turned(position) / np.linalg.norm(position, axis=0) ** dimension)
    points = np.array([[0.3, -1.0, 2.8], [0.5, 1.0, 0.3], [0.1, -1.0, 0.4]])[:dimension]
    assert added.velocity_at(points) == pytest.approx(-turned(points) / 3**dimension, abs=1e-5)
    assert added.pressure_at(points) == pytest.approx([0, 0, 0], abs=1e-4)
    assert abs(problem.solve().traction.coefficients).max() < 1e-9


def test_duct_with_both_ends_given():
    """Developed flow in and out: the exact gradient of the square duct, -28.4541538, to 1e-3."""
    ends = {"inlet": cb.Inflow(mean_velocity=1.0), "outlet": cb.Inflow(flow_rate=-1.0)}
    boundary = channel().elevated(2).refined(size=(0.15, 0.15, 0.15))
    solution = cb.StokesProblem(boundary, 1.0, ends | {"walls": cb.NoSlip()}).solve()
    drop = solution.mean_pressure("inlet") - solution.mean_pressure("outlet")
    assert drop / 2 == pytest.approx(28.4541538, rel=1e-3)


def test_data_that_let_fluid_pile_up():
    """2.1 % more in than out is refused with its size; 1e-7 of it is taken for rounding."""
    ends = {"inlet": cb.Inflow(mean_velocity=1.0), "outlet": cb.Inflow(mean_velocity=-0.979)}
    conditions = ends | {"walls": cb.NoSlip()}
    with pytest.raises(ConditionError, match=r"let 0.021 more in than out \(2.1 %\)") as error:
        cb.StokesProblem(channel(), 1.0, conditions)
    assert "give 'inlet' or 'outlet' or 'walls' a Pressure" in str(error.value)
    cb.StokesProblem(channel(), 1.0, conditions | {"outlet": cb.Inflow(mean_velocity=-1 + 1e-7)})
    source = {"walls": cb.Velocity(lambda x: x)}
    with pytest.raises(ConditionError, match=r"let 8 more out than in \(100 %\)"):
        cb.StokesProblem(container(2), 1.0, source)
    boundary = Boundary(container(2).patches + named(circle(0.2), "bubble").patches)
    with pytest.raises(ConditionError, match="'bubble' is a body with a Traction in a container"):
        cb.StokesProblem(boundary, 1.0, {"walls": cb.Velocity((0, 0)), "bubble": cb.Traction(0.0)})


def test_regions():
    """A box in the cavity of a hollow ball that lies in a box: two regions of fluid."""
    outer = named([p.surface for p in channel((-5, -5, -5), (5, 5, 5)).patches], "outer")
    shell = named(sphere(4.0), "shell")
    inner = named([p.surface for p in channel((-2, -2, -2), (2, 2, 2)).patches], "inner")
    ball = named(sphere(1.0), "ball")
    parts = (outer, shell, inner, ball)
    boundary = Boundary(sum((b.patches for b in parts), ()))
    problem = cb.StokesProblem(boundary, 1.0, {n: cb.Velocity((0, 0, 0)) for n in boundary.names})
    small, large = regions(boundary, problem.surfaces)
    assert [boundary.patches[i].name for i in small.patches] == ["inner"] * 6 + ["ball"] * 6
    assert [boundary.patches[i].name for i in large.patches] == ["outer"] * 6 + ["shell"] * 6


def test_what_enters_leaves():
    """The net flux vanishes but for rounding, at any resolution, of the flow through a Y-junction
    and of what its walls make of a point force (3/4, 0, 0)·8πμ/6 in it."""
    boundary = cb.read_cad(GEOMETRIES / "y_junction.step").elevated(2).refined(2)
    inflow = {name: cb.Inflow(mean_velocity=3.0) for name in ("inlet_a", "inlet_b")}
    conditions = inflow | {"outlet": cb.Pressure(), "walls": cb.NoSlip()}
    problem = cb.StokesProblem(boundary, 1.0, conditions, cb.Quadrature(1e-5))
    assert abs(problem.solve().net_flux()) < 1e-12
    middle = np.array([[7.0], [7.0], [2.0]])
    added = problem.reflection(stokeslet_flow(problem.space.collocation.position - middle))
    assert abs(added.flow_rate("outlet")) < 1e-12
    assert np.abs(added.velocity.coefficients).max() > 1e-3
