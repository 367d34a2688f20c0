"""Accuracy that is asked for: true errors stay below it, and estimates tell them.

Exact values: series of ducts (White, Viscous Fluid Flow, eq. 3-48), Poiseuille's law, Stokes's
drag, Haberman and Sayre's sphere in a pipe.  The T-junction has no closed form; its pressures
333.92 and 343.606 (per unit of viscosity and mean velocity, to 1e-5) come from eight uniform and
graded grids of degree 3 to 6 with up to 6958 points, extrapolated in the width of the smallest
element.
"""

import json
import warnings
from pathlib import Path

import gmsh
import numpy as np
import pytest

import cadbem as cb
from cadbem.boundary import Boundary, Patch
from cadbem.elements.initial import first_elements
from cadbem.elements.reentrant import singular_parts
from cadbem.problems.bodies import closed_surfaces
from cadbem.problems.continuity import shear
from cadbem.problems.profiles import port
from cadbem.problems.straightness import tilt
from cadbem.spline.outlines import line
from cadbem.spline.shapes import box, sphere

GEOMETRIES = Path(__file__).parents[1] / "geometries"
REFERENCE = json.loads((Path(__file__).parent / "data" / "reference.json").read_text())
SQUARE = float(REFERENCE["duct"]["W1_H1"]["minus_dpdx_over_muUm"])
FASTEST = float(REFERENCE["duct"]["W1_H1"]["umax_over_umean"])
T_PRESSURES = np.array([333.92, 343.606])


def duct(length=3.0):
    patches = tuple(Patch(s) for s in box((0, 0, 0), (length, 1, 1)))
    ends = {"inlet": lambda x, n: n[0] > 0.9, "outlet": lambda x, n: n[0] < -0.9}
    return Boundary(patches).named(rest="walls", **ends)


def through(boundary, **options):
    conditions = {n: cb.Inflow(mean_velocity=1.0) for n in boundary.names if n.startswith("inlet")}
    conditions |= {"outlet": cb.Pressure(0.0), "walls": cb.NoSlip()}
    return cb.StokesProblem(boundary, 1.0, conditions, **options)


@pytest.mark.parametrize("accuracy", [1e-2, pytest.param(1e-3, marks=pytest.mark.long)])
def test_square_duct(accuracy):
    """Pressure drop, speed in the middle and flow rate against the series."""
    flow = through(duct()).solve(accuracy)
    estimate = flow.accuracy.of("mean pressure", "inlet")
    error = abs(flow.mean_pressure("inlet") / (3 * SQUARE) - 1)
    assert error <= accuracy
    assert error / 3 <= estimate.relative <= accuracy
    middle = flow.velocity_at([[1.5], [0.5], [0.5]])[0, 0]
    assert middle == pytest.approx(FASTEST, rel=accuracy)
    assert flow.flow_rate("outlet") == pytest.approx(-1.0, rel=accuracy)


def test_velocity_at_a_point():
    """The goal: the largest velocity of a developed flow, by its own adjoint."""
    flow = through(duct()).solve(1e-3, goal=[[1.5], [0.5], [0.5]])
    estimate = flow.accuracy.of("x velocity", "point 0")
    assert estimate.value == pytest.approx(FASTEST, rel=1e-3)
    assert abs(estimate.value - FASTEST) <= 3 * estimate.error <= 3e-3 * FASTEST


def test_largest_wall_shear():
    """Of a square duct: 9.6074 μU/h at the middle of its sides (the series' slope, 9.608); where
    elements join it jumps by no more than was asked."""
    flow = through(duct(2.0)).solve(5e-2, goal="wall shear")
    peak = flow.accuracy.of("largest wall shear")
    assert abs(peak.value - 9.608) <= 3 * peak.error <= 0.15 * 9.608
    assert flow.accuracy.of("jump of the wall shear").relative <= 5e-2


