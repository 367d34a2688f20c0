"""Rigid particles: alone, turning, with others, and in channels."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import cadbem as cb
from cadbem.boundary import Boundary, Patch
from cadbem.errors import ShapeError
from cadbem.spline.outlines import circle, rectangle
from cadbem.spline.shapes import box
from cadbem.suspension.rigid.pose import Pose

REFERENCE = json.loads((Path(__file__).parent / "data" / "reference.json").read_text())
REST = cb.FreeFlow(cb.at_rest())


def first_response(flow, *bodies):
    return cb.Simulation(flow, list(bodies)).start.responses


def test_mobility_of_an_ellipsoid():
    """Force F on a semi-axis moves it at F / (resistance), a torque turns it; resistances of the
    ellipsoid (3, 2, 1) from Perrin's integrals, in axes turned at random."""
    exact = REFERENCE["ellipsoid_drag"]["(3, 2, 1)"]
    body = cb.rigid_ellipsoid((3.0, 2.0, 1.0), (5.0, -3.0, 2.0), spans=5)
    turn = Rotation.from_rotvec([0.4, -0.9, 1.3])
    for axis in range(3):
        along = turn.as_matrix()[:, axis]
        turned = body.at(np.concatenate([body.centre, turn.as_quat()]))
        pushed = first_response(REST, replace(turned, force=along))[0]
        assert pushed.velocity * float(exact["F_over_muU"][axis]) == pytest.approx(along, abs=1e-4)
        assert pushed.angular_velocity == pytest.approx(0.0, abs=1e-7)
        wound = first_response(REST, replace(turned, torque=along))[0]
        spin = wound.angular_velocity * float(exact["T_over_muOmega"][axis])
        assert spin == pytest.approx(along, abs=1e-4)


def test_faxen():
    """A free sphere in a quadratic flow moves at u + R²/6 ∇²u and turns at half the vorticity."""
    flow = cb.UserFlow(lambda x: np.array([x[1] ** 2 + x[2], 0 * x[0], 0 * x[0]]))
    ball = cb.rigid_sphere(0.8, (0.0, 0.5, 0.2), spans=1)
    response = first_response(cb.FreeFlow(flow), ball)[0]
    assert response.velocity == pytest.approx([0.25 + 0.2 + 0.64 / 3, 0, 0], abs=1e-6)
    assert response.angular_velocity == pytest.approx([0, 0.5, -0.5], abs=1e-6)
    inside = np.array([[0.1], [0.4], [0.3]])
    state = cb.Simulation(cb.FreeFlow(flow), ball).start
    assert state.velocity_at(inside) == pytest.approx(response.velocity_at(inside))


def test_jeffery_orbit():
    """A spheroid of aspect ratio a in shear u = z turns about y with the period 2π (a + 1/a);
    its axis goes through tan φ = tan(t / (a + 1/a)) / a when it starts along z."""
    ratio = 3.0
    period = 2 * np.pi * (ratio + 1 / ratio)
    body = cb.rigid_ellipsoid((1.0, 1.0, ratio), spans=2)
    run = cb.Simulation(cb.FreeFlow(cb.shear()), body, stepper=cb.Adaptive(1e-4))
    *_, half = run.run(period / 2, every=period / 2)
    axis = half.bodies[0].pose.matrix[:, 2]
    # the axis turns slowly where it lies along the flow, fast where it stands: at 1 / (1 + 1/a²)
    late = np.arctan2(axis[0], axis[2]) % np.pi
    late = (late + np.pi / 2) % np.pi - np.pi / 2
    rate = ratio**2 / (ratio**2 + 1)
    assert abs(late) / rate / (period / 2) < 1e-3
    assert axis[1] == pytest.approx(0.0, abs=1e-10)
    assert half.bodies[0].centre == pytest.approx(0.0, abs=1e-10)


@pytest.mark.parametrize("distance", ["2", "3"])
def test_two_spheres_falling_in_line(distance):
    """Stimson and Jeffery's drag for centres 2 d apart on the line of fall."""
    ball = replace(cb.rigid_sphere(1.0, (0.0, 0.0, 0.0), spans=2), force=(0.0, 0.0, -6 * np.pi))
    other = ball.at(np.array([0.0, 0.0, 2 * float(distance), 0.0, 0.0, 0.0, 1.0]))
    exact = 1 / float(REFERENCE["two_spheres_in_line_stimson_jeffery"][distance])
    for response in first_response(REST, ball, other):
        assert response.velocity == pytest.approx([0, 0, -exact], abs=2e-5)
        assert response.angular_velocity == pytest.approx(0.0, abs=1e-9)


def channel(dimension: int) -> cb.ChannelFlow:
    """A box whose walls move with the rigid motion of ``rigid``."""
    half = np.array([2.5, 2.0, 2.0])[:dimension]
    faces = (box if dimension == 3 else rectangle)(-half, half)
    boundary = Boundary(tuple(Patch(f, f"face{i}") for i, f in enumerate(faces)))
    boundary = boundary.elevated(2).refined(2 if dimension == 3 else 4)
    conditions = {n: cb.Velocity(rigid) for n in boundary.names}
    return cb.ChannelFlow(cb.StokesProblem(boundary, 2.0, conditions))


