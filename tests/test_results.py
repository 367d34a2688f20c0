"""Runs in folders: restart after any end, tables, frames, and what is refused."""

import csv
import os
import signal
import time
from pathlib import Path

import numpy as np
import pytest

import cadbem as cb
from cadbem.results import open_run, run_folder
from cadbem.results.encode import reading
from cadbem.results.store import frame_file

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
        with reading(frame_file(folder, index)) as file:
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
    pause, to the last bits that a rounding may change."""
    whole, pieces = tmp_path / "whole", tmp_path / "pieces"
    gone_through(whole, simulation())
    moments, kills = np.random.default_rng(5), 0
    while kills < 10:
        again = pieces.exists()
        kills += killed(
            moments.uniform(0.02, longest),
            lambda again=again: gone_through(pieces, simulation(), resume=again),
        )
        if not (pieces / "run.json").exists():
            continue
    gone_through(pieces, simulation(), resume=True)
    expected, found = stored_numbers(whole), stored_numbers(pieces)
    assert found.keys() == expected.keys()
    for name, values in expected.items():
        np.testing.assert_allclose(found[name], values, rtol=1e-12, atol=1e-14, err_msg=name)
    assert same_tables(whole, pieces)
