"""The storage of a run in a folder while it goes on, from which it continues after any end.

At each accepted step the frames that it completes are written, then the rows of the tables, and
last the checkpoint, which says how many frames and bytes are valid.  What an interruption leaves
beyond that is overwritten: a run loses at most the step that it was computing.  The checkpoint of
the step before is kept, in case that the latest one is damaged.
"""

from __future__ import annotations

import time
import zlib
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path

from cadbem.command import MEND
from cadbem.errors import ResultsError
from cadbem.files import (
    csv_lines,
    locked,
    make_folder,
    names_of,
    read_json,
    remove_unfinished,
    write_at,
    write_json,
)
from cadbem.post.bodies.series import write_channel, write_frame, write_index
from cadbem.progress import notice
from cadbem.results.describe import described, first_difference
from cadbem.results.encode import (
    ReferenceShape,
    read_checkpoint,
    read_state,
    write_boundary,
    write_checkpoint,
    write_fields,
    write_reference_shape,
    write_state,
)
from cadbem.results.hdf5 import Writing, is_sound, reading
from cadbem.results.progress import (
    BEFORE,
    CHECKPOINT,
    FRAMES,
    PARAVIEW,
    SETUP,
    TABLES,
    Progress,
    frame_file,
    has_checkpoint,
    newest_checkpoint,
    progress_of_frames,
    sound_frames,
    table_content,
)
from cadbem.results.series import body_rows, frame_of, run_row
from cadbem.suspension.surroundings.channel_flow import ChannelFlow
from cadbem.suspension.time.checkpoint import Checkpoint
from cadbem.suspension.time.inputs import check_times
from cadbem.suspension.time.simulation import Simulation
from cadbem.suspension.time.state import State

DESCRIPTION = "simulation.json"
ANEW = "put back a sound copy, or begin anew in another folder"
Note = Callable[[str], None]


@dataclass(frozen=True)
class Kept:
    """What an earlier run has left: the ``checkpoint`` to go on from, if any, the ``progress`` at
    it, and remarks to be ``said``; ``mended`` where files after it are damaged."""

    checkpoint: Checkpoint | None = None
    progress: Progress = Progress()
    said: tuple[str, ...] = ()
    mended: bool = False


@dataclass(frozen=True, eq=False)
class Store:
    """The ``folder`` of one simulation's run, ``note``, which receives lines for the log, and
    ``accepted``, which is called when nothing is in the way of the run and the folder is locked:
    before that nothing is written."""

    folder: Path
    simulation: Simulation
    note: Note
    accepted: Callable[[], None]

    def run(self, end: float, every: float | None) -> Iterator[State]:
        """The states that ``simulation.run`` gives: first those of an earlier run, if there was
        one, then the rest of them."""
        check_times(end, every)
        make_folder(self.folder)
        with locked(self.folder):
            description = described(self.simulation) | {"every": repr(every)}
            kept = self._kept(description)
            since, progress = kept.checkpoint, kept.progress
            if since is not None:
                self._check_end(since.state, end)
            self.accepted()
            self._prepare(description, kept)
            if since is not None:
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

    def _kept(self, description: dict[str, str]) -> Kept:
        """Where an earlier run of the same simulation ended, if there was one.

        Raises ``ResultsError`` when it was another simulation, or when its files are damaged.
        """
        file = self.folder / DESCRIPTION
        if file.exists():
            before = read_json(file)
            if not isinstance(before, dict) or not all(isinstance(v, str) for v in before.values()):
                raise ResultsError(f"{file} is not what a run writes; {ANEW}")
            differs = first_difference(before, description)
            if differs:
                raise ResultsError(
                    f"{self.folder} holds the run of something else ({DESCRIPTION} has "
                    f"{differs}); go on with what it was made from, or choose another folder"
                )
        newest, sound = newest_checkpoint(self.folder), sound_frames(self.folder)
        if newest is None:
            # the first frame comes before the first checkpoint
            begun = has_checkpoint(self.folder) or frame_file(self.folder, 1).exists()
            return self._mended(self.folder / CHECKPOINT, sound) if begun else Kept()
        with reading(newest, ANEW) as place:
            checkpoint, progress = read_checkpoint(place, self.simulation), Progress.read(place)
        if sound < len(progress.times):
            return self._mended(frame_file(self.folder, sound), sound)
        said = self._damaged_tables(progress)
        if newest.name == BEFORE and (self.folder / CHECKPOINT).exists():
            said.append(f"{CHECKPOINT} is damaged; goes on from the one of the step before")
        return Kept(checkpoint, progress, tuple(said))

    def _mended(self, broken: Path, sound: int) -> Kept:
        """The run as it was at its newest sound frame, or nothing; only if the user wants that."""
        if not MEND.get():
            raise ResultsError(
                f"{broken} is missing or damaged: {ANEW}, or let 'cadbem resume FOLDER --mend' go "
                f"on from {f'frame {sound - 1}' if sound else 'the beginning'}, the newest state "
                "that is sound"
            )
        said = (f"{broken} was missing or damaged; goes on from {sound} sound frames",)
        if not sound:
            return Kept(said=said, mended=True)
        progress = progress_of_frames(self.folder, sound)
        checkpoint = self.simulation.march.beginning(self._frame(sound - 1))
        return Kept(checkpoint, progress, said, mended=True)

    def _damaged_tables(self, progress: Progress) -> list[str]:
        """What to say of tables that are not as they were written."""
        said = []
        for name, size, check in zip(TABLES, progress.sizes, progress.checks, strict=True):
            try:
                table_content(self.folder / name, size, check)
            except ResultsError as error:
                said.append(str(error))
        return said

    def _prepare(self, description: dict[str, str], kept: Kept) -> None:
        """Everything but frames and tables, where it is missing or to be made anew."""
        for text in kept.said:
            notice(f"{self.folder}: {text}")
            self.note(text)
        for folder in (self.folder, self.folder / FRAMES, self.folder / PARAVIEW):
            remove_unfinished(folder)
        make_folder(self.folder / FRAMES)
        if kept.checkpoint is None or not is_sound(self.folder / SETUP):
            self._set_up()
        write_json(self.folder / DESCRIPTION, description)
        if kept.mended:
            for name in (CHECKPOINT, BEFORE):
                (self.folder / name).unlink(missing_ok=True)
        if kept.mended and kept.checkpoint is not None:
            self._checkpoint(kept.checkpoint, kept.progress)

    def _set_up(self) -> None:
        start, flow = self.simulation.start, self.simulation.flow
        with Writing(self.folder / SETUP) as place:
            if isinstance(flow, ChannelFlow):
                write_boundary(place.create_group("channel"), flow.problem.boundary)
            for number, body in zip(start.numbers, start.bodies, strict=True):
                write_reference_shape(place.create_group(f"body_{number}"), ReferenceShape.of(body))
        if isinstance(flow, ChannelFlow):
            write_channel(self.folder / PARAVIEW, flow.problem.boundary)

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
        sizes, checks = [], []
        for k, name in enumerate(TABLES):
            lines = csv_lines(rows[k], heads[k], not progress.sizes[k])
            sizes.append(write_at(self.folder / name, progress.sizes[k], lines))
            checks.append(zlib.crc32(lines, progress.checks[k]))
        return Progress(times, heads, tuple(sizes), tuple(checks), progress.seconds)

    def _checkpoint(self, checkpoint: Checkpoint, progress: Progress) -> None:
        file = self.folder / CHECKPOINT
        if is_sound(file):
            file.replace(self.folder / BEFORE)
        with Writing(file) as place:
            write_checkpoint(place, checkpoint)
            progress.write(place)
