"""Runs in folders: restart after any end, tables, frames, and what is refused."""

import csv
import errno
import os
import signal
import time
from math import pi
from pathlib import Path

import h5py
import numpy as np
import pytest
import pyvista

import cadbem as cb
from cadbem.errors import ResultsError
from cadbem.results import open_run, run_folder
from cadbem.results.describe import described, first_difference
from cadbem.results.progress import BEFORE, CHECKPOINT, frame_file
from cadbem.spline.outlines import rectangle

END, EVERY = 0.5, 0.05


def plane_droplet(capillary: float = 0.3) -> cb.Simulation:
    """λ = 2, so that the equations are iterated from a guess."""
    tension = cb.capillary_tension(capillary)
    return cb.Simulation(
        cb.FreeFlow(cb.shear(dimension=2)), cb.Droplet(cb.spline_circle(points=32), tension, 2.0)
    )


def mixture() -> cb.Simulation:
    """A droplet, λ = 2, and a sphere that feel each other."""
    droplet = cb.Droplet(cb.spline_sphere(points=72), cb.capillary_tension(0.3), 2.0)
    bodies = [droplet, cb.rigid_sphere(0.5, (0.2, 1.8, 0.1), spans=2)]
    return cb.Simulation(cb.FreeFlow(cb.shear()), bodies)


def gone_through(output: Path, simulation: cb.Simulation, resume: bool = False, end=END) -> list:
    folder = run_folder(output, resume=resume)
    return list(folder.run(simulation, end, EVERY))


def stored_numbers(folder: Path) -> dict[str, np.ndarray]:
    """All numbers in all frames."""
    found = {}
    for index in range(len(open_run(folder).times)):
        with h5py.File(frame_file(folder, index)) as file:
            def keep(name, item, index=index):
                if hasattr(item, "shape"):
                    found[f"{index} {name}"] = item[()]

            file.visititems(keep)
            found[f"{index} time"] = file.attrs["time"]
    return found


def same_tables(one: Path, other: Path) -> bool:
    """The tables are alike but for the CPU time."""
    for name in ("run.csv", "bodies.csv"):
        rows = [list(csv.DictReader((folder / name).open())) for folder in (one, other)]
        for row in (*rows[0], *rows[1]):
            row.pop("cpu_seconds", None)
        if rows[0] != rows[1]:
            return False
    return True


def killed(seconds: float, work) -> bool:
    """Do the work in a child process, killed by SIGKILL after so many seconds, if it lasts."""
    child = os.fork()
    if child == 0:
        try:
            work()
        finally:
            os._exit(0)
    deadline = time.monotonic() + seconds
    while time.monotonic() < deadline:
        if os.waitpid(child, os.WNOHANG)[0]:
            return False
        time.sleep(0.002)
    os.kill(child, signal.SIGKILL)
    return os.waitpid(child, 0)[1] != 0


@pytest.mark.parametrize(("simulation", "longest"), [(plane_droplet, 0.25), (mixture, 1.5)])
def test_killed_at_random_moments(tmp_path, simulation, longest):
    """Twenty times in all, and gone on with each time: the frames are those of a run without a
    pause, to the last bit."""
    whole, pieces = tmp_path / "whole", tmp_path / "pieces"
    gone_through(whole, simulation())
    moments, kills = np.random.default_rng(5), 0
    while kills < 10:
        again = (pieces / "run.json").exists()
        kills += killed(
            moments.uniform(0.02, longest),
            lambda again=again: gone_through(pieces, simulation(), resume=again),
        )
    gone_through(pieces, simulation(), resume=True)
    expected, found = stored_numbers(whole), stored_numbers(pieces)
    assert found.keys() == expected.keys()
    for name, values in expected.items():
        np.testing.assert_array_equal(found[name], values, err_msg=name)
    assert same_tables(whole, pieces)


def channel_with_a_mixture() -> cb.Simulation:
    """A droplet, λ = 2, and a sphere between the walls of a duct."""
    names = ("inlet", "outlet", "walls", "walls", "walls", "walls")
    sides = zip(cb.box((-2, -1, -1), (2, 1, 1)), names, strict=True)
    duct = cb.Boundary(tuple(cb.Patch(side, name) for side, name in sides)).elevated(2).refined(2)
    data = {"inlet": cb.Inflow(1.0), "outlet": cb.Pressure(0.0), "walls": cb.NoSlip()}
    droplet = cb.Droplet(cb.spline_sphere(0.4, (-0.5, 0.1, 0.0), 72), cb.SurfaceTension(2.0), 2.0)
    bodies = [droplet, cb.rigid_sphere(0.3, (0.6, 0.0, 0.1), spans=1)]
    return cb.Simulation(cb.ChannelFlow(cb.StokesProblem(duct, 1.0, data)), bodies)


