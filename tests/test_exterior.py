"""Flow around bodies against exact solutions: spheres, ellipsoids, pairs, a sphere at a wall."""

import json
from pathlib import Path

import numpy as np
import pytest
from shapes import channel

from cadbem.boundary import Boundary, Patch
from cadbem.errors import ConditionError
from cadbem.problems.bodies import closed_surfaces, point_inside
from cadbem.problems.conditions import Background, NoSlip, RigidMotion, Traction, Velocity
from cadbem.problems.stokes import StokesProblem
from cadbem.quadrature import Quadrature
from cadbem.spline.shapes import (
    cylinder,
    ellipsoid,
    parallelogram,
    plate,
    sphere,
    sphere_octants,
    sphere_with_poles,
)

REFERENCE = json.loads((Path(__file__).parent / "data" / "reference.json").read_text())
SPHERES = (sphere, sphere_octants, sphere_with_poles)
MOTION = RigidMotion((1.0, 0.0, 0.5), (0.3, 0.0, 1.0), (0.5, 0.0, 0.0))


def body(shape, degree, spans, name="body"):
    return Boundary(tuple(Patch(s, name) for s in shape)).elevated(degree).refined(spans)


def moved(shape, degree, spans, condition, **options):
    return StokesProblem(body(shape, degree, spans), 1.0, {"body": condition}, **options).solve()


def stokes_flow(position, radius=1.0):
    """Velocity and pressure around a sphere that moves along x with speed 1 (μ = 1).

    u = (3a/4)(e/r + x x·e/r³) + (a³/4)(e/r³ - 3 x x·e/r⁵),  p = (3a/2) x·e/r³.
    """
    r, e, a = np.linalg.norm(position, axis=0), np.array([[1.0], [0], [0]]), radius
    xx = position * position[0]
    velocity = 3 * a / 4 * (e / r + xx / r**3) + a**3 / 4 * (e / r**3 - 3 * xx / r**5)
    return velocity, 1.5 * a * position[0] / r**3


@pytest.mark.parametrize("shape", SPHERES)
def test_spheres_are_exact(shape):
    """|x - c| = a, area 4πa², ∮ x·n = 3V > 0; turned inwards they enclose the fluid."""
    for patch in shape(2.0, (1, 2, 3)):
        grid = np.meshgrid(*[np.linspace(*ends, 31) for ends in patch.domain])
        gap = patch.evaluate(*grid) - np.array([1.0, 2, 3]).reshape(3, 1, 1)
        assert abs(np.linalg.norm(gap, axis=0) / 2 - 1).max() < 1e-14
    outwards = Boundary(tuple(map(Patch, shape(2.0, (1, 2, 3)))))
    inwards = Boundary(tuple(map(Patch, shape(2.0, (1, 2, 3), inwards=True))))
    assert outwards.area() == pytest.approx(16 * np.pi, rel=1e-13)
    assert outwards.volume() == pytest.approx(-32 * np.pi / 3, rel=1e-13)
    assert inwards.volume() == pytest.approx(32 * np.pi / 3, rel=1e-13)


def test_cylinder_and_ellipsoid():
    """Side 2πrl with normals towards the axis; volume 4πabc/3."""
    side = Boundary(tuple(map(Patch, cylinder(2.0, 3.0, (1, 1, 1)))))
    points, weights = side.quadrature()
    radial = points.position - np.array([[0.0], [1], [1]])
    assert weights.sum() == pytest.approx(12 * np.pi)
    assert (radial[1:] * points.normal[1:]).sum(axis=0) == pytest.approx(-2.0)
    assert side.bounds()[:, 0] == pytest.approx([1, 4])
    egg = Boundary(tuple(map(Patch, ellipsoid((3, 2, 1), (1, 2, 3)))))
    assert egg.volume(24) == pytest.approx(-8 * np.pi, rel=1e-10)


