"""Elements of walls and particles that become small where another surface is near."""

from pathlib import Path

import numpy as np
import pytest
from sphere_near_wall_series import along_wall, towards_wall
from test_closeness import NAMES, disc, plane_channel
from test_results import same_tables, stored_numbers

import cadbem as cb
from cadbem.boundary import Boundary, Patch
from cadbem.elements.pieces import Elements, pieces_near
from cadbem.errors import AccuracyWarning, InputError
from cadbem.results import open_run, run_folder
from cadbem.spline.outlines import rectangle
from cadbem.spline.shapes import box, sphere

GAPS = (0.05, 0.01)
PIPE = Path(__file__).parents[1] / "geometries" / "round_pipe.step"


def around(point):
    """Lengths of elements: a third of the distance from a point, a tenth at least."""

    def sizes(points):
        away = np.linalg.norm(points - np.reshape(point, (-1, 1)), axis=0)
        return np.maximum(away / 3, 0.1)

    return sizes


def test_pieces_cover_their_patches():
    """They have the area of the whole, fit their lengths, and far patches stay as they are."""
    faces = box((0.0, 0.0, 0.0), (1.0, 1.0, 1.0))
    boundary = Boundary(tuple(Patch(face, "wall") for face in (*faces, *sphere(0.2, (3, 0, 0)))))
    sizes = around((0.5, 0.5, 0.0))
    elements = Elements.of(boundary)
    pieces = pieces_near(elements, sizes, 3)
    cut = pieces.of(boundary)
    assert cut.area() == pytest.approx(boundary.area(), rel=1e-12)
    assert cut.volume() == pytest.approx(boundary.volume(), rel=1e-12)
    assert Elements.of(cut).shares(sizes).max() < 1.0 + 1e-9 < elements.shares(sizes).max()
    assert all(np.count_nonzero(pieces.patch == i) == 1 for i in range(6, 12))
    near = np.linalg.norm(Elements.of(cut).samples.mean(axis=2) - [0.5, 0.5, 0], axis=1) < 0.4
    degrees = np.array([min(p.surface.degrees) for p in cut.patches])
    assert (degrees[near] == 3).all() and (degrees == 1).any()


def test_knots_that_are_not_needed():
    """Refined and restored, a sphere's patches are the same; one with a kink keeps its knot."""
    for face in sphere(2.0):
        restored = face.inserted([[0.3, 0.6], [0.5]]).without_knots()
        assert restored.points.shape == face.points.shape
        np.testing.assert_allclose(restored.points, face.points, atol=1e-12)
        np.testing.assert_allclose(restored.weights, face.weights, atol=1e-12)
    bent = face.inserted([[0.5, 0.5, 0.5, 0.5][: face.degrees[0]], []])
    points = bent.points.copy()
    points[face.degrees[0]] *= 1.1
    bent = type(bent)(bent.degrees, bent.knots, points, bent.weights)
    assert bent.without_knots().points.shape == bent.points.shape


def pipe_flow(condition):
    conditions = {"walls": cb.NoSlip(), "inlet": condition, "outlet": cb.Pressure(0.0)}
    return cb.ChannelFlow(cb.StokesProblem(cb.read_cad(PIPE), 1.0, conditions))


@pytest.mark.parametrize(
    ("radius", "one", "two"), [(0.5, 5.947374, 4.995339), (0.6, 11.091897, 8.613007)]
)
def test_sphere_in_a_pipe(radius, one, two):
    """Pulled through a closed pipe, U = F / 6πμa K₁, and carried, U = V₀ K₂ / K₁ (Haberman and
    Sayre 1958), from the file and a default sphere, with no other word."""
    middle = (3.0, 0.0, 0.0)
    carried = cb.rigid_sphere(radius, middle)
    pulled = cb.RigidParticle(carried.shape, middle, force=(1.0, 0.0, 0.0))
    cases = [
        (cb.Inflow(flow_rate=0.0), pulled, 1 / (6 * np.pi * radius * one)),
        (cb.Inflow(mean_velocity=1.0), carried, 2 * two / one),
    ]
    for condition, body, speed in cases:
        simulation = cb.Simulation(pipe_flow(condition), body, accuracy=1e-3)
        state = next(simulation.run(1e-6))
        assert state.velocities[0][0] == pytest.approx(speed, rel=1e-3)
        error = state.accuracy.of("velocity beside walls", "body 1")
        assert abs(state.velocities[0][0] / speed - 1) / 3 < error.relative < 4e-3


def large_box():
    """A closed box at rest, so large that its other walls are far from a sphere of radius 1."""
    faces = [face.swapped() for face in box((-150.0, -150.0, 0.0), (150.0, 150.0, 150.0))]
    patches = [Patch(face, "walls") for face in faces]
    middles = np.array([face.points.reshape(-1, 3).mean(axis=0) for face in faces])
    for name, number in (("inlet", middles[:, 0].argmin()), ("outlet", middles[:, 0].argmax())):
        patches[number] = Patch(faces[number], name)
    boundary = Boundary(tuple(patches))
    boundary = boundary if boundary.volume() > 0 else boundary.turned()
    conditions = {"walls": cb.NoSlip(), "inlet": cb.Inflow(flow_rate=0.0)}
    return cb.ChannelFlow(cb.StokesProblem(boundary, 1.0, conditions | {"outlet": cb.Pressure(0)}))