@pytest.mark.long
def test_order_at_reentrant_edges():
    """A Y-junction, whose inlets have the pressure 44.9578 (overrefined runs agree to 2e-6): from
    1e-2 to 1e-4 the error falls faster than with the fourth power of √points; even elements of
    degree 2 reach 1.8."""
    junction = through(cb.read_cad(GEOMETRIES / "y_junction.step"))
    flows = [junction.solve(a, goal="openings") for a in (1e-2, 1e-4)]
    errors = [abs(f.mean_pressure("inlet_a") / 44.9578 - 1) for f in flows]
    fall = np.log(errors[0] / errors[1])
    assert fall / np.log(np.sqrt(flows[1].space.count / flows[0].space.count)) > 4


def test_curvature_jumps_are_found():
    """Between a straight pipe and a bend, of inner radius 2 and outer radius 4, the curvature along
    the channel jumps by up to 1/2 and 1/4; in a straight pipe it jumps nowhere."""
    pipe, straight = (cb.read_cad(GEOMETRIES / f"{n}_pipe.step") for n in ("bent", "round"))
    jumps = [x for sides in singular_parts(pipe).bends for x in sides.values() if x > 1e-6]
    assert max(jumps) == pytest.approx(0.5, rel=1e-2)
    assert min(jumps) == pytest.approx(0.25, rel=1e-2)
    assert max(max(s.values()) for s in singular_parts(straight).bends) < 1e-6


LONG = [pytest.param(accuracy, marks=pytest.mark.long) for accuracy in (1e-2, 1e-3)]


@pytest.mark.parametrize("accuracy", [2e-2, *LONG])
def test_wall_shear_goes_on_where_a_bend_begins(accuracy):
    """From both sides of the joints of a bent pipe, x = 2 and y = 3."""
    pipe = cb.read_cad(GEOMETRIES / "bent_pipe.step")
    flow = through(pipe).solve(accuracy, goal="wall shear")
    values: dict = {}
    for number, patch in enumerate(flow.space.boundary.patches):
        lines = [np.linspace(*ends, 7) for ends in patch.surface.domain]
        place = [g.ravel() for g in np.meshgrid(*lines, indexing="ij")]
        x = patch.surface.evaluate(*place)
        joint = (abs(x[0] - 2) < 1e-9) & (x[1] < 2) | (abs(x[1] - 3) < 1e-9) & (x[0] > 2)
        if patch.name == "walls" and joint.any():
            along = shear(flow.traction, number, [p[joint] for p in place])
            for point, value in zip(x[:, joint].T, along.T, strict=True):
                values.setdefault(tuple(np.round(point, 6) + 0.0), []).append(value)
    jumps = [np.ptp(v, axis=0).max() for v in values.values() if len(v) > 1]
    assert len(jumps) > 40
    assert max(jumps) <= accuracy * flow.accuracy.of("largest wall shear").value


def test_plane_channel():
    """Poiseuille flow lies in the space: 12 μ U L / h² to round-off, and the estimate knows it."""
    corners = [(0, 0), (3, 0), (3, 1), (0, 1)]
    names = ["walls", "outlet", "walls", "inlet"]
    ends = zip(corners, corners[1:] + corners[:1], names, strict=True)
    flow = through(Boundary(tuple(Patch(line(b, a), n) for a, b, n in ends))).solve(1e-3)
    assert flow.mean_pressure("inlet") == pytest.approx(36.0, rel=1e-6)
    assert flow.accuracy.of("mean pressure", "inlet").relative < 1e-6


def test_drag_of_a_sphere():
    """6πμaU from the coarsest drawing; forces across vanish and are judged by μUa."""
    boundary = Boundary(tuple(Patch(s, "body") for s in sphere()))
    motion = {"body": cb.RigidMotion((1.0, 0.0, 0.0))}
    flow = cb.StokesProblem(boundary, 1.0, motion).solve(1e-3)
    assert flow.force("body")[0] == pytest.approx(-6 * np.pi, rel=1e-6)
    assert flow.accuracy.relative < 1e-3