@pytest.mark.parametrize(
    ("shape", "degree", "spans"),
    [(sphere, 4, 1), (sphere_octants, 2, 2), (sphere_with_poles, 2, 8)],
)
def test_moving_sphere(shape, degree, spans):
    """F = -6πμaU, T = -8πμa³Ω, Stokes's flow outside up to the surface, nothing inside.

    The traction, a linear function, lies in each space: only quadrature is left of the error.
    """
    solution = moved(shape(), degree, spans, RigidMotion((1.0, 0.0, 0.0), (0.0, 0.4, 0.0)))
    assert abs(solution.force("body") / (6 * np.pi) + [1, 0, 0]).max() < 1e-8
    assert abs(solution.torque("body", (0, 0, 0)) / (8 * np.pi) + [0, 0.4, 0]).max() < 1e-8
    still = moved(shape(), degree, spans, RigidMotion((1.0, 0.0, 0.0)))
    points = np.array([[0.0, 0, 1.5], [-2, 1, 3], [0.6, -0.9, 0.1], [0.6, 0.8 + 1e-4, 0]]).T
    velocity, pressure = stokes_flow(points)
    assert abs(still.velocity_at(points) - velocity).max() < 1e-7
    assert abs(still.pressure_at(points) - pressure).max() < 1e-5
    assert abs(still.velocity_at([[0.3], [0.2], [0.1]])).max() < 1e-6
    assert still.pressure_at([[0.3], [0.2], [0.1]]) == pytest.approx([0.0], abs=1e-6)


def test_rigid_motions_near_poles():
    """∫ u·T·n dS = -4πu on the surface for a rigid motion, also right next to a pole."""
    problem = StokesProblem(body(sphere_with_poles(), 3, 8), 1.0, {"body": MOTION})
    coefficients = MOTION.at(problem.boundary.patches[0].surface.points.reshape(-1, 3).T)
    double = problem.layers.apply(0 * coefficients, coefficients)
    exact = -4 * np.pi * MOTION.at(problem.space.collocation.position)
    assert abs(double - exact).max() < 1e-7


def test_units_scale():
    """A sphere of 1e-3 in a fluid of viscosity 50: the drag is 6πμaU still."""
    boundary = body(sphere(1e-3, (1.0, 1.0, 1.0)), 4, 1)
    solution = StokesProblem(boundary, 50.0, {"body": RigidMotion((0.0, 2.0, 0.0))}).solve()
    assert solution.force("body")[1] == pytest.approx(-6 * np.pi * 50 * 1e-3 * 2, rel=1e-8)


def test_sphere_held_in_a_background_flow():
    """u∞ = (z² + z, 0, 0), p∞ = 2x + 3: Faxén's F = 6π(u∞ + ∇²u∞/6) = 2π along x, and
    T = 4π rot u∞ = 4π along y; on the surface the pressure's mean is p∞(0) = 3, as what the
    sphere adds is a sum of decaying harmonics without a source."""

    def velocity(x):
        return np.array([x[2] ** 2 + x[2], 0 * x[0], 0 * x[0]])

    flow = Background(velocity, lambda x: 2 * x[0] + 3)
    solution = moved(sphere(), 4, 2, NoSlip(), background=flow)
    assert abs(solution.force("body") / (2 * np.pi) - [1, 0, 0]).max() < 3e-6
    assert abs(solution.torque("body", (0, 0, 0)) / (4 * np.pi) - [0, 1, 0]).max() < 1e-9
    assert solution.mean_pressure("body") == pytest.approx(3.0, abs=1e-6)
    far = np.array([[1e4], [0.0], [2e4]])
    assert solution.velocity_at(far) == pytest.approx(velocity(far), rel=1e-6, abs=1e-3)
    assert solution.pressure_at(far) == pytest.approx([2e4 + 3], rel=1e-6)