@pytest.mark.parametrize("gap", [0.1, *[pytest.param(g, marks=pytest.mark.long) for g in GAPS]])
def test_sphere_beside_a_wall(gap):
    """Pulled towards a wall and along it, free to turn, against the bispherical series."""
    flow, height, sphere_ = large_box(), 1 + gap, cb.rigid_sphere().shape
    drag = along_wall(height)
    matrix = np.pi * np.array([[6 * drag["Ft"], 6 * drag["Fr"]], [8 * drag["Tt"], 8 * drag["Tr"]]])
    sign = np.array([[1, -1], [-1, 1]])
    along = np.linalg.solve(abs(matrix) * sign, [1.0, 0.0])[0]
    speeds = {2: 1 / (6 * np.pi * towards_wall(height)), 0: along}
    for axis, speed in speeds.items():
        body = cb.RigidParticle(sphere_, (0.0, 0.0, height), force=np.eye(3)[axis])
        state = next(cb.Simulation(flow, body, accuracy=1e-3).run(1e-9))
        assert state.velocities[0][axis] == pytest.approx(speed, rel=1e-3)


def test_slender_particles_choose_their_points():
    """Torque that turns a spheroid 10 : 1 about a short axis (Jeffery 1922; Chwang and Wu 1975):
    8πμ a³ · 4e³ (2 - e²) / 3 / (-2e + (1 + e²) L), L = ln((1 + e) / (1 - e))."""
    e = np.sqrt(1 - 0.01)
    log = np.log((1 + e) / (1 - e))
    torque = 8 * np.pi * 1000 * 4 / 3 * e**3 * (2 - e**2) / (-2 * e + (1 + e**2) * log)
    body = cb.rigid_ellipsoid((10.0, 1.0, 1.0))
    turned = cb.RigidParticle(body.shape, torque=(0.0, 0.0, torque))
    state = next(cb.Simulation(cb.FreeFlow(cb.at_rest()), turned, accuracy=1e-3).run(1e-6))
    assert state.responses[0].angular_velocity[2] == pytest.approx(1.0, rel=1e-3)


def squeezed():
    """A disc and a droplet that drift along a wall: elements change on the way."""
    flow = plane_channel(6.0)
    droplet = cb.Droplet(cb.spline_circle(0.5, (1.0, 0.4), points=32), cb.SurfaceTension(5.0), 2.0)
    return cb.Simulation(flow, [droplet, disc(2.2, -0.65)], accuracy=1e-2)


def test_elements_follow_and_are_kept(tmp_path):
    """Elements change on the way, and a run that is cut and goes on ends with the same numbers."""
    whole, pieces = tmp_path / "whole", tmp_path / "pieces"
    states = list(run_folder(whole).run(squeezed(), 0.6, 0.1))
    grids = [state.flow.pieces for state in states]
    assert any(g is not None and not g.same_as(grids[0]) for g in grids)
    for count in (1, 3, 9):
        run = run_folder(pieces, resume=pieces.exists()).run(squeezed(), 0.6, 0.1)
        for _ in zip(range(count), run, strict=False):
            pass
        run.close()
    expected, found = stored_numbers(whole), stored_numbers(pieces)
    assert found.keys() == expected.keys()
    for name, values in expected.items():
        np.testing.assert_array_equal(found[name], values, err_msg=name)
    assert same_tables(whole, pieces)
    kept = [frame.shapes for frame in open_run(whole).frames]
    for shapes, state in zip(kept, states, strict=True):
        assert len(shapes[2].patches) == len(state.shapes[2].patches)


def test_a_coarse_wall_is_said():
    """A droplet in a channel of long elements warns of what they do to its speed."""
    pairs = zip(rectangle((0.0, -1.0), (4.0, 1.0)), NAMES, strict=True)
    coarse = Boundary(tuple(Patch(face, name) for face, name in pairs)).elevated(1)
    droplet = cb.Droplet(cb.spline_circle(0.8, (2.0, 0.1), points=48), cb.SurfaceTension(1.0))
    conditions = plane_channel().problem.conditions
    flow = cb.ChannelFlow(cb.StokesProblem(coarse, 1.0, conditions))
    with pytest.warns(AccuracyWarning, match="velocity beside walls 'body 1'"):
        list(cb.Simulation(flow, droplet).run(1e-3))


def test_accuracies_that_cannot_be():
    with pytest.raises(InputError, match="accuracy"):
        cb.Simulation(plane_channel(), disc(2.0, 0.0), accuracy=2.0)