def warm_box(source=None):
    """A box with φ = 1 + cos πy on the side x = 1, 0 on x = 0, insulated around."""
    sides = {"hot": lambda x, n: n[0] < -0.9, "cold": lambda x, n: n[0] > 0.9}
    boundary = Boundary(tuple(Patch(s) for s in box())).named(rest="walls", **sides)
    conditions = {
        "hot": cb.Temperature(lambda x: 1 + np.cos(np.pi * x[1])),
        "cold": cb.Temperature(0.0),
        "walls": cb.HeatFlux(0.0),
    }
    return cb.HeatProblem(boundary, 1.0, conditions, source)


@pytest.mark.parametrize("goal", [None, "heat rates", lambda s: s.heat_rate("hot")])
def test_heat_rate(goal):
    """The mean of the temperature counts, so that the heat rate is 1."""
    solution = warm_box().solve(1e-3, goal=goal)
    assert solution.heat_rate("hot") == pytest.approx(1.0, rel=1e-3)
    found = {e.quantity for e in solution.accuracy.estimates}
    assert ("temperature in the mean square" in found) == (goal is None)
    assert solution.accuracy.relative <= 1e-3


@pytest.mark.parametrize("source", [None, 2.0])
def test_temperature_at_a_point(source):
    """φ = x + cos πy sinh πx / sinh π, and b x (1 - x) / 2 of a source b."""
    solution = warm_box(source).solve(1e-3, goal=[[0.3], [0.2], [0.6]])
    exact = 0.3 + np.cos(0.2 * np.pi) * np.sinh(0.3 * np.pi) / np.sinh(np.pi)
    exact += 0.0 if source is None else source * 0.3 * 0.7 / 2
    estimate = solution.accuracy.of("temperature", "point 0")
    assert estimate.value == pytest.approx(exact, abs=1e-3 * estimate.scale)
    assert solution.temperature_at([[0.3], [0.2], [0.6]])[0] == pytest.approx(estimate.value)
    assert estimate.relative <= 1e-3


def test_unknown_goals_of_heat_are_refused():
    with pytest.raises(cb.ConditionError, match="goal='openings' is not known; give 'heat rates'"):
        warm_box().solve(1e-2, goal="openings")


@pytest.fixture(scope="module")
def junctions(tmp_path_factory):
    """One T-junction drawn in six ways, with the scale of its length."""
    folder = tmp_path_factory.mktemp("junctions")

    def drawn(name, boxes, pieces=True):
        gmsh.initialize()
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.option.setNumber("Geometry.OCCUnionUnify", int(not pieces))
        occ = gmsh.model.occ
        tags = [(3, occ.addBox(*b)) for b in boxes]
        occ.fuse(tags[:1], tags[1:])
        occ.synchronize()
        gmsh.write(str(folder / name))
        gmsh.finalize()
        return cb.read_cad(folder / name)

    arms = [(-4, -0.5, -0.5, 8, 1, 1), (-0.5, -4.5, -0.5, 1, 4, 1)]
    short = [(x, -0.5, -0.5, 1, 1, 1) for x in range(-4, 4)]
    short += [(-0.5, -y - 1.5, -0.5, 1, 1, 1) for y in range(4)]
    whole = drawn("whole.step", arms, pieces=False)
    turn = np.linalg.qr(np.random.default_rng(3).normal(size=(3, 3)))[0]
    turn *= np.sign(np.linalg.det(turn))
    return {
        "few faces": (whole, 1.0, np.eye(3)),
        "many faces": (drawn("short.step", short), 1.0, np.eye(3)),
        "two boxes": (drawn("boxes.step", arms), 1.0, np.eye(3)),
        "IGES": (drawn("whole.igs", arms, pieces=False), 1.0, np.eye(3)),
        "turned": (whole.transformed(turn), 1.0, turn),
        "metres": (whole.transformed(1e-3 * np.eye(3)), 1e-3, np.eye(3)),
    }


