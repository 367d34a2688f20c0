"""Where droplets end up."""

from pathlib import Path

import numpy as np
import pytest
from test_stokes_2d import CHANNEL, channel

import cadbem as cb

ROOT = Path(__file__).parents[1]


def drop(radius: float, centre) -> cb.Droplet:
    return cb.Droplet(cb.spline_circle(radius, centre, 20), cb.SurfaceTension(20.0))


def test_in_a_straight_channel():
    """A round droplet with λ = 1 moves with the mean flow over its area: on the centreline at
    u (1 - (R / 2H)²), u = 3 and H = 1/4 half the width; it leaves when less than its points'
    distance, 2 π R / 20, from x = 1."""
    boundary = channel().elevated(2).refined(size=0.2)
    flow = cb.ChannelFlow(cb.StokesProblem(boundary, 1.0, CHANNEL, cb.Quadrature(1e-5)))
    simulation = cb.Simulation(flow, drop(0.1, (0.2, 0.0)), stepper=cb.Adaptive(3e-2))
    fate = cb.droplet_fate(simulation, 1.0)
    assert fate.opening == "outlet" and "left through 'outlet'" in fate.ended
    speed = (fate.path[0, -1] - fate.path[0, 0]) / fate.time
    assert speed == pytest.approx(3.0 * (1 - (0.1 / 0.5) ** 2), rel=0.01)
    assert 0 < 0.9 - fate.path[0, -1] < 2 * np.pi * 0.1 / 20
    assert abs(fate.path[1]).max() < 1e-4
    assert fate.deformation < 0.02
    assert fate.gap > 0.1
    stuck = cb.droplet_fate(simulation, 0.05, 0.05)
    assert (stuck.opening, stuck.ended) == ("", "still inside at time 0.05")


def test_sides_of_a_junction():
    """Mirror images leave through mirror images of an opening."""
    plan = cb.read_outline(ROOT / "geometries" / "t_junction.step").elevated(2).refined(size=0.5)
    ends = {"inlet_b": cb.Inflow(flow_rate=1.0)}
    ends |= {"inlet_a": cb.Pressure(0.0), "outlet": cb.Pressure(0.0), "walls": cb.NoSlip()}
    flow = cb.ChannelFlow(cb.StokesProblem(plan, 1.0, ends, cb.Quadrature(1e-4)))
    droplets = [drop(0.15, (x, -0.5)) for x in (-0.15, 0.15)]
    simulation = cb.Simulation(flow, droplets[0], stepper=cb.Adaptive(3e-2))
    left, right = cb.droplet_fates(simulation, droplets, 12.0)
    assert (left.opening, right.opening) == ("inlet_a", "outlet")
    assert left.time == pytest.approx(right.time, rel=0.02)
    assert left.deformation == pytest.approx(right.deformation, rel=0.05)