def rigid(x):
    shift = np.array([0.3, -0.5, 0.2])[: len(x), None]
    spin = 0.7 * np.stack([-x[1], x[0], *(0 * z for z in x[2:])])
    return shift + spin


@pytest.mark.parametrize("dimension", [2, 3])
def test_carried_by_a_rigid_motion(dimension):
    """Walls, fluid and both kinds of bodies move as one; nothing resists, whatever λ is."""
    flow = channel(dimension)
    sizes, place = (0.5, 0.4, 0.3)[:dimension], np.array([0.9, 0.2, 0.1])[:dimension]
    particle = cb.rigid_ellipsoid(sizes, place, spans=2)
    drop = cb.Droplet(
        cb.spline_ellipsoid(sizes, -place, points=128 if dimension == 3 else 32),
        cb.SurfaceTension(0.0), 4.0,
    )  # fmt: skip
    state = cb.Simulation(flow, [particle, drop]).start
    moved, carried = state.responses
    assert moved.velocity == pytest.approx(rigid(place[:, None])[:, 0], abs=1e-5)
    assert moved.angular_velocity[-1] == pytest.approx(0.7, abs=1e-5)
    targets = state.layers[0].targets
    velocity = targets.grid.values(carried.velocity)
    assert velocity == pytest.approx(rigid(targets.position), abs=1e-5)
    assert abs(state.walls.net_flux()) < 1e-10


def test_any_closed_solid():
    """A cube falls without turning, and as fast in any orientation (its resistance is that of a
    sphere by symmetry); an open box, or one inside out, is refused."""
    faces = [f.swapped() for f in box((-1, -1, -1), (1, 1, 1))]
    cube = Boundary(tuple(Patch(f, "cube") for f in faces)).elevated(2).refined(4).graded(2)
    body = cb.RigidParticle(cube, force=(0.0, 0.0, -1.0))
    turn = Rotation.from_rotvec([0.3, 0.8, -0.5]).as_quat()
    straight = first_response(REST, body)[0].velocity
    tilted = first_response(REST, body.at(np.concatenate([body.centre, turn])))[0]
    assert tilted.velocity == pytest.approx(straight, abs=1e-6)
    assert tilted.angular_velocity == pytest.approx(0.0, abs=1e-6)
    # Known bounds: between the inscribed and the circumscribed sphere
    assert 6 * np.pi < 1 / -straight[2] < 6 * np.pi * np.sqrt(3)
    with pytest.raises(ShapeError, match="not closed"):
        cb.RigidParticle(replace(cube, patches=cube.patches[:5]))
    with pytest.raises(ShapeError, match="inwards"):
        cb.RigidParticle(cube.turned())


def test_pose():
    """Rates of the coordinates turn the matrix at ω × R, in both dimensions."""
    spin = np.array([0.2, -0.7, 0.4])
    pose = Pose(np.zeros(3), Rotation.from_rotvec([0.5, 1.0, -0.3]).as_quat())
    step = 1e-6
    later = Pose.of(pose.coordinates + step * pose.rate(np.zeros(3), spin), 3).matrix
    expected = np.cross(spin, pose.matrix, axisa=0, axisb=0, axisc=0)
    assert (later - pose.matrix) / step == pytest.approx(expected, abs=1e-5)
    plane = Pose(np.zeros(2), np.array([0.3]))
    later = Pose.of(plane.coordinates + step * plane.rate(np.ones(2), np.array([0.5])), 2)
    assert later.position == pytest.approx([step, step])
    expected = 0.5 * np.array([[0, -1], [1, 0]]) @ plane.matrix
    assert (later.matrix - plane.matrix) / step == pytest.approx(expected, abs=1e-5)


def test_a_stored_pose_comes_back_to_the_last_bit():
    """Coordinates of a turned particle, given again, are the same numbers."""
    turns = np.random.default_rng(2).normal(size=(200, 4))
    for turn in turns:
        once = Pose.of(np.concatenate([np.ones(3), turn]), 3).coordinates
        np.testing.assert_array_equal(Pose.of(once, 3).coordinates, once)


def test_circle_in_a_closed_ring():
    """A free circle in the middle of a ring that turns at Ω turns with it, as the fluid does."""
    ring = Boundary(tuple(Patch(c, "ring") for c in circle(3.0, inwards=True)))
    ring = ring.elevated(3).refined(4)
    turning = {"ring": cb.Velocity(lambda x: 1.3 * np.stack([-x[1], x[0]]))}
    flow = cb.ChannelFlow(cb.StokesProblem(ring, 1.0, turning))
    response = first_response(flow, cb.rigid_ellipsoid((1.0, 1.0)))[0]
    assert response.angular_velocity == pytest.approx(1.3, abs=1e-8)
    assert response.velocity == pytest.approx(0.0, abs=1e-8)
