"""Gaps between bodies and walls, what happens when they are narrow, and leaving a channel."""

from dataclasses import replace

import numpy as np
import pytest

import cadbem as cb
from cadbem.boundary import Boundary, Patch
from cadbem.errors import ConditionError
from cadbem.quadrature.closed import PolarRule
from cadbem.spline.outlines import rectangle
from cadbem.suspension.multibody.neighbours import Neighbours

NAMES = ("inlet", "outlet", "walls", "walls")


def plane_channel(length: float = 4.0, moving: bool = True) -> cb.ChannelFlow:
    """Two plates at y = ±1 from x = 0 on; flow of mean velocity 1, or a closed box at rest but
    for its slowly sliding lower wall."""
    faces = rectangle((0.0, -1.0), (length, 1.0))
    names = NAMES if moving else ("side", "side", "lid", "side")
    boundary = Boundary(tuple(Patch(f, n) for f, n in zip(faces, names, strict=True)))
    boundary = boundary.elevated(3).refined(size=0.5)
    conditions = {"inlet": cb.Inflow(mean_velocity=1.0), "outlet": cb.Pressure(0.0),
                  "walls": cb.NoSlip()}  # fmt: skip
    if not moving:
        slide = cb.Velocity(lambda x: np.stack([1e-3 * x[0] * (length - x[0]), 0 * x[0]]))
        conditions = {"side": cb.NoSlip(), "lid": slide}
    return cb.ChannelFlow(cb.StokesProblem(boundary, 1.0, conditions))


def disc(x: float, y: float, radius: float = 0.3) -> cb.RigidParticle:
    return cb.rigid_ellipsoid((radius, radius), (x, y))


def drop(x: float, y: float, radius: float = 0.3) -> cb.Droplet:
    return cb.Droplet(cb.spline_circle(radius, (x, y), points=32), cb.SurfaceTension(5.0))


def test_distances():
    """Two circles, two spheres of either kind: the gap is the distance of centres minus radii.

    It is found from samples of one body, up to s/2 off the line of centres in each direction:
    wider by at most 2 (s/2)² (1/R + 1/r) / 2, with s = 0.4 × 2π/40 and radii 1 and 0.4."""
    pairs = [(disc(0, 0, 1.0), drop(1.5, 0, 0.4)), (drop(0, 0, 1.0), disc(1.5, 0, 0.4))]
    pairs.append((cb.rigid_sphere(1.0, (0, 0, 0)), cb.rigid_sphere(0.4, (1.2, 0.9, 0.0))))
    ball = cb.Droplet(cb.spline_sphere(0.4, (1.2, 0.9, 0.0)), cb.SurfaceTension(1.0))
    pairs.append((cb.rigid_sphere(1.0, (0, 0, 0)), ball))
    for pair in pairs:
        neighbours = Neighbours([b.placed(PolarRule()) for b in pair])
        assert 0.1 - 1e-6 < neighbours.between(1, 0, 1.0) < 0.1 + 3.5e-3
        assert neighbours.between(0, 1, 0.01) == np.inf or neighbours.between(0, 1, 0.01) > 0.09
        assert neighbours.nearest(1, 1.0) == (neighbours.between(1, 0, 1.0), 0)


@pytest.mark.parametrize("place, named", [
    ((2.0, 1.2), "walls"), ((2.0, 0.8), "walls"), ((6.0, 0.0), "outlet"), ((0.1, 0.0), "inlet"),
])  # fmt: skip
def test_bodies_start_inside(place, named):
    """Outside, across a wall, beyond and across openings: refused by name."""
    for body in (disc(*place), drop(*place)):
        with pytest.raises(ConditionError, match=f"body 1, around.*{named}"):
            next(cb.Simulation(plane_channel(), body).run(1.0))


def test_bodies_start_apart():
    with pytest.raises(ConditionError, match="body 1, around .*not clear of body 2"):
        next(cb.Simulation(plane_channel(), [disc(2.0, 0.0), drop(2.3, 0.2)]).run(1.0))


def test_leaving():
    """A disc and a droplet on the axis leave one after the other, first the one in front; the run
    ends with the second, and says so.  They keep to the axis by symmetry."""
    simulation = cb.Simulation(plane_channel(), [drop(1.0, 0.0), disc(2.6, 0.0)])
    states = list(simulation.run(10.0))
    last = states[-1]
    assert sorted(last.left) == [1, 2] and last.numbers == (1,)
    assert last.stopped.count("left through 'outlet' at time") == 2
    assert last.time < 4.0
    for state in states:
        assert abs(state.bodies[0].centre[1]) < 1e-6
        assert state.bodies[0].centre[0] < 4.0
    assert [s.numbers for s in states[:2]] == [(1, 2), (1, 2)]
    assert abs(last.bodies[0].drift(simulation.start.bodies[0])) < 1e-12


def test_falling_onto_a_wall():
    """A pushed disc never reaches the wall: the run stops while the gap is still wider than a
    fifth of the points' spacing (of 28 points on a circle of radius 0.3), and no step closes
    more than half of a narrow gap."""
    pushed = replace(disc(2.0, -0.3), force=(0.0, -10.0))
    states = list(cb.Simulation(plane_channel(moving=False), pushed).run(100.0))
    gaps = np.array([1 - 0.3 - abs(s.bodies[0].centre[1]) for s in states])
    spacing = 2 * np.pi * 0.3 / 28
    assert states[-1].stopped.startswith("body 1 is 0.0")
    assert "contact=Repel" in states[-1].stopped
    assert 0.2 * spacing < gaps[-1] < spacing
    narrow = gaps[1:] < spacing
    assert (gaps[1:][narrow] > 0.49 * gaps[:-1][narrow]).all()


def test_repulsion_carries_the_load():
    """With a short-range pressure the disc comes to rest where ∫ Π dx over its underside is the
    force: for a gap g₀ at the lowest point, g = g₀ + R - sqrt(R² - x²)."""
    rule = cb.Repel(reach=0.1, strength=300.0)
    pushed = replace(disc(2.0, -0.55), force=(0.0, -10.0))
    *_, last = cb.Simulation(plane_channel(moving=False), pushed, contact=rule).run(20.0)
    assert not last.stopped
    response = last.responses[0]
    gap = last.bodies[0].centre[1] + 1 - 0.3
    x = np.linspace(-0.3, 0.3, 20001)
    gaps = gap + 0.3 - np.sqrt(np.maximum(0.09 - x**2, 0.0))
    load = (rule.strength * np.clip(1 - gaps / rule.reach, 0, None) ** 2).mean() * 0.6
    assert load == pytest.approx(10.0, rel=0.02)
    assert abs(response.velocity[1]) < 1e-3
