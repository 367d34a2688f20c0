"""Plugs: their first shapes, and how they move in a round pipe."""

from pipes import flow_in, pipe

import numpy as np
import pytest

import cadbem as cb
from cadbem.boundary import Boundary, Patch
from cadbem.errors import ConditionError, ShapeError
from cadbem.spline.outlines import rectangle
from cadbem.suspension.interface.volume import centre, volume

GEOMETRIES = "geometries"
NAMES = ("inlet", "outlet", "wall", "wall")


def fine_points(shape: cb.ClosedSpline) -> np.ndarray:
    return shape.evaluate(shape.basis.refined(3).parameters())


@pytest.mark.parametrize("radius", [1.1, 2.0])
def test_in_a_round_pipe(radius):
    """R = 1: the volume is the one asked for; the film is 0.15 R; the radius is
    0.85 √(1 - (x/l)^q), so that V = 0.85² π 2 l q / (q + 1); the plug is centred on the axis,
    though its place is not, and has its poles at both ends."""
    target = 4 / 3 * np.pi * radius**3
    shape = cb.plug(pipe(12.0), (0.4, 0.2, -0.1), target)
    assert volume(shape) == pytest.approx(target, rel=1e-12)
    assert centre(shape) == pytest.approx([0.4, 0.0, 0.0], abs=1e-6)
    points = fine_points(shape)
    distance = np.hypot(points[1], points[2])
    assert distance.max() == pytest.approx(0.85, abs=2e-3)
    mean = target / (2 * np.pi * 0.85**2)
    power = 2 * round(mean / 0.85)
    half = mean * (power + 1) / power
    ends = shape.evaluate([[0.0, np.pi], [0.0, 0.0]])
    assert np.sort(ends[0]) == pytest.approx([0.4 - half, 0.4 + half], abs=5e-3 * half)
    assert ends[1:] == pytest.approx(np.zeros((2, 2)), abs=1e-6)
    exact = 0.85 * np.sqrt(1 - np.minimum(np.abs((points[0] - 0.4) / half), 1.0) ** power)
    assert distance == pytest.approx(exact, abs=0.05)
    rows, columns = shape.basis.shape
    assert rows > columns


def test_in_a_square_duct_and_at_a_junction():
    """A duct of width 1: the film is thinner at the sides than in the corners, and nowhere thinner
    than half of what it should be; the plug runs along the duct. The same in one arm of a T, up to
    the junction, where another arm is open to the side; in its middle there is no straight way."""
    for name, place, axis in (
        ("square_channel", (0.0, 0.1, 0.0), 0),
        ("t_junction", (-1.0, 0.0, 0.0), 0),
        ("t_junction", (0.0, -1.75, 0.1), 1),
    ):
        channel = cb.read_cad(f"{GEOMETRIES}/{name}.step")
        shape = cb.plug(channel, place, 0.7)
        assert volume(shape) == pytest.approx(0.7, rel=1e-12)
        points = fine_points(shape) - centre(shape)[:, None]
        assert np.argmax(np.ptp(points, axis=1)) == axis
        aside = np.delete(points, axis, axis=0)
        film = 0.5 - np.abs(aside).max()
        assert 0.5 * 0.075 < film < 0.08
        corner = 0.5 * np.sqrt(2) - np.abs(aside.sum(axis=0)).max() / np.sqrt(2)
        assert corner > 2 * film


def test_in_a_plane_channel():
    """Between plates at y = ±1, an area of 4 and a film of 0.1."""
    faces = rectangle((0.0, -1.0), (8.0, 1.0))
    channel = Boundary(tuple(Patch(f, n) for f, n in zip(faces, NAMES, strict=True)))
    shape = cb.plug(channel, (4.0, 0.3), 4.0, film=0.1)
    points = fine_points(shape)
    assert volume(shape) == pytest.approx(4.0, rel=1e-12)
    assert np.abs(points[1]).max() == pytest.approx(0.9, abs=5e-3)
    assert centre(shape) == pytest.approx([4.0, 0.0], abs=1e-9)


@pytest.mark.parametrize(
    "place, target, words, message",
    [
        ((0.0, 0.0, 0.0), 0.5, {}, "does not fill the channel.*spline_sphere"),
        ((0.0, 0.0, 0.0), 30.0, {}, "goes straight.*smaller volume"),
        ((0.0, 2.0, 0.0), 5.0, {}, "give a point in the channel"),
        ((0.0, 0.0, 0.0), 5.0, {"film": 0.6}, "film=0.6: give a thickness"),
    ],
)
def test_what_cannot_be(place, target, words, message):
    with pytest.raises(ShapeError, match=message):
        cb.plug(pipe(), place, target, **words)


