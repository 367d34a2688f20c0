"""Pictures of a stored run."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from cadbem.post.movie import draw_movie, filmstrip
from cadbem.post.trajectories import draw_trajectories
from cadbem.results.store import CHECKPOINT
from cadbem.results.stored import StoredRun, open_run

PICTURES = "pictures"


def render(folder: str | Path, colour: str = "") -> list[Path]:
    """Movie, film strip and paths of each simulation in a run's folder, also of one that is going
    on, in its own ``pictures``; returns what was drawn.

    ``colour`` names a field to colour bodies by, see ``draw_movie``; each has its own pictures.
    Raises ``ResultsError`` when the folder holds no frames, and as ``draw_movie`` does.
    """
    parts = [path.parent for path in sorted(Path(folder).glob(f"**/{CHECKPOINT}"))]
    runs = [open_run(part) for part in parts or [Path(folder)]]
    return [picture for run in runs for picture in _drawn(run, colour)]


def _drawn(run: StoredRun, colour: str) -> list[Path]:
    place, channel, frames = run.folder / PICTURES, run.channel, run.frames
    name = f"_{colour.replace(' ', '_')}" if colour else ""
    return [
        draw_movie(place / f"movie{name}.mp4", channel, frames, colour=colour),
        draw_movie(place / f"movie{name}.gif", channel, frames, colour=colour),
        filmstrip(place / f"filmstrip{name}.png", channel, frames, colour=colour),
        draw_trajectories(place / "paths.png", channel, tracks(run)),
    ]


def tracks(run: StoredRun) -> dict[str | int, ArrayLike]:
    """Centres (dim, N) of each body as long as it was there, by number."""
    table = run.body_table
    axes = [table[axis] for axis in "xyz" if axis in table]
    return {
        int(number): np.stack([axis[table["body"] == number] for axis in axes])
        for number in np.unique(table["body"])
    }
