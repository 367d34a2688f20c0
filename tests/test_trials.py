"""Kills at every durable operation, damage to every file, and soaks: ``-m long``."""

import os
import resource
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from random import Random

import numpy as np
import pytest
from test_damaged_runs import EVERY, gone_through, numbers, simulation, snapshot
from test_results import channel_with_a_mixture, killed, same_tables, stored_numbers
from test_results import gone_through as mixture_through

import cadbem as cb
from cadbem.command import MEND
from cadbem.operators.parallel import CORES

pytestmark = pytest.mark.long


def killing(monkeypatch: pytest.MonkeyPatch, number: int) -> None:
    """The process ends at its durable operation of a number: a file that is synchronised or takes
    another's place."""
    count = 0

    def ending(usual: Callable) -> Callable:
        def operation(*words, **options):
            nonlocal count
            count += 1
            if count == number:
                os._exit(99)
            return usual(*words, **options)

        return operation

    for name in ("fsync", "replace"):
        monkeypatch.setattr(os, name, ending(getattr(os, name)))


def test_a_kill_at_each_durable_operation(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """Of a run's beginning, its steps and its end; gone on with, it is the unbroken one to the last
    bit each time."""
    gone_through(tmp_path / "whole")
    expected = numbers(tmp_path / "whole")
    for number in range(1, 400):
        folder = tmp_path / f"run_{number}"
        child = os.fork()
        if child == 0:
            killing(monkeypatch, number)
            gone_through(folder)
            os._exit(0)
        ended = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
        gone_through(folder, resume=(folder / "run.json").exists())
        for found, wanted in zip(numbers(folder), expected, strict=True):
            np.testing.assert_array_equal(found, wanted, err_msg=f"operation {number}")
        assert same_tables(tmp_path / "whole", folder)
        assert not list(folder.rglob(".*.new"))
        assert (folder / "script.py").exists()
        shutil.rmtree(folder)
        if ended == 0:
            break
    assert number > 60


def test_forty_random_kills_in_a_channel(tmp_path: Path):
    """With a droplet and a sphere: the frames are those of a run without a pause."""
    whole, pieces = tmp_path / "whole", tmp_path / "pieces"
    mixture_through(whole, channel_with_a_mixture(), end=0.2)
    moments, kills = np.random.default_rng(8), 0
    for _ in range(40):
        again = (pieces / "run.json").exists()
        kills += killed(
            moments.uniform(0.5, 8.0),
            lambda again=again: mixture_through(pieces, channel_with_a_mixture(), again, end=0.2),
        )
    mixture_through(pieces, channel_with_a_mixture(), resume=True, end=0.2)
    expected, found = stored_numbers(whole), stored_numbers(pieces)
    assert kills > 3
    for name, values in expected.items():
        np.testing.assert_array_equal(found[name], values, err_msg=name)
    assert same_tables(whole, pieces)


def test_damage_to_every_file(tmp_path: Path):
    """A bit, half of it, or all of it: refused with everything as it was, or gone on with to the
    same frames; mended in any case."""
    gone_through(tmp_path / "whole")
    expected = numbers(tmp_path / "whole")
    files = [name for name in snapshot(tmp_path / "whole") if not name.startswith("paraview")]
    for name in files:
        for how in ("bit", "half", "gone"):
            folder = Path(shutil.copytree(tmp_path / "whole", tmp_path / "run"))
            content = bytearray((folder / name).read_bytes())
            if how == "bit":
                content[Random(name).randrange(len(content))] ^= 16
            damaged = bytes(content[: len(content) // 2] if how == "half" else content)
            (folder / name).unlink()
            if how != "gone":
                (folder / name).write_bytes(damaged)
            before = snapshot(folder)
            for mending in (False, True):
                token = MEND.set(mending)
                try:
                    gone_through(folder, resume=True)
                    assert [f.shape for f in numbers(folder)] == [f.shape for f in expected]
                    for found, wanted in zip(numbers(folder), expected, strict=True):
                        np.testing.assert_allclose(found, wanted, atol=0 if not mending else 3e-3)
                    break
                except cb.ResultsError as error:
                    assert "\n" not in str(error)
                    assert Path(name).name.split(".")[0] in str(error), (name, how, error)
                    assert snapshot(folder) == before, (name, how)
                finally:
                    MEND.reset(token)
            shutil.rmtree(folder)


def peak() -> int:
    """Kilobytes of memory that this process has had at once."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss


def test_a_soak_of_1500_steps(tmp_path: Path):
    """Memory does not grow; a stored run of as many steps goes on."""
    drop = cb.Droplet(cb.spline_circle(points=24), cb.SurfaceTension(3.0), 2.0)
    flow = cb.FreeFlow(cb.shear(dimension=2))
    run = cb.Simulation(flow, drop, stepper=cb.Euler(0.01))
    states = cb.run_folder(tmp_path / "run").run(run, 15.0, 0.05)
    early = 0
    for k, state in enumerate(states):
        assert not state.stopped
        early = peak() if k == 60 else early
    assert state.steps >= 1500
    assert peak() < early + 30_000
    assert len(cb.open_run(tmp_path / "run").times) == 301


def test_a_soak_of_100_solutions():
    """The memory of a solution is given back."""
    names = ("walls", "walls", "walls", "walls", "inlet", "outlet")
    duct = cb.Boundary(
        tuple(cb.Patch(s, n) for s, n in zip(cb.box(), names, strict=True))
    ).elevated(2).refined(3)  # fmt: skip
    data = {"walls": cb.NoSlip(), "inlet": cb.Inflow(1.0), "outlet": cb.Pressure(0.0)}
    found, early = set(), 0
    for k in range(100):
        solution = cb.StokesProblem(duct, 1.0, data).solve()
        found.add(solution.mean_pressure("inlet"))
        early = peak() if k == 10 else early
    assert len(found) == 1
    assert peak() < early + 30_000


def test_one_core_and_two_agree_to_rounding(tmp_path: Path):
    for cores in (1, 2):
        token = CORES.set(cores)
        gone_through(tmp_path / f"run_{cores}")
        CORES.reset(token)
    pairs = zip(numbers(tmp_path / "run_1"), numbers(tmp_path / "run_2"), strict=True)
    for one, two in pairs:
        np.testing.assert_allclose(one, two, atol=1e-9)


def test_two_processes_that_go_on_at_once(tmp_path: Path):
    """One of them goes on, the other is told so, and the run is whole."""
    program = (
        "import sys\n"
        f"sys.path.insert(0, {str(Path(__file__).parent)!r})\n"
        "from pathlib import Path\n"
        "from test_damaged_runs import gone_through\n"
        "gone_through(Path(sys.argv[1]), end=1.0, resume=True)\n"
    )
    gone_through(tmp_path / "run", end=0.1)
    gone_through(tmp_path / "whole", end=1.0)
    command = [sys.executable, "-c", program, tmp_path / "run"]
    both = [subprocess.Popen(command, stderr=subprocess.PIPE, text=True) for _ in range(2)]
    errors = [process.communicate()[1] for process in both]
    codes = sorted(process.returncode for process in both)
    assert codes[0] == 0
    if codes[1]:
        assert any("another process is writing" in text for text in errors)
    frames = zip(numbers(tmp_path / "run"), numbers(tmp_path / "whole"), strict=True)
    for found, wanted in frames:
        np.testing.assert_allclose(found, wanted, atol=2e-3)
    assert len(cb.open_run(tmp_path / "run").run_table["time"]) == round(1.0 / EVERY) + 1
    assert simulation().droplet.shape.basis.count == 24


def test_eight_kills_of_a_sweep(tmp_path: Path):
    """The sweep's process is killed at random moments; gone on with, every point is there once."""
    script = tmp_path / "square.py"
    script.write_text(
        "import cadbem as cb\n\n"
        "def main(output: str = 'out', side: float = 1.0, resume: bool = False) -> None:\n"
        "    cb.run_folder(output, resume=resume).summary({'area': side**2})\n\n"
        "if __name__ == '__main__':\n    cb.run(main)\n"
    )
    command = [sys.executable, "-m", "cadbem"]
    begin = [*command, "sweep", script, "--side", "1:6:6", "-o", tmp_path / "out"]
    moments = np.random.default_rng(3)
    for kill in range(8):
        goes_on = (tmp_path / "out" / "sweep.json").exists()
        words = [*command, "resume", tmp_path / "out"] if goes_on else begin
        process = subprocess.Popen(words, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        try:
            process.wait(timeout=moments.uniform(1.0, 5.0 + kill))
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()
    assert subprocess.run([*command, "resume", tmp_path / "out"]).returncode == 0
    lines = (tmp_path / "out" / "table.csv").read_text().splitlines()
    assert len(lines) == 7
    assert all("done" in line for line in lines[1:])
