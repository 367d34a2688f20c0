"""Sweeps: values, runs in processes of their own, the table, going on, a cluster."""

import csv
import json
import shutil
import subprocess
import sys
import time
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest

import cadbem as cb
from cadbem.cli import main
from cadbem.errors import ResultsError
from cadbem.sweep import begin_sweep, resume_sweep
from cadbem.sweep.values import parsed, points_of, values_of

SCRIPT = '''"""A square's area and a marker of how often it was worked out."""
from pathlib import Path

import cadbem as cb


def main(output: str = "", side: float = 1.0, name: str = "a", {more}) -> None:
    folder = cb.run_folder(output{resumed})
    with Path(__file__).with_name("calls").open("a") as calls:
        calls.write(f"{{side:g}}\\n")
    if side == 3 and Path(__file__).with_name("broken").exists():
        raise cb.ShapeError("no square of side 3 today")
    folder.summary({{"area": side**2, "name": name}})


if __name__ == "__main__":
    cb.run(main)
'''


@pytest.fixture
def script(tmp_path) -> Path:
    file = tmp_path / "square.py"
    file.write_text(SCRIPT.format(more="points: int = 1", resumed=""))
    return file


def calls(script: Path) -> list[str]:
    return sorted(script.with_name("calls").read_text().split())


def table(folder: Path) -> list[dict[str, str]]:
    return list(csv.DictReader((folder / "table.csv").open()))


def test_values():
    """Evenly spaced, evenly in proportion, as listed; with a unit; other text stands for itself."""
    assert values_of("0.05:0.4:8") == ["0.05", "0.1", "0.15", "0.2", "0.25", "0.3", "0.35", "0.4"]
    assert values_of("1:1000:4:log") == ["1", "10", "100", "1000"]
    assert values_of("1,2.5,-4e-3") == ["1", "2.5", "-0.004"]
    assert values_of("10:30:3 uL/min") == ["10 uL/min", "20 uL/min", "30 uL/min"]
    assert [values_of(t) for t in ("0.4", "shape volume", "a:b:c", "results/x")] == [[]] * 4
    with pytest.raises(cb.CadbemError, match="one side of zero"):
        values_of("-1:1:3:log")


def test_which_options_are_swept():
    arguments = ["--capillary", "0.1:0.2:2", "--parts", "shape", "--flag"]
    arguments += ["--points=100,200", "--end=5"]
    swept, others = parsed(arguments)
    assert swept == {"capillary": ["0.1", "0.2"], "points": ["100", "200"]}
    assert others == ["--parts=shape", "--flag", "--end=5"]
    pairs = [tuple(point.values()) for point in points_of(swept)]
    assert pairs == [("0.1", "100"), ("0.1", "200"), ("0.2", "100"), ("0.2", "200")]
    for mistake, words in {
        "nothing to sweep": ["--end", "5"],
        "'1:2:2' belongs to no option": ["1:2:2"],
        "swept twice": ["--x", "1,2", "--x", "3,4"],
        "count is 0": ["--x", "1:2:0"],
        "'1,2,a' is not understood": ["--x=1,2,a"],
    }.items():
        with pytest.raises(cb.CadbemError, match=mistake):
            parsed(words)


def test_sweep_fails_in_part_and_goes_on(script, tmp_path, capsys):
    """Areas of squares; the run that failed is the only one that is done again."""
    script.with_name("broken").touch()
    folder = tmp_path / "out"
    arguments = ["-o", str(folder), str(script), "--side", "1:3:3", "--name=b"]
    assert main(["sweep", *arguments]) == 1
    printed = capsys.readouterr()
    assert "no square of side 3 today" in printed.err
    assert [row["state"] for row in table(folder)] == ["done", "done", "not done"]
    script.with_name("broken").unlink()
    assert main(["resume", str(folder)]) == 0
    found = table(folder)
    assert [float(row["area"]) for row in found] == [1, 4, 9]
    assert {row["name"] for row in found} == {"b"}
    assert calls(script) == ["1", "2", "3", "3"]
    assert (folder / "sweep.png").read_bytes().startswith(b"\x89PNG")
    with pytest.raises(ResultsError, match="go on with 'cadbem resume"):
        begin_sweep(script, ["--side", "1:2:2"], folder)


def test_sweep_on_a_cluster(script, tmp_path):
    """The same by the workers of a dask scheduler on this machine."""
    distributed = pytest.importorskip("dask.distributed")
    local = distributed.LocalCluster(
        n_workers=1, threads_per_worker=1, processes=False, dashboard_address=None
    )
    with local as cluster:
        address = cluster.scheduler_address
        assert begin_sweep(script, ["--side=2,5"], tmp_path / "out", cluster=address) == 0
    assert [float(row["area"]) for row in table(tmp_path / "out")] == [4, 25]


@pytest.mark.parametrize(
    "address",
    ["carrier-pigeon://loft:9", "tls://127.0.0.1:9", "", "tcp://", "tcp://h:x", "inproc://1", "ü"],
)
def test_no_scheduler(script, tmp_path, address: str):
    """Odd addresses, and tls without certificates, end in one line."""
    pytest.importorskip("dask.distributed")
    from cadbem.sweep.engines import on_a_cluster

    with pytest.raises(cb.CadbemError, match="--cluster .* dask scheduler") as refused:
        list(on_a_cluster([], address))
    assert "\n" not in str(refused.value)
    assert ("distributed.comm.tls" in str(refused.value)) == address.startswith("tls")


