"""What a history tells of each body over time, and the pictures of a whole run."""

import numpy as np
import pytest
from pictures_in import pictures_in

import cadbem as cb


@pytest.fixture(scope="module")
def run() -> cb.History:
    """Two plane droplets in u = (y, 0), alike but for a turn by half about the origin."""
    shapes = [cb.spline_circle(points=24, centre=centre) for centre in ((-3.0, 1.0), (3.0, -1.0))]
    droplets = [cb.Droplet(shape, cb.capillary_tension(0.2)) for shape in shapes]
    simulation = cb.Simulation(cb.FreeFlow(cb.shear(dimension=2)), droplets)
    return cb.record(simulation.run(0.4, every=0.2))


def test_course(run):
    """Far from each other droplets are carried with the fluid at their centres, u = (±1, 0); their
    D is that of the shape, and grows at 1 / (1 + λ) at first."""
    first, second = (run.course(number) for number in run.numbers)
    assert first.velocity[:, 0] == pytest.approx([1.0, 0.0], abs=0.05)
    assert first.velocity == pytest.approx(-second.velocity, abs=1e-8)
    assert first.speed == pytest.approx(np.hypot(*first.velocity))
    assert first.centre[:, 0] == pytest.approx([-3.0, 1.0])
    assert first.way == pytest.approx(0.4, rel=0.05)
    assert first.deformation[1] == pytest.approx(cb.taylor_deformation(run.states[1].shapes[1]))
    assert first.deformation[1] == pytest.approx(0.2 / 2, rel=0.3)
    assert np.isinf(first.gap).all() and first.extra_pressure == {}


def test_course_of_a_particle_has_no_deformation():
    particle = cb.rigid_sphere(1.0, (0.0, 0.0, 0.5), spans=1)
    run = cb.record(cb.Simulation(cb.FreeFlow(cb.shear()), particle).run(0.1))
    course = run.course()
    assert np.isnan(course.deformation).all()
    assert course.velocity[:, 0] == pytest.approx([0.5, 0.0, 0.0], abs=1e-5)


def test_draw_run(run, tmp_path):
    made = cb.draw_run(tmp_path / "all", run)
    names = {"movie.gif", "filmstrip.png", "paths.png", "series.png"}
    assert pictures_in(tmp_path / "all") == names == {path.name for path in made}
    cb.draw_run(tmp_path / "some", run, ("filmstrip.png",), colour="mean curvature")
    assert pictures_in(tmp_path / "some") == {"filmstrip_mean_curvature.png"}


def test_reports(run):
    """Two bodies that move by the speed 1 of the fluid at their centres, for 0.4."""
    lines = cb.bodies_report(run, cb.Units("mm")).splitlines()
    assert lines[0].split("  ")[-1] == "fate" and "way (mm)" in lines[0]
    assert len(lines) == 1 + len(run.numbers) + 1
    way, speed = map(float, lines[1].split()[2:4])
    assert way == pytest.approx(0.4, abs=0.02) and speed == pytest.approx(1.0, abs=0.05)
    lines = cb.course_report(run).splitlines()
    assert len(lines) == 1 + len(run.times) + 1
    assert lines[1].split()[:2] == ["0.000", "-3.000"] and lines[1].split()[-1] == "-"