@pytest.mark.parametrize("kept", [pytest.param(1, marks=pytest.mark.long), 3])
def test_a_channel_with_a_droplet_and_a_sphere_goes_on_to_the_last_bit(tmp_path, kept: int):
    whole, pieces = tmp_path / "whole", tmp_path / "pieces"
    gone_through(whole, channel_with_a_mixture(), end=0.2)
    states = run_folder(pieces).run(channel_with_a_mixture(), 0.2, EVERY)
    for _ in range(kept):
        next(states)
    states.close()
    gone_through(pieces, channel_with_a_mixture(), resume=True, end=0.2)
    expected, found = stored_numbers(whole), stored_numbers(pieces)
    for name, values in expected.items():
        np.testing.assert_array_equal(found[name], values, err_msg=name)
    assert same_tables(whole, pieces)


def test_from_the_outside(tmp_path):
    """A finished run: what was asked, tables of the shapes' own measures, and ParaView's frames
    whose points lie on the stored surfaces."""
    simulation = mixture()
    states = gone_through(tmp_path / "run", simulation, end=0.1)
    run = open_run(tmp_path / "run")
    assert run.times.tolist() == [s.time for s in states] == [0.0, 0.05, 0.1]
    asked = (tmp_path / "run" / "run.json").read_text()
    assert "test_results.py" in asked and '"end": 0.1' in asked and "numpy" in asked
    table = run.body_table
    first = table["body"] == 1
    found = [cb.taylor_deformation(s.droplet.shape) for s in states]
    np.testing.assert_allclose(table["deformation"][first], found, rtol=1e-12)
    np.testing.assert_allclose(table["volume"][first], 4 * pi / 3, rtol=1e-3)
    assert np.isnan(table["deformation"][~first]).all()
    spin = table["angular_velocity_y"][~first]
    np.testing.assert_allclose(spin, 0.5, rtol=0.1)  # half the shear rate, if it were alone
    for frame, state in zip(run.frames, states, strict=True):
        for number, shape in state.shapes.items():
            stored = frame.shapes[number]
            if isinstance(shape, cb.ClosedSpline):
                np.testing.assert_array_equal(stored.coefficients, shape.coefficients)
            else:
                for a, b in zip(stored.patches, shape.patches, strict=True):
                    np.testing.assert_allclose(a.surface.points, b.surface.points, atol=1e-14)
    reader = pyvista.get_reader(tmp_path / "run" / "paraview" / "bodies.pvd")
    assert reader.time_values == pytest.approx([0.0, 0.05, 0.1])
    reader.set_active_time_value(0.1)
    particle = reader.read()[0].threshold((1.5, 2.5), scalars="body").points
    distance = np.linalg.norm(particle - states[-1].bodies[1].centre, axis=1)
    assert distance.min() > 0.4 and distance.max() < 0.6  # control points of a sphere of 0.5


def test_a_later_end_goes_on(tmp_path):
    """To the same shape as one run, within the error of steps; frames before stay."""
    whole = gone_through(tmp_path / "whole", plane_droplet())
    gone_through(tmp_path / "parts", plane_droplet(), end=0.2)
    kept = stored_numbers(tmp_path / "parts")
    longer = gone_through(tmp_path / "parts", plane_droplet(), resume=True)
    assert [s.time for s in longer] == pytest.approx([s.time for s in whole])
    again = stored_numbers(tmp_path / "parts")
    assert all(np.array_equal(again[name], values) for name, values in kept.items())
    found = cb.taylor_deformation(longer[-1].droplet.shape)
    assert found == pytest.approx(cb.taylor_deformation(whole[-1].droplet.shape), abs=2e-4)


@pytest.mark.parametrize("call", [1, 4, 9])
def test_full_disk(tmp_path, monkeypatch, call):
    """At any write the run ends with one line, and goes on when there is room again."""
    whole, folder = tmp_path / "whole", tmp_path / "run"
    gone_through(whole, plane_droplet())
    count, usual = 0, os.fsync

    def full(file):
        nonlocal count
        count += 1
        if count > call:
            raise OSError(errno.ENOSPC, "No space left on device")
        usual(file)

    with monkeypatch.context() as patch:
        patch.setattr(os, "fsync", full)
        with pytest.raises(ResultsError, match="No space left on device.*cadbem resume"):
            gone_through(folder, plane_droplet())
    gone_through(folder, plane_droplet(), resume=(folder / "run.json").exists())
    expected, found = stored_numbers(whole), stored_numbers(folder)
    assert all(np.allclose(found[name], values, rtol=1e-12) for name, values in expected.items())


def test_what_exists_is_kept(tmp_path):
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "thesis.tex").write_text("years of work")
    with pytest.raises(ResultsError, match="exists already; choose another folder"):
        run_folder(tmp_path / "mine")
    with pytest.raises(ResultsError, match="exists already"):
        run_folder(tmp_path / "mine" / "thesis.tex")
    gone_through(tmp_path / "run", plane_droplet(), end=0.05)
    with pytest.raises(ResultsError, match="go on with 'cadbem resume"):
        gone_through(tmp_path / "run", plane_droplet())