def named(boundary, scale=1.0, turn=None):
    """The junction's openings by name."""
    turn = np.eye(3) if turn is None else turn
    places = {"inlet_a": (-4, 0, 0), "inlet_b": (0, -4.5, 0), "outlet": (4, 0, 0)}
    places = {n: np.array(p, dtype=float) for n, p in places.items()}

    def at(place, axis):
        return lambda x, n: abs(turn.T @ (x / scale) - place)[axis] < 1e-6

    return boundary.named(
        rest="walls", **{n: at(p, int(np.argmax(abs(p)))) for n, p in places.items()}
    )


def pressures(drawing, accuracy):
    boundary, scale, turn = drawing
    flow = through(named(boundary, scale, turn)).solve(accuracy, goal="openings")
    found = np.array([flow.mean_pressure(n) for n in ("inlet_a", "inlet_b")]) * scale
    return found / T_PRESSURES - 1, flow.accuracy


DRAWINGS = ["few faces", "many faces", "two boxes", "IGES", "turned", "metres"]


@pytest.mark.parametrize("name", DRAWINGS)
def test_no_way_of_drawing_changes_the_answer(junctions, name):
    """A T-junction within one per cent, whatever its faces, format, direction and unit."""
    errors, accuracy = pressures(junctions[name], 1e-2)
    assert abs(errors).max() <= 1e-2
    assert accuracy.relative >= abs(errors).max() / 3


@pytest.mark.long
@pytest.mark.parametrize("name", DRAWINGS)
def test_no_way_of_drawing_changes_three_digits(junctions, name):
    """The same within a thousandth."""
    errors, accuracy = pressures(junctions[name], 1e-3)
    assert abs(errors).max() <= 1e-3
    assert accuracy.relative >= abs(errors).max() / 3


def test_reentrant_edges_are_found(junctions):
    """The two edges of a T-junction, one wall on each side: four sides, and four corners of floor
    and ceiling (the T-shaped faces are two patches each, which share a corner)."""
    boundary, *_ = junctions["few faces"]
    singular = singular_parts(boundary)
    assert sum(map(len, singular.sides)) == 4
    assert any(singular.corners)
    finer = first_elements(boundary, 2)
    assert finer.area() == pytest.approx(boundary.area(), rel=1e-12)
    assert not any(singular_parts(duct()).sides)


def test_patches_that_meet_at_hanging_corners_are_one_surface():
    """A box whose lid is cut in two where its sides are not."""
    *sides, lid = box()
    halves = [lid.restricted(b, (0.0, 1.0)) for b in ((0.0, 0.4), (0.4, 1.0))]
    surfaces = closed_surfaces(Boundary(tuple(Patch(s) for s in (*sides, *halves))))
    assert len(surfaces) == 1
    assert surfaces[0].volume == pytest.approx(1.0)


def test_a_coarse_grid_warns_and_knows_by_how_much(junctions):
    """Four elements of degree 2 a face are 17 % off in a T-junction; the estimate covers it."""
    boundary = named(junctions["few faces"][0]).elevated(2).refined(4)
    with pytest.warns(cb.AccuracyWarning, match="mean pressure 'inlet_a' may be off"):
        flow = through(boundary).solve()
    error = abs(flow.mean_pressure("inlet_a") / T_PRESSURES[0] - 1)
    assert error > 0.15
    assert error / 3 <= flow.accuracy.of("mean pressure", "inlet_a").relative <= 20 * error


def test_a_limit_of_points_is_said():
    with pytest.warns(cb.AccuracyWarning, match="is not reached: .* most_points=800"):
        flow = through(duct()).solve(1e-6, most_points=400)
    assert flow.space.count <= 400
    assert flow.accuracy.relative > 1e-6


@pytest.mark.parametrize("accuracy", [0.0, -1.0, 2.0, np.nan, np.inf])
def test_an_accuracy_must_make_sense(accuracy):
    with pytest.raises(cb.InputError, match="accuracy is .*; give a number from"):
        through(duct()).solve(accuracy)


