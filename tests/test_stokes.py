"""Stokes problems against exact flows, and the errors that a user can make."""

import json
from pathlib import Path

import numpy as np
import pytest
from shapes import bulged, channel

from cadbem.boundary import Boundary, Patch
from cadbem.errors import ConditionError, InputError, SelectionError, ShapeError
from cadbem.problems.conditions import Inflow, NoSlip, Pressure, Traction, Velocity
from cadbem.problems.profiles import circle_profile, rectangle_profile
from cadbem.problems.stokes import StokesProblem
from cadbem.quadrature import Quadrature, UniformSubdivision
from cadbem.spline.shapes import box

REFERENCE = json.loads((Path(__file__).parent / "data" / "reference.json").read_text())
DUCT = {"inlet": Inflow(mean_velocity=1.0), "outlet": Pressure(0.0), "walls": NoSlip()}
SQUARE = channel()


def duct(degree, across, along, **changes):
    boundary = SQUARE.elevated(degree).refined(size=(2 / along, 1 / across, 1 / across))
    return StokesProblem(boundary, 1.0, DUCT | changes).solve()


def gradient(solution):
    return (solution.mean_pressure("outlet") - solution.mean_pressure("inlet")) / 2


@pytest.fixture(scope="module")
def thesis_channel():
    return duct(2, 7, 17)


@pytest.mark.parametrize("case", ["W1_H1", "W2_H1", "W4_H1"])
def test_rectangle_profile(case):
    """Centre velocity over mean velocity of the duct; no slip on all four sides; symmetry."""
    width = float(case[1])
    values = REFERENCE["duct"][case]
    centre = rectangle_profile(np.zeros(1), np.zeros(1), width, 1.0)[0]
    assert centre == pytest.approx(float(values["umax_over_umean"]), rel=1e-12)
    y, z = np.linspace(-0.49, 0.49, 8) * width, np.linspace(-0.47, 0.5, 8)
    edge = np.full(8, 0.5)
    assert abs(rectangle_profile(edge * width, z, width, 1.0)).max() < 1e-9
    assert abs(rectangle_profile(y, edge, width, 1.0)).max() < 1e-9
    turned = rectangle_profile(z, y, 1.0, width)
    assert turned == pytest.approx(rectangle_profile(y, z, width, 1.0), abs=1e-11)


def test_circle_profile_has_mean_one():
    """∫₀¹ 2(1 - r²) 2r dr = 1."""
    r, w = np.polynomial.legendre.leggauss(5)
    r, w = 0.5 * (r + 1), 0.5 * w
    assert circle_profile(r, 1.0) * 2 * r @ w == pytest.approx(1.0)


def test_square_channel(thesis_channel):
    """846 points of degree 2: flux below 1e-4, gradient within 0.1 % of the exact one."""
    exact = -float(REFERENCE["duct"]["W1_H1"]["minus_dpdx_over_muUm"])
    assert thesis_channel.space.count == 846
    assert abs(thesis_channel.net_flux()) < 1e-4
    assert thesis_channel.net_force() < 1e-4
    assert gradient(thesis_channel) == pytest.approx(exact, rel=1e-3)
    assert thesis_channel.flow_rate("inlet") == pytest.approx(1.0, abs=1e-12)


def test_velocity_and_pressure_inside_up_to_the_wall(thesis_channel):
    """The duct's profile and linear pressure, from mid-channel to 1e-6 of the width away."""
    y = np.linspace(-0.4, 0.4, 9)
    for depth in (0.3, 0.05, 1e-3, 1e-6, 0.0):
        points = np.array([0 * y + 0.13, y, 0 * y + 0.5 - depth])
        exact = rectangle_profile(y, points[2], 1.0, 1.0)
        velocity = thesis_channel.velocity_at(points)
        assert abs(velocity[0] - exact).max() < 1.5e-3
        assert abs(velocity[1:]).max() < 1e-4
        pressure = thesis_channel.pressure_at(points)
        assert abs(pressure - 28.4541538 * (1 - 0.13)).max() < 0.05


def test_points_of_another_shape_are_refused(thesis_channel):
    for points in ([0.0, 0.2, 0.0], [[0.0, 0.2]]):
        with pytest.raises(ShapeError, match=r"give coordinates \(3, N\), a column a point"):
            thesis_channel.velocity_at(points)


def test_duct_converges():
    """The gradient's error falls at a fitted slope of at least 2 in the number of spans, and
    degree 4 beats degree 2 at fewer points (what limits is the r² log r in the corners)."""
    exact = -float(REFERENCE["duct"]["W1_H1"]["minus_dpdx_over_muUm"])
    spans = [3, 5, 8]
    solved = [duct(2, n, 2 * n) for n in spans]
    errors = [abs(gradient(s) / exact - 1) for s in solved]
    assert -np.polyfit(np.log(spans), np.log(errors), 1)[0] > 2
    high = duct(4, 4, 4)
    assert high.space.count < solved[-1].space.count
    assert abs(gradient(high) / exact - 1) < errors[-1]


