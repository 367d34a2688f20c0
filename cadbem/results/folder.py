"""The folder of a run: its manifest, its results, and its log."""

from __future__ import annotations

import inspect
import os
from collections.abc import Iterator, Mapping
from contextlib import nullcontext
from dataclasses import dataclass, field
from datetime import datetime
from pathlib import Path
from typing import Any

from cadbem.errors import ResultsError
from cadbem.files import (
    as_results_error,
    fresh_folder,
    locked,
    read_json,
    remove_unfinished,
    write_json,
    write_whole,
)
from cadbem.progress import STAGES, notice
from cadbem.results.manifest import check_manifest, manifest_of
from cadbem.results.overview import folder_text
from cadbem.suspension.time.simulation import Simulation
from cadbem.suspension.time.state import State

MANIFEST, SUMMARY, LOG, SCRIPT = "run.json", "summary.json", "log.txt", "script.py"


@dataclass
class Resumption:
    """An earlier run that is gone on with: the manifest ``before`` and the one of ``now``, which
    replaces it once nothing is in the way; then it is ``done``."""

    before: dict[str, Any]
    now: dict[str, Any]
    done: bool = False

    def carry_out(self, folder: RunFolder) -> None:
        """Write what has changed into the folder, and restore the script's copy."""
        self.done = True
        remove_unfinished(Path(folder))
        folder.note("resumed")
        for what in _changes(self.before, self.now):
            folder.note(what)
            notice(f"{folder}: {what}")
        pauses = [*self.before.get("pauses", ()), {"went_on": self.now["began"]}]
        began = {"began": self.before["began"], "pauses": pauses}
        write_json(folder / MANIFEST, self.now | began)
        if not (folder / SCRIPT).exists():
            _keep_script(folder, self.now)


@dataclass(frozen=True)
class RunFolder:
    """The folder of a run: ``folder / "picture.png"``; nothing is kept without a
    ``path``, and the folder then counts as false.  ``used`` are the parts that this process has."""

    path: Path | None
    used: set[str] = field(default_factory=set, repr=False, compare=False)
    resumption: Resumption | None = field(default=None, repr=False, compare=False)

    __repr__ = folder_text

    def __bool__(self) -> bool:
        return self.path is not None

    def __truediv__(self, name: str) -> Path:
        return Path(self) / name

    def __fspath__(self) -> str:
        if self.path is None:
            raise ResultsError("there is no folder to write to; ask 'if folder:' first")
        return str(self.path)

    def __str__(self) -> str:
        return str(self.path)

    def run(
        self, simulation: Simulation, end: float, every: float | None = None, part: str = ""
    ) -> Iterator[State]:
        """``simulation.run(end, every)``, kept step by step in the folder, or in its ``part``.

        A folder that is resumed gives the states that it holds and goes on from there.  Frames are
        in frames/, for ParaView in paraview/bodies.pvd; each scalar measure in run.csv and
        bodies.csv.  Raises ``ResultsError`` when the folder holds the run of another simulation,
        when a disk is full, and as ``Simulation.run`` does.
        """
        if self.path is None:
            return simulation.run(end, every)
        from cadbem.results.store import Store

        place = self.path / self._own(part)
        label = f"{part}: " if part else ""
        note = lambda text: self.note(label + text)  # noqa: E731
        return Store(place, simulation, note, lambda: self._accepted(part)).run(end, every)

    def _accepted(self, part: str = "") -> None:
        """Nothing is in the way of going on with an earlier run: now the folder may be changed.

        The folder of the run without a part is locked by then."""
        if self.resumption is None or self.resumption.done:
            return
        with locked(Path(self)) if part else nullcontext():
            self.resumption.carry_out(self)

    def _own(self, part: str) -> str:
        """A part's name, once."""
        if Path(part).is_absolute() or ".." in Path(part).parts:
            raise ResultsError(f"part='{part}': give the name of a folder within {self}")
        if part in self.used:
            what = f"part '{part}' of {self}" if part else str(self)
            raise ResultsError(
                f"{what} holds a simulation of this script already; give each one a part of its "
                "own, such as folder.run(..., part='fine')"
            )
        self.used.add(part)
        return part

    def summary(self, values: Mapping[str, float | str]) -> None:
        """Keep what the run found, by names with units, in summary.json: a sweep tabulates it."""
        if self.path is not None:
            if self.resumption is not None and not self.resumption.done:
                self._accepted("summary")  # nothing has locked the folder
            write_json(self.path / SUMMARY, {k: _plain(k, v) for k, v in values.items()})

    def note(self, text: str) -> None:
        """Add a line to log.txt, with the time of day."""
        STAGES.info("%s: %s", self, text)
        path = self / LOG
        with as_results_error(path), path.open("a", encoding="utf-8") as log:
            log.write(f"{datetime.now():%Y-%m-%d %H:%M:%S}  {text}\n")


