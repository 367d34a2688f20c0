"""One run of a sweep, in a process of its own."""

from __future__ import annotations

import shutil
import subprocess
import sys
from dataclasses import asdict, dataclass
from pathlib import Path
from threading import Event
from typing import Any

from cadbem.errors import ResultsError
from cadbem.files import read_json, write_json

PATIENCE = 0.2  # seconds between looks at a process


@dataclass(frozen=True)
class Point:
    """Values of the swept options, and what they are given to: the ``folder`` of the results, the
    ``script``, its ``others`` arguments, the folder that these refer to, ``start``, and the
    ``cores`` to use."""

    folder: str
    script: str
    values: dict[str, str]
    others: tuple[str, ...]
    start: str
    cores: int = 1

    @property
    def log(self) -> Path:
        """The file with all that the run printed."""
        return Path(f"{self.folder}.log")

    @property
    def mark(self) -> Path:
        """A file that is there once the run has ended well."""
        return Path(f"{self.folder}.done")

    @property
    def summary(self) -> dict[str, Any] | None:
        """The summary of the run, None as long as it is not complete."""
        file = Path(self.folder, "summary.json")
        found = read_json(file) if self.mark.exists() else None
        if not isinstance(found, dict | None):
            raise ResultsError(f"{file} is not what a run writes; remove {self.mark}")
        return found

    @property
    def command(self) -> list[str]:
        """The command line of the run."""
        words = [sys.executable, "-m", "cadbem", "run", "--quiet", "--tied"]
        words += ["--cores", str(self.cores), self.script, *self.others]
        words += [f"--{name}={value}" for name, value in self.values.items()]
        return [*words, f"--output={self.folder}"]


def run_point(values: dict[str, Any], stop: Event | None = None) -> str:
    """Run a point, given as by ``asdict``; goes on with it where it was interrupted, if the script
    can.  Returns what went wrong, or nothing; ``stop`` ends it early."""
    point = Point(**values)
    if point.mark.exists():
        return ""
    with (
        point.log.open("a") as log,
        subprocess.Popen(
            [*point.command, *_resumed(Path(point.folder))], stdout=log, stderr=subprocess.STDOUT,
            stdin=subprocess.PIPE, cwd=point.start,
        ) as process,
    ):  # fmt: skip
        while process.poll() is None:
            if stop is not None and stop.wait(PATIENCE):
                process.terminate()
            elif stop is None:
                process.wait()
    return _ended(point, process.returncode)


def _ended(point: Point, code: int) -> str:
    """Why the run failed, or an empty text; a run that did not fail is marked as complete."""
    if code < 0:
        return f"was killed by signal {-code}"
    if code:
        lines = [line for line in point.log.read_text().split("\n") if line.strip()]
        return lines[-1] if lines else f"ended with exit code {code}"
    if not Path(point.folder, "summary.json").exists():
        return "left no numbers: main must keep some with folder.summary({...})"
    write_json(point.mark, {"exit": code})
    return ""


def as_task(point: Point) -> dict[str, Any]:
    """The point as plain values, which any worker can be sent."""
    return asdict(point)


def _resumed(folder: Path) -> list[str]:
    """The option that continues a run; a run without that option begins again."""
    manifest = folder / "run.json"
    if manifest.exists() and "resume" in read_json(manifest)["arguments"]:
        return ["--resume"]
    shutil.rmtree(folder, ignore_errors=True)
    return []
