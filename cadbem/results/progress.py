"""How far the run in a folder has come: what of its files is valid, and which of them are sound."""

from __future__ import annotations

import csv
import json
import os
import zlib
from dataclasses import dataclass
from pathlib import Path

import h5py
import numpy as np

from cadbem.errors import ResultsError
from cadbem.files import as_results_error
from cadbem.results.hdf5 import is_sound, reading

SETUP, CHECKPOINT, BEFORE = "setup.h5", "checkpoint.h5", "checkpoint_before.h5"
FRAMES, PARAVIEW = "frames", "paraview"
TABLES = ("run.csv", "bodies.csv")


def frame_file(folder: Path, index: int) -> Path:
    """Where the frame of an index is."""
    return folder / FRAMES / f"{index:05d}.h5"


@dataclass(frozen=True)
class Progress:
    """The valid part of the files: the frames' ``times``, the ``columns`` of both tables, their
    ``sizes`` in bytes and the ``checks`` (CRC-32) of these; CPU ``seconds`` spent."""

    times: tuple[float, ...] = ()
    columns: tuple[list[str], list[str]] | None = None
    sizes: tuple[int, ...] = (0, 0)
    checks: tuple[int, ...] = (0, 0)
    seconds: float = 0.0

    def write(self, place: h5py.Group) -> None:
        """Write it into a checkpoint."""
        place["times"] = self.times
        place.attrs.update(
            columns=json.dumps(self.columns), sizes=self.sizes, checks=self.checks,
            seconds=self.seconds,
        )  # fmt: skip

    @classmethod
    def read(cls, place: h5py.Group) -> Progress:
        """What was written into a checkpoint."""
        sizes, checks = (tuple(int(n) for n in place.attrs[k]) for k in ("sizes", "checks"))
        names = json.loads(place.attrs["columns"])
        times = tuple(float(t) for t in place["times"][:])
        if not np.isfinite(times).all() or len(sizes) != 2 or min(sizes) < 0:
            raise ValueError("times or sizes are none")
        return cls(times, names, sizes, checks, float(place.attrs["seconds"]))


def newest_checkpoint(folder: Path) -> Path | None:
    """The newest of the two latest checkpoints in a folder that is sound, None if there is none."""
    return next((file for file in _checkpoints(folder) if is_sound(file)), None)


def has_checkpoint(folder: Path) -> bool:
    """Whether there is a checkpoint, sound or not."""
    return any(os.path.exists(file) for file in _checkpoints(folder))


def _checkpoints(folder: Path) -> tuple[Path, Path]:
    return folder / CHECKPOINT, folder / BEFORE


def sound_frames(folder: Path) -> int:
    """How many frames are sound, from the first one on."""
    count = 0
    while is_sound(frame_file(folder, count)):
        count += 1
    return count


def table_content(file: Path, size: int, check: int) -> bytes:
    """The first bytes of a table.  Raises ``ResultsError`` unless they are as they were written."""
    with as_results_error(file):
        content = file.read_bytes()[:size] if file.exists() else b""
    if len(content) < size or zlib.crc32(content) != check:
        raise ResultsError(f"{file} is damaged; the numbers are in the frames, too")
    return content


def progress_of_frames(folder: Path, count: int) -> Progress:
    """The progress when so many frames were there, from these and the tables.

    Raises ``ResultsError`` when a table is shorter than that."""
    times, bodies = [], 0
    for index in range(count):
        with reading(frame_file(folder, index)) as place:
            times.append(float(place.attrs["time"]))
            bodies += len(place.attrs["numbers"])
    parts = [_first_lines(folder / TABLES[0], count), _first_lines(folder / TABLES[1], bodies)]
    heads = [next(csv.reader(part.decode().splitlines())) for part in parts]
    last = parts[0].decode().splitlines()[-1].split(",")
    sizes, checks = tuple(map(len, parts)), tuple(map(zlib.crc32, parts))
    seconds = float(last[heads[0].index("cpu_seconds")])
    return Progress(tuple(times), (heads[0], heads[1]), sizes, checks, seconds)


def _first_lines(file: Path, rows: int) -> bytes:
    with as_results_error(file):
        lines = file.read_bytes().splitlines(keepends=True) if file.exists() else []
    if len(lines) < rows + 1:
        raise ResultsError(f"{file} is shorter than its frames say; put back a sound copy of it")
    return b"".join(lines[: rows + 1])