def test_walls_without_a_direction():
    """Between two parallel plates all directions along them are alike."""
    channel = cb.read_cad(f"{GEOMETRIES}/parallel_plates.step")
    with pytest.raises(ShapeError, match="no clear direction; give"):
        cb.plug(channel, (0.0, 0.0, 0.0), 5.0)


def test_a_droplet_that_is_too_large_is_told_of_plugs():
    """A sphere of radius 1.05 at 0.2 from the axis of a pipe of radius 1: up to 0.8 would fit."""
    droplet = cb.Droplet(cb.spline_sphere(1.05, (0, 0.2, 0)), cb.SurfaceTension(1.0))
    with pytest.raises(ConditionError, match=r"radius below 0\.8\b.*cb\.plug\(channel"):
        next(cb.Simulation(flow_in(pipe()), droplet).run(1.0))


# of a sphere of radius 0.9 at rest, λ = 1, Ca = 0.1, by an independent axisymmetric code: time,
# speed, gap and extra pressure
FROM_A_SPHERE = (
    (0.25, 1.297443, 0.1005, 4.178),
    (0.5, 1.292325, 0.1071, 5.930),
    (1.0, 1.325871, 0.1378, 5.547),
    (2.0, 1.376326, 0.1748, 3.945),
)


def measured(state):
    """Speed, film and extra pressure drop of a droplet on the axis of a pipe."""
    points = fine_points(state.droplet.shape)
    film = 1 - np.hypot(points[1], points[2]).max()
    drop = state.walls.mean_pressure("inlet") - state.flow.empty.mean_pressure("inlet")
    return state.velocities[0][0], film, drop


@pytest.mark.parametrize("end", [0.25, pytest.param(2.0, marks=pytest.mark.long)])
def test_from_a_sphere(end):
    """R = V = μ = 1.  It begins at 2 (1 - 2 a² / 5), as the jump of its traction is even: 1.352."""
    way = 0.65 * end
    flow = flow_in(pipe(2.5 + way, 0.25, 1.0 + way))
    droplet = cb.Droplet(cb.spline_sphere(0.9, (-way, 0, 0)), cb.SurfaceTension(10.0))
    simulation = cb.Simulation(
        flow, droplet, points=cb.AdaptivePoints(1e-3), contact=cb.StopAtError()
    )
    history = cb.record(simulation.run(end, every=0.25))
    assert measured(history.at(0.0))[0] == pytest.approx(1.352, abs=1e-5)
    for time, speed, gap, extra in FROM_A_SPHERE:
        if time <= end:
            found = measured(history.at(time))
            assert found[0] == pytest.approx(speed, rel=1e-3)
            assert found[1] == pytest.approx(gap, abs=5e-3)
            assert found[2] == pytest.approx(extra, rel=1e-2)


def recentred(shape):
    """The shape with its centre in the middle of the pipe."""
    back = centre(shape)[0] * np.array([1.0, 0.0, 0.0])
    return cb.ClosedSpline(shape.basis, shape.coefficients - back[:, None, None])


@pytest.mark.long
@pytest.mark.parametrize(
    "ratio, capillary, radius, end, speed, extra, film",
    [
        (1.0, 0.1, 0.7, 3.0, 1.571540, 1.054905, 0.306917),
        (1.0, 0.1, 0.9, 5.0, 1.393501, 3.476070, 0.186581),
        (1.0, 0.1, 1.1, 6.0, 1.400953, 3.660684, 0.184775),
        (1.0, 0.05, 1.0, 4.0, 1.275771, 7.173638, 0.121520),
        (0.1, 0.1, 0.9, 3.0, 1.516091, -2.768206, 0.190880),
    ],
)
def test_steady_plugs(ratio, capillary, radius, end, speed, extra, film):
    """By an independent axisymmetric code; the droplet is moved back now and then."""
    flow, target = flow_in(pipe(5.5, 0.2, 3.0)), 4 / 3 * np.pi * radius**3
    tension, time = cb.SurfaceTension(1 / capillary), 0.0
    shape = cb.plug(flow, (0, 0, 0), target) if radius > 0.9 else cb.spline_sphere(radius)
    while time < end:
        simulation = cb.Simulation(
            flow, cb.Droplet(recentred(shape), tension, ratio), points=cb.AdaptivePoints(1e-3),
            contact=cb.StopAtError(),
        )  # fmt: skip
        *_, state = simulation.run(0.5, every=0.5)
        assert not state.stopped
        shape, time = state.droplet.shape, time + 0.5
    found = measured(state)
    assert found[0] == pytest.approx(speed, rel=1e-3)
    assert found[1] == pytest.approx(film, abs=5e-3)
    assert found[2] == pytest.approx(extra, rel=1e-2)