def test_pressure_on_the_surface():
    """A sphere held in the uniform flow e_x of pressure 5 feels p = 5 - 3x/2 (μ = a = 1)."""
    flow = Background((1.0, 0.0, 0.0), 5.0)
    solution = moved(sphere(), 4, 1, NoSlip(), background=flow)
    u, v = np.array([0.1, 0.5, 0.8]), np.array([0.3, 0.5, 0.9])
    for patch in range(6):
        x = solution.space.boundary.patches[patch].surface.evaluate(u, v)[0]
        assert solution.surface_pressure(patch, u, v) == pytest.approx(5 - 1.5 * x, abs=1e-6)


def test_drag_converges():
    """Eight biquadratic patches in the flow (z², 0, 0): the drag's error falls at a fitted slope
    of at least 3 in the number of spans (2 is the degree)."""
    flow = Background(lambda x: np.array([x[2] ** 2, 0 * x[0], 0 * x[0]]), lambda x: 2 * x[0])
    spans, errors = [2, 3, 4], []
    for n in spans:
        solution = moved(sphere_octants(), 2, n, NoSlip(), background=flow)
        errors.append(abs(solution.force("body")[0] / (2 * np.pi) - 1))
    assert -np.polyfit(np.log(spans), np.log(errors), 1)[0] > 3
    assert errors[-1] < 2e-4


@pytest.mark.parametrize(("axes", "error"), [((2, 1, 1), 2e-4), ((3, 2, 1), 6e-4)])
def test_ellipsoids(axes, error):
    """Drag and torque along and about all three axes (elliptic integrals, Perrin 1934) from 150
    points; the centre is off the origin."""
    values = REFERENCE["ellipsoid_drag"][str(axes)]
    drag = np.array(values["F_over_muU"], dtype=float)
    torque = np.array(values["T_over_muOmega"], dtype=float)
    motion = RigidMotion((1.0, 1.0, 1.0), (1.0, 1.0, 1.0), (1.0, 2.0, 3.0))
    solution = moved(ellipsoid(axes, (1, 2, 3)), 4, 1, motion)
    assert abs(solution.force("body") / drag + 1).max() < error
    assert abs(solution.torque("body", (1, 2, 3)) / torque + 1).max() < error


@pytest.mark.parametrize("ratio", ["2", "1.5"])
def test_two_spheres_along_their_line_of_centres(ratio):
    """Drag of each over 6πμaU (Stimson and Jeffery 1926); ``ratio`` = centre distance / 2a."""
    height = float(ratio)
    exact = float(REFERENCE["two_spheres_in_line_stimson_jeffery"][ratio])
    low = body(sphere(1, (0, 0, -height)), 4, 1, "low")
    high = body(sphere(1, (0, 0, height)), 4, 1, "high")
    boundary = Boundary(low.patches + high.patches)
    conditions = {name: RigidMotion((0.0, 0.0, 1.0)) for name in ("low", "high")}
    solution = StokesProblem(boundary, 1.0, conditions).solve()
    for name in conditions:
        assert -solution.force(name)[2] / (6 * np.pi) == pytest.approx(exact, rel=2e-6)


def test_plate():
    """A square of 40² = 1600 whose normals point up, in patches that fit."""
    points, weights = Boundary(tuple(map(Patch, plate(3.0, 40.0)))).quadrature()
    assert weights.sum() == pytest.approx(1600)
    assert abs(points.normal - [[0.0], [0], [1]]).max() < 1e-12


def test_sphere_near_a_wall():
    """Sphere at height 2a moving along a wall: drag and torque in bispherical coordinates
    (O'Neill 1964).  The wall is a plate of 2000 a, a surface with fluid on both sides, whose
    traction is the sum of both."""
    exact = REFERENCE["sphere_near_wall"]["2.000000000000"]
    wall = tuple(Patch(p, "wall") for p in plate(3.0, 2000.0))
    boundary = Boundary(body(sphere(1, (0, 0, 2.0)), 4, 2).patches + wall)
    conditions = {"body": RigidMotion((1.0, 0.0, 0.0)), "wall": NoSlip()}
    solution = StokesProblem(boundary, 1.0, conditions, Quadrature(1e-6)).solve()
    assert -solution.force("body")[0] / (6 * np.pi) == pytest.approx(exact["Ft"], rel=5e-4)
    torque = solution.torque("body", (0, 0, 2))[1] / (8 * np.pi)
    assert torque == pytest.approx(-exact["Tt"], abs=1e-3)


