"""Channels made longer at their openings."""

from pathlib import Path

import numpy as np
import pytest
from shapes import bulged, channel

import cadbem as cb
from cadbem.boundary import Boundary, Patch
from cadbem.errors import InputError, SelectionError
from cadbem.extension import extended
from cadbem.spline.outlines import line, rectangle

GEOMETRIES = Path(__file__).parents[1] / "geometries"


def closed(boundary):
    """|∮ n dS| over the area: 0 for a closed surface."""
    points, weights = boundary.quadrature()
    return np.linalg.norm(points.normal @ weights) / weights.sum()


@pytest.mark.parametrize(
    ("file", "name", "cross_section", "rim", "walls"),
    [
        ("square_channel", "outlet", 1.0, 4.0, 4),
        ("round_pipe", "outlet", np.pi, 2 * np.pi, 4),
        ("round_pipe", "inlet", np.pi, 2 * np.pi, 4),
        ("y_junction", "outlet", 16.0, 16.0, 6),
        ("y_junction", "inlet_b", 16.0, 16.0, 4),
    ],
)
def test_volume_and_area(file, name, cross_section, rim, walls):
    """A piece of length 1.7 adds its cross-section's area times 1.7 to the volume, and its rim's
    length times 1.7 to the area, also after other degrees and knots; no gap opens."""
    for boundary in (cb.read_cad(GEOMETRIES / f"{file}.step"),
                     cb.read_cad(GEOMETRIES / f"{file}.step").elevated(3).refined(2)):  # fmt: skip
        longer = extended(boundary, name, 1.7)
        assert longer.volume() == pytest.approx(boundary.volume() + 1.7 * cross_section, rel=1e-11)
        assert longer.area() == pytest.approx(boundary.area() + 1.7 * rim, rel=1e-11)
        assert closed(longer) < 1e-13
        assert len(longer.patches) == len(boundary.patches) + walls
        assert {p.name for p in longer.patches[-walls:]} == {"walls"}
        assert longer.source == boundary.source and longer.unit == boundary.unit


def test_walls_take_their_neighbours_names():
    """Four differently named walls: the piece over each has its name and face, twice over."""
    names = ("inlet", "outlet", "left", "right", "floor", "lid")
    sides = zip(channel().patches, names, strict=True)
    boundary = Boundary(tuple(Patch(p.surface, name, p.face) for p, name in sides))
    longer = extended(extended(boundary, "outlet", 0.5), "outlet", 0.5)
    assert longer.bounds().tolist() == [[-1, -0.5, -0.5], [2, 0.5, 0.5]]
    for face, name in enumerate(names[2:], start=3):
        area = Boundary(tuple(p for p in longer.patches if p.name == name)).area()
        assert area == pytest.approx(3.0)
        assert {p.face for p in longer.patches if p.name == name} == {face}


def plane_channel(*halves):
    """Length 2, width 0.5; the outlet at x = 1 in one piece, or from ±0.25 to each other."""
    names = ("inlet", "outlet", "walls", "walls")
    patches = [Patch(s, n) for s, n in zip(rectangle((-1, -0.25), (1, 0.25)), names, strict=True)]
    if halves:
        patches[1] = Patch(line((1, 0.25), (1, 0.1)), "outlet")
        patches.append(Patch(line((1, 0.1), (1, -0.25)), "outlet"))
    return Boundary(tuple(patches))


@pytest.mark.parametrize("halves", [(), (True,)])
def test_plane_channel(halves):
    """Two walls more, whether or not the opening is in two pieces: area 2.5 × 0.5."""
    boundary = extended(plane_channel(*halves), "outlet", 0.5)
    assert boundary.volume() == pytest.approx(1.25)
    assert boundary.area() == pytest.approx(6.0)
    assert closed(boundary) < 1e-14
    assert len(boundary.patches) == 6 + len(halves)


def test_developed_flow_through_it():
    """Between plates u = 1.5 U (1 - (2y/W)²), p = 12 μ U / W² × length: in splines of degree 2
    exactly, through a channel that was made longer at both ends."""
    boundary = extended(extended(plane_channel(), "inlet", 0.5), "outlet", 1.0)
    conditions = {
        "inlet": cb.Inflow(mean_velocity=2.0), "outlet": cb.Pressure(), "walls": cb.NoSlip()
    }  # fmt: skip
    problem = cb.StokesProblem(boundary.elevated(2).refined(size=0.25), 1.0, conditions)
    solution = problem.solve()
    assert solution.mean_pressure("inlet") == pytest.approx(12 * 2 / 0.25 * 3.5, rel=1e-6)
    velocity = solution.velocity_at([[-1.4, 1.0, 1.9], [0.1, 0.1, -0.2]])
    assert velocity[0] == pytest.approx(3 * (1 - 16 * np.array([0.01, 0.01, 0.04])), abs=1e-6)


def test_developed_flow_through_a_pipe():
    """Hagen and Poiseuille: the pressure falls by 8 μ U / R² a length, over 6 + 2 here."""
    boundary = extended(cb.read_cad(GEOMETRIES / "round_pipe.step"), "outlet", 2.0)
    conditions = {
        "inlet": cb.Inflow(mean_velocity=1.0), "outlet": cb.Pressure(), "walls": cb.NoSlip()
    }  # fmt: skip
    solution = cb.StokesProblem(boundary.elevated(3).refined(size=1.0), 1.0, conditions).solve()
    assert solution.mean_pressure("inlet") == pytest.approx(64.0, rel=2e-3)
    assert solution.velocity_at([[7.0], [0.0], [0.0]])[0] == pytest.approx([2.0], rel=5e-3)


def test_mistakes():
    with pytest.raises(SelectionError, match="no face is named 'exit'.*'inlet', 'outlet', 'walls'"):
        extended(channel(), "exit", 1.0)
    with pytest.raises(SelectionError, match="'walls' is not flat"):
        extended(channel(), "walls", 1.0)
    with pytest.raises(InputError, match="length is -1"):
        extended(channel(), "outlet", -1.0)
    alone = Boundary(channel().patches[1:2])
    with pytest.raises(SelectionError, match="'outlet' has no wall at"):
        extended(alone, "outlet", 1.0)
    curved = Boundary(tuple(Patch(p.surface, f"side{i}") for i, p in enumerate(bulged().patches)))
    with pytest.raises(SelectionError, match="'side0' is not flat"):
        extended(curved, "side0", 1.0)