def run_folder(
    output: str | os.PathLike[str], *inputs: str | Path, resume: bool = False
) -> RunFolder:
    """Make the folder ``output`` for the results of the script that calls, "" for no results.

    run.json is the manifest: the script with the arguments of the function that calls,
    versions, and the digests of the ``inputs``, files such as a CAD file.  ``resume`` takes up the
    folder of an earlier run.

    Raises ``ResultsError`` when the folder holds something (or, to resume, no run or one with
    other inputs), and when it cannot be made.
    """
    if not os.fspath(output):
        return RunFolder(None)
    frame = inspect.currentframe()
    assert frame is not None and frame.f_back is not None
    manifest = manifest_of(frame.f_back, inputs)
    path = Path(output)
    if resume:
        return _resumed(path, manifest)
    folder = RunFolder(fresh_folder(path, MANIFEST))
    write_json(path / MANIFEST, manifest)
    _keep_script(folder, manifest)
    folder.note("began")
    return folder


def _keep_script(folder: RunFolder, manifest: Mapping[str, Any]) -> None:
    """A copy of the script as it is."""
    if manifest["script"]:
        write_whole(folder / SCRIPT, Path(manifest["script"]["file"]).read_bytes())


def read_manifest(path: Path) -> dict[str, Any]:
    """The manifest of the run in a folder.  Raises ``ResultsError`` when it holds none."""
    if not os.path.exists(path / MANIFEST):
        raise ResultsError(f"{path} holds no run: there is no {MANIFEST} in it")
    return check_manifest(read_json(path / MANIFEST), path / MANIFEST)


def _resumed(path: Path, manifest: dict[str, Any]) -> RunFolder:
    before = read_manifest(path)
    for old, new in zip(before["inputs"], manifest["inputs"], strict=False):
        if old["sha256"] != new["sha256"]:
            raise ResultsError(
                f"{new['file']} has changed since the run in {path} began; start it anew in "
                "another folder"
            )
    return RunFolder(path, resumption=Resumption(before, manifest))


def _changes(before: Mapping[str, Any], now: Mapping[str, Any]) -> Iterator[str]:
    """The changes since the run began that may matter."""
    old, new = before["script"], now["script"]
    if old and new and old["sha256"] != new["sha256"]:
        yield f"{new['file']} has changed since the run began"
    for kind in ("versions", "arguments"):
        for name, value in now[kind].items():
            was = before[kind].get(name)
            if value != was and name not in ("output", "resume"):
                yield f"{name} is {value}, was {was}"
    for name in ("cores", "threads"):
        if now[name] != before[name]:
            yield f"{name} are {now[name]}, were {before[name]}: last digits may differ"


def _plain(name: str, value: Any) -> float | str:
    if isinstance(value, str):
        return value
    try:
        return float(value)
    except (TypeError, ValueError) as error:
        raise ResultsError(f"summary: '{name}' is {value!r}; give a number or text") from error