def test_body_inside_a_container():
    """Box, fluid and body turn like one rigid body under the pressure 2: the body's traction is
    -2n, although multiples of n are no matter to the velocity."""
    motion = RigidMotion((0.1, 0.0, 0.0), (0.0, 0.0, 1.0))
    box = channel((-2, -2, -2), (2, 2, 2)).elevated(2).refined(1)
    boundary = Boundary(box.patches + body(sphere(0.7), 4, 1).patches)
    conditions = {"inlet": motion, "walls": motion, "body": motion}
    conditions["outlet"] = Traction((2.0, 0.0, 0.0))  # n = -e_x there
    solution = StokesProblem(boundary, 1.0, conditions).solve()
    assert solution.mean_pressure("body") == pytest.approx(2.0, abs=1e-6)
    assert abs(solution.force("body")).max() < 1e-6
    points = np.array([[0.9, 0.2, 0.1], [-1.5, 1, 1]]).T
    assert solution.velocity_at(points) == pytest.approx(motion.at(points), abs=1e-6)


def test_surfaces_of_a_boundary():
    """What hangs together, what holds fluid, what is a body, what is open."""
    box, ball = channel((-2, -2, -2), (2, 2, 2)), body(sphere(0.5, (1, 0, 0)), 4, 1)
    lone = Patch(parallelogram((-1, -1, -1), (0.5, 0, 0), (0, 0.5, 0)), "fin")
    boundary = Boundary((*box.patches, *ball.patches, lone))
    container, sphere_, fin = closed_surfaces(boundary)
    assert container.holds_fluid and container.volume == pytest.approx(64)
    assert sphere_.is_body and sphere_.patches == tuple(range(6, 12))
    assert not fin.is_body and not fin.holds_fluid
    inside = point_inside(boundary, sphere_) - [1, 0, 0]
    assert np.linalg.norm(inside) < 0.5


def test_mistakes():
    ball = body(sphere(), 4, 1)
    with pytest.raises(ConditionError, match="nothing drives the flow"):
        StokesProblem(ball, 1.0, {"body": NoSlip()})
    with pytest.raises(ConditionError, match="walls enclose the fluid"):
        inside = body(sphere(inwards=True), 4, 1)
        StokesProblem(inside, 1.0, {"body": NoSlip()}, background=Background((1.0, 0.0, 0.0)))
    with pytest.raises(ConditionError, match=r"let 12.6 more out than in \(100 %\)"):
        StokesProblem(body(sphere(inwards=True), 4, 1), 1.0, {"body": Velocity(lambda x: x)})


def test_moving_plate():
    """A thin plate that moves through fluid at rest is one at rest in the opposite wind; one that
    moves with the wind does nothing."""
    wind = np.array([0.3, -1.0, 0.7])
    boundary = Boundary(tuple(Patch(p, "plate") for p in plate(1.0, 4.0, spans=2, rings=3)))

    def solved(velocity, background):
        conditions = {"plate": Velocity(tuple(velocity))}
        return StokesProblem(
            boundary, 1.0, conditions, Quadrature(1e-6), Background(tuple(background))
        ).solve()

    moving, held = solved(wind, 0 * wind), solved(0 * wind, -wind)
    assert moving.traction.coefficients == pytest.approx(held.traction.coefficients, abs=1e-10)
    points = np.array([[0.3, 1.0, -0.5], [0.1, 0.4, 3.0], [0.5, -0.02, 1.0]])
    assert moving.velocity_at(points) == pytest.approx(
        held.velocity_at(points) + wind[:, None], abs=1e-10
    )
    assert np.abs(solved(wind, wind).traction.coefficients).max() < 1e-10
