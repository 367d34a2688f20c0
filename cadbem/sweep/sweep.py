"""A sweep: its folder, its runs, its table and plot."""

from __future__ import annotations

import json
import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from cadbem.errors import CadbemError, ResultsError
from cadbem.files import locked, make_folder, told, write_whole
from cadbem.operators.pool import CORES
from cadbem.progress import notice, progress
from cadbem.sweep.engines import on_a_cluster, on_this_machine
from cadbem.sweep.point import Point
from cadbem.sweep.report import draw_table, write_table
from cadbem.sweep.values import parsed, points_of

ASKED, TABLE, PLOT = "sweep.json", "table.csv", "sweep.png"


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
    with told(folder):
        if folder.exists() and any(folder.iterdir()):
            how = f"go on with 'cadbem resume {folder}', or " if (folder / ASKED).exists() else ""
            raise ResultsError(f"{folder} exists already; {how}choose another folder with -o")
    make_folder(folder)
    asked = {
        "script": str(Path(script).resolve()),
        "swept": swept,
        "others": others,
        "jobs": jobs,
        "cluster": cluster,
    }
    write_whole(folder / ASKED, (json.dumps(asked, indent=2) + "\n").encode())
    return resume_sweep(folder)


def resume_sweep(folder: str | os.PathLike[str]) -> int:
    """Run what is left of a sweep in a folder; returns 0, or 1 if any run failed."""
    place = Path(folder)
    asked = json.loads((place / ASKED).read_text())
    jobs = min(asked["jobs"] or CORES.get(), max(len(points_of(asked["swept"])), 1))
    cores = 1 if asked["cluster"] else max(1, CORES.get() // jobs)
    points = _points(place, asked, cores)
    left = [point for point in points if point.summary is None]
    with locked(place):
        cluster = asked["cluster"]
        engine = on_a_cluster(left, cluster) if cluster else on_this_machine(left, jobs)
        with progress(label="sweep", total=len(points), initial=len(points) - len(left)) as bar:
            for point, well in engine:
                if not well:
                    notice(f"{point.folder}: {point.failure}; more in {point.log}")
                write_table(place / TABLE, points)
                bar.update()
    write_table(place / TABLE, points)
    pictures = draw_table(place / PLOT, points)
    print("\n".join(str(file) for file in (place / TABLE, *pictures)))
    return 0 if all(point.summary is not None for point in points) else 1


def _points(place: Path, asked: dict[str, Any], cores: int) -> list[Point]:
    points = points_of(asked["swept"])
    digits, others = len(str(len(points))), tuple(asked["others"])
    script = asked["script"]
    if not Path(script).is_file():
        raise CadbemError(f"{script}: the script of the sweep is not there any more")
    folders = [str((place / f"run_{k:0{digits}d}").resolve()) for k in range(1, len(points) + 1)]
    pairs = zip(folders, points, strict=True)
    return [Point(folder, script, values, others, cores) for folder, values in pairs]