def graded_duct(degree, spans, levels, ratio):
    """One element along the channel; across, finer at its four long edges; and errors of flux,
    force, gradient, and velocity on the outlet's line z = -0.047."""
    boundary = SQUARE.elevated(degree).refined(size=(2, 1 / spans, 1 / spans))
    boundary = boundary.graded(levels, ratio, toward=lambda x, inward: abs(inward[0]) < 0.5)
    solution = StokesProblem(boundary, 1.0, DUCT, Quadrature(1e-10)).solve()
    y = np.linspace(-0.45, 0.45, 21)
    line = np.array([0 * y + 1, y, 0 * y - 0.047])
    velocity = solution.velocity_at(line)[0] - rectangle_profile(y, line[2], 1.0, 1.0)
    exact = -float(REFERENCE["duct"]["W1_H1"]["minus_dpdx_over_muUm"])
    errors = solution.net_flux(), solution.net_force(), gradient(solution) / exact - 1
    return solution.space.count, [*map(abs, errors), abs(velocity).max()]


def test_grading_and_degree_remove_the_corners():
    """At about 400 points degree 4 on graded knots is far beyond degree 2 on 846 even ones."""
    count, errors = graded_duct(4, 4, 1, 0.35)
    assert count < 500
    assert np.all(np.array(errors) < [1e-6, 2e-6, 2e-5, 3e-4])


@pytest.mark.long
def test_what_1000_points_can_do():
    """Degree 6, 960 points: flux 1e-8, force balance 5e-8, gradient 2e-7, outlet velocity 2e-6."""
    count, errors = graded_duct(6, 8, 1, 0.35)
    assert count == 960
    assert np.all(np.array(errors) < [1e-8, 5e-8, 2e-7, 2e-6])


def test_wide_channel():
    """Four times as wide as high: the gradient of the duct series within 0.3 %."""
    boundary = channel((-1, -2, -0.5), (1, 2, 0.5)).elevated(2).refined(size=(0.5, 0.4, 0.2))
    solution = StokesProblem(boundary, 1.0, DUCT).solve()
    exact = -float(REFERENCE["duct"]["W4_H1"]["minus_dpdx_over_muUm"])
    assert gradient(solution) == pytest.approx(exact, rel=3e-3)


def test_zero_traction_outlet_is_another_problem():
    """The thesis's literal outlet condition moves the outlet's velocity by a tenth of the mean,
    which ``Pressure`` keeps to 1 %."""
    y, z = (g.ravel() for g in np.meshgrid(*[np.linspace(-0.45, 0.45, 9)] * 2))
    points = np.array([0 * y + 1, y, z])
    exact = rectangle_profile(y, z, 1.0, 1.0)
    free = duct(2, 4, 8, outlet=Traction((0.0, 0.0, 0.0)))
    assert abs(free.velocity_at(points)[0] - exact).max() > 0.1
    assert abs(duct(2, 4, 8).velocity_at(points)[0] - exact).max() < 0.01


def test_couette_flow_is_exact():
    """u = (z, 0, 0), p = 0: linear, so that splines hold it; all walls move with it."""
    linear = Velocity(lambda x: np.array([x[2], 0 * x[0], 0 * x[0]]))
    conditions = {"inlet": linear, "walls": linear, "outlet": Traction((0.0, 0.0, -1.0))}
    boundary = SQUARE.elevated(2).refined(2)
    solution = StokesProblem(boundary, 1.0, conditions, Quadrature(1e-11)).solve()
    points = np.array([[0.0, 0.9, -0.5], [0.1, -0.4, 0.2], [0.2, 0.49, -0.499]])
    exact = np.array([points[2], 0 * points[0], 0 * points[0]])
    assert abs(solution.velocity_at(points) - exact).max() < 1e-8
    assert abs(solution.pressure_at(points)).max() < 1e-7


def test_a_closed_inlet():
    """An inflow of 0 beside a pressure-driven flow: the opening acts as a wall."""
    boundary = Boundary(tuple(Patch(s) for s in box((0, 0, 0), (3, 1, 1)))).named(
        low=lambda x, n: n[0] > 0.9, high=lambda x, n: n[0] < -0.9, side=lambda x, n: n[1] > 0.9,
        rest="walls",
    )  # fmt: skip
    ends = {"low": Pressure(1.0), "high": Pressure(0.0), "walls": NoSlip()}
    boundary = boundary.elevated(3)
    open_, closed = (
        StokesProblem(boundary, 1.0, ends | {"side": side}).solve()
        for side in (NoSlip(), Inflow(flow_rate=0.0))
    )
    assert closed.flow_rate("low") == pytest.approx(open_.flow_rate("low"), rel=1e-12)


def test_viscosity_and_flow_rate_scale_the_pressure():
    """Stokes flow is linear: Δp doubles with μ and with Q; flow rate = mean velocity × area."""
    boundary = channel((0, 0, 0), (2, 2, 1)).elevated(2).refined(2)
    one = StokesProblem(boundary, 1.0, DUCT).solve()
    two = StokesProblem(boundary, 2.0, DUCT | {"inlet": Inflow(flow_rate=2.0)}).solve()
    assert two.flow_rate("inlet") == pytest.approx(2.0)
    assert two.mean_pressure("inlet") == pytest.approx(2 * one.mean_pressure("inlet"), rel=1e-9)


