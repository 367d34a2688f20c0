"""What values say when they are printed: a few lines, with what is known of them, at once."""

from pathlib import Path

import numpy as np
import pytest

import cadbem as cb
from cadbem.spline.outlines import rectangle
from cadbem.tables import MOST, Overview, count, html_table

GEOMETRIES = Path(__file__).parents[1] / "geometries"
LONGEST = 1500  # letters


def printed(value: object) -> str:
    """What a value says, which must be short."""
    text = repr(value)
    assert len(text) < LONGEST
    return " ".join(text.split())


@pytest.fixture(scope="module")
def channel() -> cb.Boundary:
    """2 mm long, 1 mm wide and high."""
    return cb.read_cad(GEOMETRIES / "square_channel.step").elevated(2).refined(2)


@pytest.fixture(scope="module")
def solution(channel) -> cb.StokesSolution:
    """Mean velocity 1, viscosity 1."""
    inlet = cb.Inflow(mean_velocity=1.0)
    conditions = {"inlet": inlet, "outlet": cb.Pressure(0.0), "walls": cb.NoSlip()}
    return cb.StokesProblem(channel, 1.0, conditions, cb.Quadrature(1e-5)).solve()


@pytest.fixture(scope="module")
def run() -> cb.History:
    droplet = cb.Droplet(cb.spline_circle(points=16, centre=(1.0, 2.0)), cb.SurfaceTension(0.5), 2)
    return cb.record(cb.Simulation(cb.FreeFlow(cb.shear(dimension=2)), droplet).run(0.2, 0.1))


def test_boundary(channel):
    """Six faces, of 1 × 1 at the ends, 4 × 2 × 1 of walls."""
    text = printed(channel)
    assert "Boundary in 3D" in text and "square_channel.step" in text
    assert "6 patches, 24 elements, degree 2, 96 functions" in text
    assert "inlet 1 1" in text and "outlet 1 1" in text and "walls 4 8" in text
    assert "<td>walls</td><td>4</td><td>8</td>" in channel._repr_html_()
    assert f"area ({channel.unit}²)" in text


def test_shapes():
    assert printed(cb.sphere()[0]).startswith("NURBS surface in 3D: degree 4 × 4, 5 × 5 control")
    assert printed(rectangle((0, 0), (1, 1))[0]) == (
        "NURBS curve in 2D: degree 1, 2 control points"
    )
    text = printed(cb.spline_circle(2.0, points=24))
    assert "Closed curve in 2D: degree 4, 24 = 24 points" in text


def test_space_and_field(solution):
    assert printed(solution.space).startswith("Space: 96 functions and collocation points")
    assert "Field of 3 components on 96 functions" in printed(solution.velocity)


def test_stokes(solution):
    """What enters is 1, and leaves; the pressure at the outlet is 0."""
    text = printed(solution.problem)
    assert "Stokes flow in 3D" in text and "viscosity 1" in text
    assert "inlet Inflow(mean_velocity=1.0)" in text and "walls NoSlip()" in text
    text = printed(solution)
    drop = solution.mean_pressure("inlet")
    assert f"inlet Inflow(mean_velocity=1.0) 1 1 {drop:.5g}" in text
    assert "solved" in text and "outlet Pressure(value=0.0) 1 -1 " in text
    assert "<th>mean pressure</th>" in solution._repr_html_()


def test_flow_around_a_body():
    """The force on a unit sphere that moves with velocity 1 is -6π μ."""
    sphere = cb.Boundary(tuple(cb.Patch(s, "body") for s in cb.sphere())).elevated(4)
    motion = cb.RigidMotion((1.0, 0.0, 0.0))
    text = printed(cb.StokesProblem(sphere, 1.0, {"body": motion}, cb.Quadrature(1e-6)).solve())
    assert "no file, dimensionless" in text and "(-18.85, " in text


