"""A sweep: its folder, its runs, its table and plot."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from cadbem.errors import CadbemError, ResultsError
from cadbem.files import fresh_folder, locked, read_json, write_json
from cadbem.operators.parallel import CORES
from cadbem.progress import notice, progress
from cadbem.results.manifest import digested
from cadbem.results.trust import check_script
from cadbem.sweep.engines import Outcome, on_a_cluster, on_this_machine
from cadbem.sweep.point import Point
from cadbem.sweep.report import draw_table, write_table
from cadbem.sweep.values import parsed, points_of

KINDS = {
    "script": str,
    "sha256": str,
    "swept": dict,
    "others": list,
    "start": str,
    "jobs": int | None,
    "cluster": str | None,
}
DEFINITION, TABLE, PLOT = "sweep.json", "table.csv", "sweep.png"


def begin_sweep(
    script: str | os.PathLike[str],
    arguments: Sequence[str],
    output: str | os.PathLike[str],
    jobs: int | None = None,
    cluster: str | None = None,
) -> int:
    """Run a script for all combinations of values in its ``arguments`` (see ``parsed``), ``jobs``
    at a time, by default one a core, or on a ``cluster``, the address of a dask scheduler.

    The folder ``output`` gets a folder for each run, table.csv and sweep.png.  Returns 0, or 1 if
    any run failed.  Raises ``ResultsError`` when the folder holds something.
    """
    swept, others = parsed(arguments)
    folder = Path(output)
    _check_options(Path(script), [*swept, *others])
    fresh_folder(folder, DEFINITION)
    definition = {
        "script": str(Path(script).resolve()),
        "sha256": digested(Path(script))["sha256"],
        "swept": swept,
        "others": others,
        "start": str(Path.cwd()),
        "jobs": jobs,
        "cluster": cluster,
    }
    write_json(folder / DEFINITION, definition)
    return resume_sweep(folder)


def resume_sweep(
    folder: str | os.PathLike[str],
    jobs: int | None = None,
    cluster: str | None = None,
    trusted: bool = False,
) -> int:
    """Run what is left of a sweep in a folder, by default with the ``jobs`` or on the ``cluster``
    that it was begun with; returns 0, or 1 if any run failed.

    Raises ``ResultsError`` for a script that has changed, or came with the folder, unless it is
    ``trusted``."""
    place = Path(folder)
    definition = _definition(place)
    if os.path.isfile(definition["script"]):
        check_script(place, Path(definition["script"]), definition["sha256"], trusted)
    cluster = cluster or (None if jobs else definition["cluster"])
    at_a_time = min(jobs or definition["jobs"] or CORES.get(), len(points_of(definition["swept"])))
    points = _points(place, definition, 1 if cluster else max(1, CORES.get() // at_a_time))
    left = [point for point in points if point.summary is None]
    with locked(place):
        engine = on_a_cluster(left, cluster) if cluster else on_this_machine(left, at_a_time)
        try:
            _carry_out(place, points, len(left), engine)
        except KeyboardInterrupt:
            notice(f"go on with 'cadbem resume {folder}'")
            raise
    pictures = draw_table(place / PLOT, points)
    print("\n".join(str(file) for file in (place / TABLE, *pictures)))
    return 0 if all(point.summary is not None for point in points) else 1


def _definition(place: Path) -> dict[str, Any]:
    """What was kept of a sweep.  Raises ``ResultsError`` if it is not what a sweep writes."""
    values = read_json(place / DEFINITION)
    for name, kind in KINDS.items():
        value: Any = values.get(name, ...) if isinstance(values, dict) else ...
        fits = isinstance(value, kind) and "\0" not in str(value)
        if name == "swept" and fits:
            lists = [*value.values()]
            fits = bool(lists) and all(isinstance(words, list) and words for words in lists)
            value = [word for words in lists for word in words] if fits else []
        if not fits or isinstance(value, list) and not all(isinstance(w, str) for w in value):
            raise ResultsError(
                f"{place / DEFINITION}: '{name}' is not what a sweep writes; put back a sound copy "
                "of it, or begin anew in another folder"
            )
    return values


def _carry_out(place: Path, points: list[Point], left: int, engine: Iterator[Outcome]) -> None:
    """Tell of each run that ends, and keep the table as it grows."""
    write_table(place / TABLE, points)
    with progress(label="sweep", total=len(points), initial=len(points) - left) as bar:
        for point, trouble in engine:
            if trouble:
                notice(f"{point.folder}: {trouble}; more in {point.log}")
            write_table(place / TABLE, points)
            bar.update()


def _check_options(script: Path, options: Sequence[str]) -> None:
    """Refuse options that the script's help does not know, before anything is run."""
    command = [sys.executable, "-m", "cadbem", "run", "--quiet", str(script), "--help"]
    helped = subprocess.run(command, capture_output=True, text=True, stdin=subprocess.DEVNULL)
    known = set(re.findall(r"--[a-zA-Z][\w-]*", helped.stdout))
    names = ["--" + option.removeprefix("--").partition("=")[0] for option in options]
    for name in [*names, "--output"]:
        if name not in known:
            there = ", ".join(sorted(known - {"--help"})) or "none"
            raise CadbemError(f"{script} has no option {name}; it has {there}")


def _points(place: Path, definition: dict[str, Any], cores: int) -> list[Point]:
    values = points_of(definition["swept"])
    digits, others = len(str(len(values))), tuple(definition["others"])
    script = definition["script"]
    if not os.path.isfile(script):
        raise CadbemError(f"{script:.200}: the script of the sweep in {place} is not there now")
    folders = [str((place / f"run_{k:0{digits}d}").resolve()) for k in range(1, len(values) + 1)]
    return [
        Point(folder, script, value, others, definition["start"], cores)
        for folder, value in zip(folders, values, strict=True)
    ]