def certificates(folder: Path) -> dict[str, object]:
    """dask's configuration with an authority of our own and a certificate that it has signed."""

    def openssl(*words: str) -> None:
        subprocess.run(["openssl", *words], check=True, capture_output=True, cwd=folder)

    new = ("req", "-newkey", "rsa:2048", "-nodes", "-subj")
    openssl(*new, "/CN=authority", "-x509", "-days", "2", "-keyout", "ca.key", "-out", "ca.pem")
    openssl(*new, "/CN=localhost", "-keyout", "own.key", "-out", "own.csr")
    sign = ("-CA", "ca.pem", "-CAkey", "ca.key", "-CAcreateserial", "-days", "2")
    openssl("x509", "-req", "-in", "own.csr", *sign, "-out", "own.pem")
    tls = {"ca-file": "ca.pem"}
    for who in ("scheduler", "worker", "client"):
        tls |= {f"{who}.cert": "own.pem", f"{who}.key": "own.key"}
    files = {f"distributed.comm.tls.{name}": str(folder / file) for name, file in tls.items()}
    return {"distributed.comm.require-encryption": True, **files}


@pytest.mark.skipif(shutil.which("openssl") is None, reason="no program that makes certificates")
def test_sweep_on_a_cluster_with_tls(script, tmp_path):
    """Certificates come from dask's own configuration."""
    dask = pytest.importorskip("dask")
    distributed = pytest.importorskip("dask.distributed")
    with dask.config.set(certificates(tmp_path)):
        local = distributed.LocalCluster(
            n_workers=1, threads_per_worker=1, processes=False, dashboard_address=None,
            protocol="tls://", security=distributed.Security(),
        )  # fmt: skip
        with local as cluster:
            address = cluster.scheduler_address
            assert address.startswith("tls://")
            assert begin_sweep(script, ["--side=2,5"], tmp_path / "out", cluster=address) == 0
    assert [float(row["area"]) for row in table(tmp_path / "out")] == [4, 25]


def test_what_a_cluster_has_lost_is_said():
    """A scheduler or a worker that ends makes a point fail in one line."""
    from cadbem.sweep.engines import _result

    class Lost:
        def result(self) -> str:
            raise RuntimeError("the scheduler\nis gone")

    assert _result(Lost()) == "the cluster lost it (RuntimeError: the scheduler is gone)"


def test_a_run_that_can_is_gone_on_with(script, tmp_path):
    """A point whose folder holds a begun run gets --resume, which the script's main must take."""
    script.write_text(
        SCRIPT.format(more="resume: bool = False", resumed=", resume=resume")
        + "\n# resumable\n"
    )
    folder = tmp_path / "out"
    assert begin_sweep(script, ["--side", "1,2"], folder) == 0
    (folder / "run_2.done").unlink()
    assert resume_sweep(folder) == 0
    assert "resumed" in (folder / "run_2" / "log.txt").read_text()
    np.testing.assert_allclose([float(row["area"]) for row in table(folder)], [1, 4])


def test_interrupted_sweep_ends_its_runs_and_goes_on(tmp_path):
    """The sweep's process alone is killed: its runs end with it, and none is done twice at a
    time; gone on with, all are done."""
    script = tmp_path / "slow.py"
    script.write_text(
        SCRIPT.format(more="seconds: float = 0.0", resumed="").replace(
            "    folder.summary", "    import time\n\n    time.sleep(seconds)\n    folder.summary"
        )
    )
    folder = tmp_path / "out"
    command = [sys.executable, "-m", "cadbem", "sweep", script, "--side", "1,2", "-o", folder]
    parent = subprocess.Popen([*command, "--seconds", "600"], stderr=subprocess.DEVNULL)
    runs = [folder / "run_1", folder / "run_2"]
    wait_for(lambda: all((run / "run.json").exists() for run in runs))
    parent.kill()
    parent.wait()
    asked = json.loads((folder / "sweep.json").read_text())
    (folder / "sweep.json").write_text(json.dumps(asked | {"others": []}))
    wait_for(lambda: not running("slow.py"))
    assert main(["resume", str(folder)]) == 0
    assert [row["state"] for row in table(folder)] == ["done", "done"]


def wait_for(condition, seconds: float = 60.0) -> None:
    deadline = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < deadline
        time.sleep(0.05)


def running(word: str) -> bool:
    """Whether a process was started with a word among its arguments."""
    commands = Path("/proc").glob("[0-9]*/cmdline")
    for command in commands:
        with suppress(OSError):
            if any(part.endswith(word.encode()) for part in command.read_bytes().split(b"\0")):
                return True
    return False


def test_what_a_sweep_cannot_use(script, tmp_path):
    """Scripts that leave no numbers, or fail after they did; columns do not hide each other."""
    with pytest.raises(cb.CadbemError, match="has no option --sidd; it has --name"):
        begin_sweep(script, ["--sidd", "1,2"], tmp_path / "never")
    assert not (tmp_path / "never").exists()
    quiet = tmp_path / "quiet.py"
    quiet.write_text(
        "import cadbem as cb\ndef main(output: str = '', x: float = 0): pass\ncb.run(main)"
    )
    assert begin_sweep(quiet, ["--x", "1,2"], tmp_path / "a") == 1
    late = tmp_path / "late.py"
    late.write_text(
        "import cadbem as cb\n"
        "def main(output: str = '', x: float = 0):\n"
        "    cb.run_folder(output).summary({'x': 2 * x})\n"
        "    if x == 2: raise ValueError\n"
        "cb.run(main)"
    )
    assert begin_sweep(late, ["--x", "1,2"], tmp_path / "b") == 1
    rows = table(tmp_path / "b")
    assert [(row["x"], row["x found"], row["state"]) for row in rows] == [
        ("1", "2.0", "done"), ("2", "", "not done")
    ]  # fmt: skip