def test_a_goal_of_ones_own():
    """Any number of a solution, judged by its change: the pressure drop over a flow rate."""
    flow = through(duct()).solve(1e-2, goal=lambda s: s.mean_pressure("inlet"))
    assert flow.accuracy.worst.quantity == "the goal"
    assert flow.mean_pressure("inlet") == pytest.approx(3 * SQUARE, rel=1e-2)


def test_unknown_goals_are_refused():
    with pytest.raises(cb.ConditionError, match="goal='drag'"):
        through(duct()).solve(1e-2, goal="drag")
    with pytest.raises(cb.ConditionError, match="a dense matrix only"):
        through(duct(), storage=cb.Compressed(1e-6)).solve(1e-2, goal=[[1.5], [0.5], [0.5]])


@pytest.mark.parametrize("points", [[[1.5, 0.5]], [1.5, 0.5, 0.5], [[np.nan], [0.5], [0.5]]])
def test_points_of_a_goal_have_a_shape(points):
    with pytest.raises(cb.ConditionError, match="give finite coordinates"):
        through(duct()).solve(1e-2, goal=points)


def test_points_of_a_goal_lie_in_the_fluid():
    with pytest.raises(cb.ConditionError, match="is outside the boundary"):
        through(duct()).solve(1e-2, goal=[[1.5, 9.0], [0.5, 0.5], [0.5, 0.5]])


def test_compressed_matrices_are_judged_by_reciprocity():
    """The same flow with both: estimates differ by less than a factor of three, and cover the true
    error."""
    flows = [
        through(duct(), storage=storage).solve(1e-2, goal="openings")
        for storage in (cb.Dense(), cb.Compressed(1e-7))
    ]
    dense, rough = (f.accuracy.of("mean pressure", "inlet").relative for f in flows)
    assert dense / 3 < rough < 3 * dense
    assert abs(flows[1].mean_pressure("inlet") / (3 * SQUARE) - 1) < 3 * rough


@pytest.mark.parametrize(("angle", "found"), [(0, 0), (30, 30)])
def test_slanted_openings_are_told(angle, found):
    """A duct sheared so that its inlet is cut at an angle: its walls lean by that against the
    inlet's axis."""
    shear = np.eye(3)
    shear[0, 1] = np.tan(np.deg2rad(angle))
    boundary = duct(4.0).transformed(shear)
    walls = [i for i, p in enumerate(boundary.patches) if p.name == "walls"]
    inlet = port("inlet", [p for p in boundary.patches if p.name == "inlet"])
    assert tilt(boundary, inlet, walls) == pytest.approx(found, abs=1e-6)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        through(boundary).solve(0.1)
    lines = [str(w.message) for w in caught if "lean by" in str(w.message)]
    assert len(lines) == (2 if angle else 0)
    assert all("extended" in text for text in lines)


def test_slanted_openings_are_told_once_for_all_data():
    """However many solutions share a matrix."""
    shear = np.eye(3)
    shear[0, 1] = np.tan(np.deg2rad(30))
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        problem = through(duct(4.0).transformed(shear).elevated(3))
        for speed in (1.0, 2.0):
            flow = problem.with_data({"inlet": cb.Inflow(mean_velocity=speed)}).solve()
        flow.problem.with_data({"inlet": cb.Inflow(mean_velocity=3.0)}).solve()
    assert sum("lean by" in str(w.message) for w in caught) == 2


def test_weights_integrate_the_space():
    """Σ w = area on patches of one element and of several, where x² is in the space, Σ w x² too."""
    for boundary in (Boundary(tuple(Patch(s) for s in box())).elevated(3),
                     Boundary(tuple(Patch(s) for s in box())).elevated(2).refined(3)):  # fmt: skip
        space = cb.StokesProblem(
            boundary.named(rest="walls"), 1.0, {"walls": cb.Velocity((1.0, 0, 0))}
        ).space
        assert space.weights.sum() == pytest.approx(6.0)
        # four sides with ∫ x² = 1/3 each, one with 0 and one with 1
        x = space.collocation.position[0]
        assert space.weights @ x**2 == pytest.approx(4 / 3 + 1)
        assert space.weights.min() > 0