def test_no_folder_can_be_made(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(ResultsError, match="choose a folder that you may write to"):
        run_folder(tmp_path / "file" / "run")


@pytest.mark.skipif(not Path("/proc").is_dir(), reason="no folder that refuses its owner")
def test_read_only_folder():
    with pytest.raises(ResultsError, match="choose a folder that you may write to"):
        run_folder("/proc/cadbem_run")


def test_nothing_to_go_on_with(tmp_path):
    with pytest.raises(ResultsError, match="holds no run"):
        run_folder(tmp_path / "nothing", resume=True)
    with pytest.raises(ResultsError, match="no frames"):
        open_run(tmp_path)


def test_another_simulation_is_refused(tmp_path):
    gone_through(tmp_path / "run", plane_droplet(0.3), end=0.05)
    with pytest.raises(ResultsError, match="bodies.interface.tension: 3.33.* then, 2.5 now"):
        gone_through(tmp_path / "run", plane_droplet(0.4), resume=True)


def test_changed_input_is_refused(tmp_path):
    cad = tmp_path / "chip.step"
    cad.write_text("one")
    run_folder(tmp_path / "run", cad)
    cad.write_text("two")
    with pytest.raises(ResultsError, match="chip.step has changed"):
        run_folder(tmp_path / "run", cad, resume=True)


def test_one_process_at_a_time(tmp_path):
    states = run_folder(tmp_path / "run").run(plane_droplet(), END, EVERY)
    next(states)
    other = run_folder(tmp_path / "run", resume=True).run(plane_droplet(), END, EVERY)
    with pytest.raises(ResultsError, match="another process is writing"):
        next(other)
    states.close()
    assert "interrupted" in (tmp_path / "run" / "log.txt").read_text()


def test_damaged_files_are_named(tmp_path):
    gone_through(tmp_path / "run", plane_droplet(), end=0.05)
    for name in (CHECKPOINT, BEFORE):
        (tmp_path / "run" / name).write_bytes(b"no numbers")
    with pytest.raises(ResultsError, match="checkpoint.h5 is missing or damaged"):
        gone_through(tmp_path / "run", plane_droplet(), resume=True)


def test_without_a_folder_nothing_is_kept(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    folder = run_folder("")
    assert not folder
    assert len(list(folder.run(plane_droplet(), 0.1, 0.05))) == 3
    folder.summary({"D": 1.0})
    assert not list(tmp_path.iterdir())


def test_each_simulation_has_a_part_of_its_own(tmp_path):
    folder = run_folder(tmp_path / "run")
    list(folder.run(plane_droplet(), 0.05, 0.05))
    with pytest.raises(ResultsError, match="part of its own"):
        folder.run(plane_droplet(), 0.05, 0.05)
    list(folder.run(plane_droplet(0.2), 0.05, 0.05, part="other"))
    assert len(open_run(tmp_path / "run" / "other").times) == 2
    with pytest.raises(ResultsError, match="a folder within"):
        folder.run(plane_droplet(), 0.05, 0.05, part="../elsewhere")


def test_functions_are_told_apart():
    """By what they do and close over; objects by what they hold."""

    def flow(rate):
        return lambda p: rate * p[1]

    assert described(flow(1.0)) == described(flow(1.0))
    difference = first_difference(described(flow(1.0), "f"), described(flow(-0.3), "f"))
    assert difference == "f.closure['rate']: 1.0 then, -0.3 now"
    assert described(lambda x: x + 1) != described(lambda x: x + 2)

    class Mine:
        def __init__(self, rate):
            self.rate = rate

    assert described(Mine(2.0)) == described(Mine(2.0)) != described(Mine(3.0))


def test_an_end_before_what_is_reached_is_refused(tmp_path):
    gone_through(tmp_path / "run", plane_droplet(), end=0.3)
    with pytest.raises(ResultsError, match="has come to t = 0.3 already"):
        gone_through(tmp_path / "run", plane_droplet(), resume=True, end=0.1)


def test_tables_are_read_as_far_as_they_count(tmp_path):
    """A row half written at the end belongs to the step that was lost."""
    gone_through(tmp_path / "run", plane_droplet(), end=0.1)
    with (tmp_path / "run" / "bodies.csv").open("a") as table:
        table.write("0.15,1,drop")
    assert open_run(tmp_path / "run").body_table["time"].tolist() == [0.0, 0.05, 0.1]


def test_any_name_of_an_opening(tmp_path):
    """Commas, signs and letters of any alphabet."""
    names = {"in, left": cb.Inflow(mean_velocity=1.0), "Ausfluß #1": cb.Pressure(0.0)}
    sides = rectangle((0, 0), (4, 2))  # left, right, below, above
    called = ("in, left", "Ausfluß #1", "w", "w")
    patches = tuple(cb.Patch(side, name) for side, name in zip(sides, called, strict=True))
    channel = cb.Boundary(patches).elevated(2).refined(3)
    flow = cb.ChannelFlow(cb.StokesProblem(channel, 1.0, {**names, "w": cb.NoSlip()}))
    droplet = cb.Droplet(cb.spline_circle(0.4, (1, 1), points=16), cb.SurfaceTension(5.0))
    gone_through(tmp_path / "run", cb.Simulation(flow, droplet), end=0.05)
    table = open_run(tmp_path / "run").run_table
    assert table["flow_rate in, left"] == pytest.approx(2.0, rel=1e-3)
    assert table["pressure Ausfluß #1"] == pytest.approx(0.0, abs=1e-9)
