"""Pictures of a stored run."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from cadbem.files import as_results_error
from cadbem.post.run_pictures import RunPictures, Series
from cadbem.results.progress import CHECKPOINT
from cadbem.results.stored import StoredRun, open_run
from cadbem.spline.basis import Array

PICTURES = "pictures"
NAMES = ("movie.mp4", "movie.gif", "filmstrip.png", "series.png", "paths.png")
ROUND = 5e-3  # D below which a droplet has no inclination
SERIES = {"D": "deformation", "inclination (degrees)": "inclination", "narrowest gap": "gap"}


def render(folder: str | Path, colour: str = "") -> list[Path]:
    """Movie, film strip, paths and measures over time of each simulation in a run's folder, also of
    one that is going on, in its own ``pictures``; returns what was drawn.

    ``colour`` names a field to colour bodies by, see ``draw_movie``; each has its own pictures.
    Raises ``ResultsError`` when the folder holds no frames, and as ``draw_movie`` does.
    """
    with as_results_error(Path(folder)):
        parts = [path.parent for path in sorted(Path(folder).glob(f"**/{CHECKPOINT}"))]
    runs = [open_run(part) for part in parts or [Path(folder)]]
    return [picture for run in runs for picture in _drawn(run, colour)]


def _drawn(run: StoredRun, colour: str) -> list[Path]:
    drawn = RunPictures(run.folder / PICTURES, run.channel, run.frames, _tracks(run), None, colour)
    return drawn.draw(NAMES, run.times, _series(run, drawn.moving))


def _tracks(run: StoredRun) -> dict[str | int, Array]:
    """Centres (dim, N) of each body as long as it was there, by number."""
    table = run.body_table
    axes = [table[axis] for axis in "xyz" if axis in table]
    return {
        int(number): np.stack([axis[table["body"] == number] for axis in axes])
        for number in np.unique(table["body"])
    }


def _series(run: StoredRun, moves: bool) -> Series:
    """Speed, and the measures in ``SERIES`` that any body has, by number."""
    table = run.body_table
    velocity = [table[f"velocity_{axis}"] for axis in "xyz" if f"velocity_{axis}" in table]
    columns = {"speed": np.linalg.norm(velocity, axis=0)} if moves else {}
    columns |= {label: table[name] for label, name in SERIES.items() if name in table}
    if "inclination" in table:
        longish = table["deformation"] > ROUND
        columns["inclination (degrees)"] = np.where(longish, table["inclination"], np.nan)
    shown = {label: values for label, values in columns.items() if np.isfinite(values).sum() > 1}
    frame = np.searchsorted(run.times, table["time"])
    numbers = np.unique(table["body"])
    return {
        label: {int(n): _placed(values, frame, table["body"] == n, run) for n in numbers}
        for label, values in shown.items()
    }


def _placed(values: Array, frame: NDArray, own: NDArray, run: StoredRun) -> Array:
    """A body's values at each of the run's times (N,), not a number where it has none."""
    placed = np.full(len(run.times), np.nan)
    finite = own & np.isfinite(values)
    placed[frame[finite]] = values[finite]
    return placed
