"""The storage of a run in a folder while it goes on, from which it continues after any end.

At each accepted step the frames that it completes are written, then the rows of the tables, and
last the checkpoint, which says how many frames and bytes are valid.  What an interruption leaves
beyond that is overwritten: a run loses at most the step that it was computing.
"""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import h5py

from cadbem.errors import ResultsError
from cadbem.files import (
    csv_lines,
    locked,
    make_folder,
    names_of,
    read_json,
    write_at,
    write_json,
)
from cadbem.post.bodies.series import write_channel, write_frame, write_index
from cadbem.results.describe import described, first_difference
from cadbem.results.encode import (
    ReferenceShape,
    Writing,
    read_checkpoint,
    read_state,
    reading,
    write_boundary,
    write_checkpoint,
    write_fields,
    write_reference_shape,
    write_state,
)
from cadbem.results.series import body_rows, frame_of, run_row
from cadbem.suspension.surroundings.channel_flow import ChannelFlow
from cadbem.suspension.time.checkpoint import Checkpoint
from cadbem.suspension.time.simulation import Simulation
from cadbem.suspension.time.state import State

DESCRIPTION, SETUP, CHECKPOINT = "simulation.json", "setup.h5", "checkpoint.h5"
FRAMES, PARAVIEW = "frames", "paraview"
TABLES = ("run.csv", "bodies.csv")
Note = Callable[[str], None]


def frame_file(folder: Path, index: int) -> Path:
    """Where the frame of an index is."""
    return folder / FRAMES / f"{index:05d}.h5"


@dataclass(frozen=True, eq=False)
class Store:
    """The ``folder`` of one simulation's run, and ``note``, which receives lines for the log."""

    folder: Path
    simulation: Simulation
    note: Note

    def run(self, end: float, every: float | None) -> Iterator[State]:
        """The states that ``simulation.run`` gives: first those of an earlier run, if there was
        one, then the rest of them."""
        make_folder(self.folder)
        with locked(self.folder):
            kept = self._begun(every)
            if kept is None:
                since, progress = None, Progress()
            else:
                since, progress = kept
                self._check_end(since.state, end)
                self.note(f"goes on from t = {since.state.time:.6g}, {len(progress.times)} frames")
            for index in range(len(progress.times)):
                yield self._frame(index)
            yield from self._rest(end, every, since, progress)

    def _check_end(self, state: State, end: float) -> None:
        if not state.stopped and end < state.time * (1 - 1e-12):
            raise ResultsError(
                f"{self.folder} has come to t = {state.time:.6g} already, beyond the end that is "
                f"asked for, {end:g}; ask for a later one"
            )

    def _rest(
        self, end: float, every: float | None, since: Checkpoint | None, progress: Progress
    ) -> Iterator[State]:
        """The rest of the run: its steps after the checkpoint."""
        reached = since.state.time if since else 0.0
        started = time.process_time() - progress.seconds
        try:
            for states, checkpoint in self.simulation.advance(end, every, since):
                progress = replace(progress, seconds=time.process_time() - started)
                for state in states:
                    progress = self._keep(state, progress)
                self._checkpoint(checkpoint, progress)
                reached = checkpoint.state.time
                yield from states
                if checkpoint.state.stopped:
                    self.note(f"ended: {checkpoint.state.stopped}")
        except BaseException as error:
            why = "interrupted" if isinstance(error, KeyboardInterrupt | GeneratorExit) else error
            self.note(f"stopped at t = {reached:.6g}: {why}")
            raise
        self.note(f"done at t = {reached:.6g}, {len(progress.times)} frames")

    def _begun(self, every: float | None) -> tuple[Checkpoint, Progress] | None:
        """Where an earlier run of the same simulation ended; begins one if there was none.

        Raises ``ResultsError`` when it was another simulation.
        """
        description = described(self.simulation) | {"every": repr(every)}
        file, checkpoint = self.folder / DESCRIPTION, self.folder / CHECKPOINT
        if file.exists():
            differs = first_difference(read_json(file), description)
            if differs:
                raise ResultsError(
                    f"{self.folder} holds the run of something else ({differs}); go on with what "
                    "it was made from, or choose another folder"
                )
        if checkpoint.exists():
            with reading(checkpoint) as place:
                return read_checkpoint(place, self.simulation), Progress.read(place)
        self._begin(description)
        return None

    def _begin(self, description: dict[str, str]) -> None:
        start, flow = self.simulation.start, self.simulation.flow
        make_folder(self.folder / FRAMES)
        with Writing(self.folder / SETUP) as place:
            if isinstance(flow, ChannelFlow):
                write_boundary(place.create_group("channel"), flow.problem.boundary)
            for number, body in zip(start.numbers, start.bodies, strict=True):
                write_reference_shape(place.create_group(f"body_{number}"), ReferenceShape.of(body))
        if isinstance(flow, ChannelFlow):
            write_channel(self.folder / PARAVIEW, flow.problem.boundary)
        write_json(self.folder / DESCRIPTION, description)

    def _frame(self, index: int) -> State:
        with reading(frame_file(self.folder, index)) as place:
            return read_state(place, self.simulation)

    def _keep(self, state: State, progress: Progress) -> Progress:
        """Write a frame and its rows."""
        index, times = len(progress.times), (*progress.times, state.time)
        work = replace(state)  # what is worked out for the tables is not kept in memory
        frame = frame_of(work)
        with Writing(frame_file(self.folder, index)) as place:
            write_state(place, state)
            write_fields(place, frame.fields)
        write_frame(self.folder / PARAVIEW, index, frame)
        write_index(self.folder / PARAVIEW, times)
        rows = [run_row(work, progress.seconds)], body_rows(work)
        heads = progress.columns or (names_of(rows[0]), names_of(rows[1]))
        sizes = []
        for name, head, size, part in zip(TABLES, heads, progress.sizes, rows, strict=True):
            sizes.append(write_at(self.folder / name, size, csv_lines(part, head, not size)))
        return replace(progress, times=times, columns=heads, sizes=tuple(sizes))

    def _checkpoint(self, checkpoint: Checkpoint, progress: Progress) -> None:
        with Writing(self.folder / CHECKPOINT) as place:
            write_checkpoint(place, checkpoint)
            progress.write(place)


@dataclass(frozen=True)
class Progress:
    """The valid part of the files: the frames' ``times``, the ``columns`` of both tables and their
    ``sizes`` in bytes; CPU ``seconds`` spent."""

    times: tuple[float, ...] = ()
    columns: tuple[list[str], list[str]] | None = None
    sizes: tuple[int, ...] = (0, 0)
    seconds: float = 0.0

    def write(self, place: h5py.Group) -> None:
        place["times"] = self.times
        place.attrs.update(columns=json.dumps(self.columns), sizes=self.sizes, seconds=self.seconds)

    @classmethod
    def read(cls, place: h5py.Group) -> Progress:
        sizes = tuple(int(size) for size in place.attrs["sizes"])
        names = json.loads(place.attrs["columns"])
        times = tuple(float(t) for t in place["times"][:])
        return cls(times, names, sizes, float(place.attrs["seconds"]))