def test_pressure_drives_the_flow():
    """Between two pressures the flow rate is that of the duct: Q = G W⁴ 0.0351442537 / μ."""
    boundary = SQUARE.elevated(3).refined(4)
    conditions = {"inlet": Pressure(2.0), "outlet": Pressure(0.0), "walls": NoSlip()}
    solution = StokesProblem(boundary, 1.0, conditions).solve()
    exact = float(REFERENCE["duct"]["W1_H1"]["flowrate_G_over_mu_1"])
    assert solution.flow_rate("inlet") == pytest.approx(exact, rel=2e-3)


def test_surface_pressure_of_a_moving_boundary():
    """u = (x, -y, 0), p = 3: on any surface f·n = -3 + 2 n·E·n, and p is recovered."""
    strain = Velocity(lambda x: np.array([x[0], -x[1], 0 * x[0]]))
    closed = bulged().elevated(3).refined(3)
    names = ["outlet"] + ["walls"] * 5
    patches = [Patch(p.surface, n, p.face) for p, n in zip(closed.patches, names, strict=True)]
    outlet = patches[0].middle()
    assert outlet.normal[:, 0] == pytest.approx([1, 0, 0], abs=1e-12)
    boundary = Boundary(tuple(patches))
    flat = channel().elevated(2).refined(2)
    conditions = {"inlet": strain, "walls": strain, "outlet": Traction((1.0, 0.0, 0.0))}
    solution = StokesProblem(flat, 1.0, conditions, Quadrature(1e-10)).solve()
    # at the outlet f = σ·n = -(-3 + 2, 0, 0)
    assert solution.surface_pressure(2, [0.3], [0.4]) == pytest.approx([3.0], abs=1e-6)
    assert solution.pressure_at([[0.1], [0.2], [0.3]]) == pytest.approx([3.0], abs=1e-6)
    assert boundary.names == ("outlet", "walls")


@pytest.mark.parametrize(
    ("conditions", "words"),
    [
        ({"inlet": Inflow(mean_velocity=1.0), "outlet": Pressure()}, "'walls'.*has no condition"),
        (DUCT | {"lid": NoSlip()}, "a condition is given for 'lid'.*'inlet', 'outlet', 'walls'"),
        (DUCT | {"inlet": NoSlip()}, "no inlet"),
        (DUCT | {"outlet": NoSlip()}, "let 1 more in than out.*give .* a Pressure"),
        (DUCT | {"walls": Pressure()}, "'walls' is not flat"),
        (DUCT | {"walls": "no slip"}, "'walls' has 'no slip' for a condition"),
    ],
)
def test_mistakes_in_conditions(conditions, words):
    with pytest.raises(ConditionError, match=words) as error:
        StokesProblem(SQUARE, 1.0, conditions).solve()
    assert "\n" not in str(error.value)


def test_other_mistakes():
    with pytest.raises(InputError, match="viscosity is -1"):
        StokesProblem(SQUARE, -1.0, DUCT)
    with pytest.raises(ConditionError, match="either mean_velocity or flow_rate"):
        Inflow()
    with pytest.raises(ConditionError, match="either mean_velocity or flow_rate"):
        Inflow(mean_velocity=1.0, flow_rate=1.0)
    nameless = Boundary(tuple(Patch(p.surface, "", p.face) for p in SQUARE.patches))
    with pytest.raises(ConditionError, match="face 1 at .* has no name"):
        StokesProblem(nameless, 1.0, DUCT)


def test_an_unknown_name_lists_the_names(thesis_channel):
    with pytest.raises(SelectionError, match="'inlet', 'outlet', 'walls'"):
        thesis_channel.flow_rate("outflow")


def test_selecting_faces():
    """By name, number, point and predicate; doubled and empty selections are refused."""
    boundary = channel()
    assert boundary.select(3) == (2,)
    assert boundary.select((-1.0, 0.1, 0.2)) == (0,)
    assert boundary.select(lambda position, normal: normal[2] < -0.5) == (5,)
    renamed = boundary.named(rest="sides", lid=lambda position, normal: position[2] > 0.4)
    assert renamed.names == ("lid", "sides")
    with pytest.raises(SelectionError, match="both as 'a' and as 'b'"):
        boundary.named(a=1, b=(-1.0, 0.0, 0.0))
    with pytest.raises(SelectionError, match="several faces"):
        boundary.named(a=(-1.0, -0.5, 0.0))
    with pytest.raises(SelectionError, match="selects no face"):
        boundary.named(a="lid")


def test_the_thesis_quadrature_stays_selectable():
    """With uniform subdivision the channel is solved too, a little worse."""
    boundary = SQUARE.elevated(2).refined(size=(2 / 8, 1 / 4, 1 / 4))
    ours = StokesProblem(boundary, 1.0, DUCT).solve()
    theirs = StokesProblem(boundary, 1.0, DUCT, UniformSubdivision()).solve()
    assert gradient(theirs) == pytest.approx(gradient(ours), rel=1e-3)
    assert gradient(theirs) != pytest.approx(gradient(ours), rel=1e-9)
