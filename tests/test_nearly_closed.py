"""Boundaries with faces missing: refused with their open edges, unless plates are meant."""

from collections.abc import Sequence

import numpy as np
import pytest

import cadbem as cb

MOVING = {"walls": cb.Velocity((1.0, 0.0, 0.0))}


def boundary_of(surfaces: Sequence[cb.Nurbs]) -> cb.Boundary:
    return cb.Boundary(tuple(cb.Patch(s, "walls") for s in surfaces)).elevated(2)


def half_sphere() -> tuple[cb.Nurbs, ...]:
    return cb.sphere_octants()[::2]


NEARLY_CLOSED = {
    "a wall of a box": (cb.box()[:5], r"\(0\.37, 1, 1\)|\(0\.63, 1, 1\)|\(0, 0\.37, 1\)"),
    "two walls that face each other": (cb.box()[2:], r"\(0, "),
    "both ends of a pipe": (cb.cylinder(), r"\(0, "),
    "half a sphere": (half_sphere(), r"edges are open at \("),
    "a wall the other way round": (
        (*cb.box()[:5], cb.box()[5].swapped()),
        "do not point the same way",
    ),
}


@pytest.mark.parametrize("missing", NEARLY_CLOSED)
def test_a_boundary_that_is_nearly_closed_is_refused(missing: str):
    surfaces, place = NEARLY_CLOSED[missing]
    with pytest.raises(cb.ConditionError, match=place) as refused:
        cb.StokesProblem(boundary_of(surfaces), 1.0, MOVING)
    assert "nearly closed" in str(refused.value)
    assert "open=True" in str(refused.value)
    with pytest.raises(cb.ConditionError, match="nearly closed"):
        cb.HeatProblem(boundary_of(surfaces), 1.0, {"walls": cb.Temperature(1.0)})


def test_half_a_sphere_may_be_meant():
    """The drag along its axis lies between that of the disc with its rim, 16 μ a U, and that of
    the whole sphere, 6π μ a U, as drag grows with the body (Hill and Power 1956)."""
    bowl = boundary_of(half_sphere()).refined(3)
    along = {"walls": cb.RigidMotion((0.0, 0.0, 1.0))}
    drag = -cb.StokesProblem(bowl, 1.0, along, open=True).solve().force("walls")[2]
    assert 16.0 < drag < 6 * np.pi


@pytest.mark.parametrize("surfaces", [cb.plate(0.5, 2.0), cb.plate(0.5, 2.0)[:2], cb.box()[:1]])
def test_plates_are_plates(surfaces: tuple[cb.Nurbs, ...]):
    problem = cb.StokesProblem(boundary_of(surfaces), 1.0, MOVING)
    assert [surface.volume for surface in problem.surfaces] == [0.0]


@pytest.mark.parametrize(
    "surfaces", [cb.box(), cb.sphere(), cb.sphere_octants(), cb.ellipsoid((3.0, 1.0, 0.5))]
)
def test_closed_surfaces_have_no_rim(surfaces: tuple[cb.Nurbs, ...]):
    problem = cb.StokesProblem(boundary_of(surfaces), 1.0, {"walls": cb.Velocity((0.0, 0.0, 0.0))})
    assert [surface.rim for surface in problem.surfaces] == [()]


def test_a_wall_in_four_pieces_closes_a_box():
    """Edges that belong to the halves of their neighbours only."""
    sides = cb.box()
    halves = [sides[5].restricted((a, a + 0.5), (0.0, 1.0)) for a in (0.0, 0.5)]
    problem = cb.StokesProblem(
        boundary_of((*sides[:5], *halves)), 1.0, {"walls": cb.Velocity((0, 0, 0))}
    )
    assert problem.surfaces[0].holds_fluid
