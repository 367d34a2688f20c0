"""A run read back from its folder, without its script."""

from __future__ import annotations

import csv
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from cadbem.boundary import Boundary
from cadbem.errors import ResultsError
from cadbem.files import as_results_error
from cadbem.post.fields.frames import Frame
from cadbem.results.encode import (
    ReferenceShape,
    read_boundary,
    read_fields,
    read_reference_shape,
)
from cadbem.results.hdf5 import reading
from cadbem.results.overview import stored_text
from cadbem.results.progress import (
    CHECKPOINT,
    SETUP,
    TABLES,
    Progress,
    frame_file,
    has_checkpoint,
    newest_checkpoint,
    table_content,
)
from cadbem.spline.basis import Array


@dataclass(frozen=True, eq=False)
class StoredRun:
    """A simulation's run in a ``folder``; the frames' ``times`` (N,) as far as it had come when it
    was opened, and the ``progress`` then."""

    folder: Path
    times: Array
    progress: Progress

    __repr__ = stored_text

    @cached_property
    def channel(self) -> Boundary | None:
        """The channel, or None in unbounded fluid."""
        with reading(self.folder / SETUP) as place:
            return read_boundary(place["channel"]) if "channel" in place else None

    @cached_property
    def _reference_shapes(self) -> dict[int, ReferenceShape]:
        with reading(self.folder / SETUP) as place:
            bodies = [name for name in place if name.startswith("body_")]
            return {int(name[5:]): read_reference_shape(place[name]) for name in bodies}

    def frame(self, index: int) -> Frame:
        """The bodies at one of the times, with their fields."""
        with reading(frame_file(self.folder, index)) as place:
            shapes = {
                int(n): self._reference_shapes[int(n)].at(place[f"body_{n}"])
                for n in place.attrs["numbers"]
            }
            return Frame(float(place.attrs["time"]), shapes, read_fields(place))

    @property
    def frames(self) -> list[Frame]:
        """All of them, in the order of time."""
        return [self.frame(index) for index in range(len(self.times))]

    @property
    def run_table(self) -> dict[str, Array]:
        """The columns (N,) of run.csv."""
        return self._table(0)

    @property
    def body_table(self) -> dict[str, Array]:
        """The columns of bodies.csv: a row for each frame and body; not a number where empty."""
        return self._table(1)

    def _table(self, number: int) -> dict[str, Any]:
        sizes, checks = self.progress.sizes, self.progress.checks
        file = self.folder / TABLES[number]
        return _columns(file, table_content(file, sizes[number], checks[number]))


def open_run(path: str | Path) -> StoredRun:
    """The run of a simulation in a folder, finished or not.

    Raises ``ResultsError`` when there is none; where a run has parts, it names them.
    """
    folder = Path(path)
    if not has_checkpoint(folder):
        with as_results_error(folder):
            parts = sorted(p.parent.name for p in folder.glob(f"*/{CHECKPOINT}"))
        hint = f"; its parts have: {', '.join(parts)}" if parts else ""
        raise ResultsError(f"{folder} holds no frames of a simulation{hint}")
    with reading(newest_checkpoint(folder) or folder / CHECKPOINT) as place:
        progress = Progress.read(place)
    return StoredRun(folder, np.array(progress.times), progress)


def _columns(file: Path, content: bytes) -> dict[str, Any]:
    """Columns by name: of numbers, not a number where empty, or of words."""
    rows = list(csv.reader(content.decode(errors="replace").splitlines()))
    if len({len(row) for row in rows}) > 1:
        raise ResultsError(f"{file} is damaged; the numbers are in the frames, too")
    return {name: _column(cells) for name, *cells in zip(*rows, strict=True)}


def _column(cells: list[str]) -> Any:
    try:
        return np.array([float(cell) if cell else np.nan for cell in cells])
    except ValueError:
        return np.array(cells)