def test_heat():
    """A square at 0 and 1 on two sides, insulated on the others: the heat that passes is 1."""
    names = ("low", "right", "high", "left")
    sides = zip(rectangle((0, 0), (1, 1)), names, strict=True)
    square = cb.Boundary(tuple(cb.Patch(side, name) for side, name in sides)).elevated(2)
    conditions = {"left": cb.Temperature(1.0), "right": cb.Temperature(0.0)}
    conditions |= {"low": cb.HeatFlux(0.0), "high": cb.HeatFlux(0.0)}
    given = dict(zip(names, (conditions[p.name] for p in square.patches), strict=True))
    problem = cb.HeatProblem(square, 1.0, given)
    text = printed(problem)
    assert "Heat conduction in 2D" in text and "conductivity 1, no source" in text
    assert "heat that enters" in printed(problem.solve())


def test_bodies():
    droplet = cb.Droplet(cb.spline_sphere(2.0, (1, 0, 0), 50), cb.SurfaceTension(0.5), 3.0)
    text = printed(droplet)
    assert "Droplet in 3D at (1, 0, 0), volume 33.5" in text and "viscosity ratio 3" in text
    assert "SurfaceTension(tension=0.5), 50 points of degree 4" in text
    text = printed(cb.rigid_sphere(1.0, (0.0, 2.0, 0.0), spans=1))
    assert "Rigid particle in 3D at (0, 2, 0), volume 4.18" in text and "no load" in text


def test_run(run):
    text = printed(run.states[0])
    assert "State at time 0, 1 body" in text and "1 droplet (1, 2) 1.77" in text
    text = printed(run)
    assert "History: 3 states from time 0 to 0.2" in text and "unbounded fluid" in text
    flow = cb.FreeFlow(cb.shear(dimension=2), viscosity=2.0)
    text = printed(cb.Simulation(flow, run.states[0].droplet, cb.Adaptive(1e-3)))
    assert "Simulation of 1 body" in text and "of viscosity 2" in text and "Adaptive(" in text


def test_many_bodies_are_counted():
    shapes = [cb.spline_circle(points=16, centre=(3.0 * k, 0.0)) for k in range(40)]
    droplets = [cb.Droplet(shape, cb.SurfaceTension(1.0)) for shape in shapes]
    text = printed(cb.Simulation(cb.FreeFlow(cb.shear(dimension=2)), droplets))
    assert "Simulation of 40 bodies" in text and f"and {40 - MOST} more" in text


def test_runs(run, tmp_path):
    assert printed(cb.run_folder("")) == "Run folder: none, nothing is kept"
    folder = cb.run_folder(tmp_path / "made")
    simulation = cb.Simulation(run.states[0].flow, run.states[0].droplet)
    cb.record(folder.run(simulation, 0.2, every=0.1))
    assert "3 frames in" in printed(folder) and "run.json" in printed(folder)
    assert f"{folder}" == str(tmp_path / "made")
    text = printed(cb.open_run(tmp_path / "made"))
    assert "3 frames, time 0 to 0.2" in text and "unbounded fluid" in text


def test_network_and_tracers(solution):
    """G of two openings is (g, -g; -g, g)."""
    network = cb.network_of(solution.problem)
    g = f"{network.conductance[0, 0]:.4g}"
    assert f"inlet {g} -{g} outlet -{g} {g}" in printed(network)
    assert "<th>outlet</th>" in network._repr_html_()
    tracers = cb.trace(solution, np.array([[-0.5, 0.1, 0.0], [-0.5, -0.1, 0.0]]).T)
    assert "2 tracers, mean residence time" in printed(tracers)
    assert "outlet 2 100.00%" in printed(tracers)


@pytest.mark.parametrize(
    ("number", "thing", "text"),
    [(1, "patch", "1 patch"), (2, "patch", "2 patches"), (0, "body", "0 bodies"),
     (3, "frame", "3 frames")],
)  # fmt: skip
def test_words(number: int, thing: str, text: str):
    assert count(number, thing) == text


def test_tables():
    cells = "<tr><th>a&lt;b</th></tr><tr><td>1</td></tr>"
    assert html_table(("a<b",), [("1",)]) == f"<table>{cells}</table>"
    assert Overview("title", ("", "fact")).text() == "title\n  fact"
    assert "<b>title</b>" in Overview("title").html()
