"""Plane Stokes problems: the same class as in space, against exact flows."""

import numpy as np
import pytest

from cadbem.boundary import Boundary, Patch
from cadbem.errors import ConditionError
from cadbem.problems.conditions import Inflow, NoSlip, Pressure, RigidMotion, Traction, Velocity
from cadbem.problems.stokes import StokesProblem
from cadbem.quadrature import Quadrature
from cadbem.space import Field, discontinuous_space
from cadbem.spline.outlines import circle, ellipse, line, rectangle

CHANNEL = {"inlet": Inflow(mean_velocity=2.0), "outlet": Pressure(0.0), "walls": NoSlip()}


def channel(*bodies) -> Boundary:
    """Length 2, width 0.5, flow along x."""
    names = ("inlet", "outlet", "walls", "walls")
    sides = zip(rectangle((-1, -0.25), (1, 0.25)), names, strict=True)
    patches = [Patch(s, n, i + 1) for i, (s, n) in enumerate(sides)]
    return Boundary((*patches, *[Patch(b, "body", 9) for b in bodies]))


def test_parallel_plates():
    """u = 1.5 U (1 - (2y/W)²), -dp/dx = 12 μ U / W²: splines of degree 2 hold it exactly."""
    boundary = channel().elevated(2).refined(size=0.2)
    assert boundary.area() == pytest.approx(5.0)
    assert boundary.volume() == pytest.approx(1.0)
    solution = StokesProblem(boundary, 3.0, CHANNEL, Quadrature(1e-11)).solve()
    drop = 12 * 3.0 * 2.0 / 0.5**2 * 2
    assert solution.mean_pressure("inlet") == pytest.approx(drop, rel=1e-8)
    assert abs(solution.net_flux()) < 1e-10
    assert solution.net_force() < 1e-8
    assert solution.flow_rate("inlet") == pytest.approx(1.0, abs=1e-12)
    assert solution.force("walls") == pytest.approx([drop * 0.5, 0.0], rel=1e-8, abs=1e-6)
    y = np.linspace(-0.2, 0.2, 5)
    for depth in (0.25, 0.01, 1e-6, 0.0):
        points = np.concatenate([[0.3 + 0 * y, y], [0.1 + 0 * y, 0 * y + 0.25 - depth]], axis=1)
        exact = 3.0 * (1 - (4 * points[1]) ** 2)
        velocity = solution.velocity_at(points)
        assert abs(velocity[0] - exact).max() < 1e-7
        assert abs(velocity[1]).max() < 1e-7
        pressure = solution.pressure_at(points)
        assert abs(pressure - drop * (1 - points[0]) / 2).max() < 1e-4


def test_linear_flow_behind_a_curved_wall():
    """u = (x, -y), p = 3 in half an ellipse: at the straight side f = (1, 0) with n = (1, 0), and
    the pressure of the curved side is found from f and the surface divergence."""
    arcs = ellipse((1.0, 0.6), inwards=True)
    walls = [Patch(a, "walls", 1) for a in arcs if a.points[:, 0].min() > -1e-12]
    assert len(walls) == 2
    outlet = Patch(line((0, -0.6), (0, 0.6)), "outlet", 2)
    strain = Velocity(lambda x: np.array([x[0], -x[1]]))
    conditions = {"walls": strain, "outlet": Traction((-3.0 + 2.0, 0.0))}
    boundary = Boundary((*walls, outlet)).elevated(4).refined(10)
    assert boundary.volume() == pytest.approx(np.pi * 0.6 / 2, rel=1e-12)
    solution = StokesProblem(boundary, 1.0, conditions).solve()
    points = np.array([[0.3, 0.9, 1e-4], [0.1, -0.2, 0.3]])
    assert solution.velocity_at(points) == pytest.approx(points * [[1], [-1]], abs=1e-6)
    assert solution.pressure_at(points[:, :2]) == pytest.approx([3.0, 3.0], abs=1e-4)
    for patch in range(3):
        assert solution.surface_pressure(patch, [0.3, 0.7]) == pytest.approx([3, 3], abs=1e-3)


def test_a_body_in_a_channel():
    """Flux and force balance with a round body off the middle; no flow inside it; on the middle
    it feels no lift and no torque.  Turning makes a torque against the turn."""
    forces = []
    for y in (0.05, 0.0):
        boundary = channel(*circle(0.1, (0.0, y))).elevated(3).refined(16)
        solution = StokesProblem(boundary, 1.0, CHANNEL | {"body": NoSlip()}).solve()
        assert abs(solution.net_flux()) < 1e-5
        assert solution.net_force() < 1e-5
        assert abs(solution.velocity_at([[0.02], [y - 0.03]])).max() < 1e-4
        forces.append([*solution.force("body"), *solution.torque("body", (0.0, y))])
    assert forces[1][0] > 0
    assert np.abs(forces[1][1:]).max() < 1e-8 * forces[1][0]
    still = {"inlet": Pressure(0.0), "outlet": Pressure(0.0), "walls": NoSlip()}
    turning = RigidMotion(angular_velocity=1.0, centre=(0.0, 0.0))
    solution = StokesProblem(boundary, 1.0, still | {"body": turning}).solve()
    # without walls the torque is -4π μ a² ω; walls make it larger
    assert solution.torque("body", (0.0, 0.0))[0] < -4 * np.pi * 0.01


def test_mistakes():
    """Unbounded plane fluid, and an inlet in two pieces."""
    body = Boundary(tuple(Patch(c, "body", 1) for c in circle()))
    with pytest.raises(ConditionError, match="no closed curve holds the fluid"):
        StokesProblem(body, 1.0, {"body": RigidMotion((1.0, 0.0))})
    sides = list(channel().patches)
    halves = [
        Patch(line((-1, low), (-1, high)), name)
        for low, high, name in ((-0.25, -0.1, "inlet"), (-0.1, 0.1, "walls"), (0.1, 0.25, "inlet"))
    ]
    with pytest.raises(ConditionError, match="not one straight segment"):
        StokesProblem(Boundary((*halves, *sides[1:])), 1.0, CHANNEL).solve()


def test_selecting_and_refining_curves():
    """Sides by number, point and predicate; lengths and areas stay under changes of splines."""
    boundary = channel()
    assert boundary.select(3) == (2,)
    assert boundary.select((-1.0, 0.1)) == (0,)
    assert boundary.select(lambda position, normal: normal[1] < -0.5) == (3,)
    ring = Boundary(tuple(Patch(c, "ring", 1) for c in circle(2.0)))
    assert ring.volume() == pytest.approx(-4 * np.pi, rel=1e-13)
    richer = ring.elevated(4).refined(size=0.3).graded(2)
    assert len(richer.patches[0].surface.breaks(0)) == 1 + 11 + 4
    assert richer.area() == pytest.approx(4 * np.pi, rel=1e-13)
    assert richer.volume() == pytest.approx(-4 * np.pi, rel=1e-13)


def test_surface_divergence_on_a_curve():
    """The field x has div_s x = 1 on any curve; the field (y, -x) has 0 on a circle about 0."""
    space = discontinuous_space(Boundary(tuple(Patch(c) for c in circle(2.0))))
    x, y = space.collocation.position
    for values, exact in ((np.array([x, y]), 1.0), (np.array([y, -x]), 0.0)):
        field = Field(space, space.interpolate(values))
        normal, divergence = field.surface_divergence(1, [0.2, 0.9])
        assert divergence == pytest.approx([exact, exact], abs=1e-13)
        assert 2 * normal == pytest.approx(space.boundary.patches[1].surface.evaluate([0.2, 0.9]))
