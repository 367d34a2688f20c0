"""One run of a sweep, in a process of its own."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

LIBRARIES = ("OPENBLAS", "OMP", "MKL", "NUMBA")


@dataclass(frozen=True)
class Point:
    """Values of the swept options, and what they are given to: the ``folder`` of the results, the
    ``script``, its ``others`` arguments, and the ``cores`` to use."""

    folder: str
    script: str
    values: dict[str, str]
    others: tuple[str, ...]
    cores: int = 1

    @property
    def summary(self) -> dict[str, Any] | None:
        """What the run found, None as long as it has not ended."""
        file = Path(self.folder, "summary.json")
        return json.loads(file.read_text()) if file.exists() else None

    @property
    def log(self) -> Path:
        """What the run printed."""
        return Path(f"{self.folder}.log")

    @property
    def failure(self) -> str:
        """The last line that a run without results printed."""
        lines = self.log.read_text().split("\n") if self.log.exists() else []
        return next((line for line in reversed(lines) if line.strip()), "printed nothing")


def run_point(values: dict[str, Any]) -> bool:
    """Run a point, given as by ``asdict``; goes on with it where it was interrupted, if the script
    can.  True if it ended well."""
    point = Point(**values)
    if point.summary is not None:
        return True
    command = [sys.executable, "-m", "cadbem", "run", "--quiet", "--cores", str(point.cores)]
    command += [point.script, *point.others]
    command += [f"--{name}={value}" for name, value in point.values.items()]
    command += [f"--output={point.folder}", *_resumed(Path(point.folder))]
    threads = {f"{name}_NUM_THREADS": str(point.cores) for name in LIBRARIES}
    with point.log.open("a") as log:
        ended = subprocess.run(
            command, stdout=log, stderr=subprocess.STDOUT, stdin=subprocess.DEVNULL,
            env=os.environ | threads, check=False,
        )  # fmt: skip
    return ended.returncode == 0 and point.summary is not None


def as_task(point: Point) -> dict[str, Any]:
    """The point as plain values, which any worker can be sent."""
    return asdict(point)


def _resumed(folder: Path) -> list[str]:
    """The option to go on; a run that cannot is begun anew."""
    asked = folder / "run.json"
    if asked.exists() and "resume" in json.loads(asked.read_text())["arguments"]:
        return ["--resume"]
    shutil.rmtree(folder, ignore_errors=True)
    return []
