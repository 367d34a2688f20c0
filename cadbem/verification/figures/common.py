"""What the reports of several figures share."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import Protocol

from cadbem.boundary import Boundary
from cadbem.files import Folder
from cadbem.suspension.surroundings.channel_flow import ChannelFlow
from cadbem.suspension.time.history import History
from cadbem.suspension.time.simulation import Simulation
from cadbem.suspension.time.state import State

Runs = dict[tuple, History]
Simulate = Callable[..., History]
Keep = Callable[[Simulation, float, float], Iterator[State]]
KEEP = Simulation.run  # nowhere but in memory


class RunsFolder(Folder, Protocol):
    """A folder that keeps simulations, each in a part of its own."""

    def run(
        self, simulation: Simulation, end: float, every: float | None = None, part: str = ""
    ) -> Iterator[State]: ...


def labelled(part: str, runs: Mapping) -> Runs:
    """Runs with the ``part`` of a workflow in front of their names."""
    return {(part, *(key if isinstance(key, tuple) else (key,))): r for key, r in runs.items()}


def note_pictures(folder: Folder) -> None:
    """Says where pictures are."""
    print(f"the pictures are in {folder}")


def channel_flow(run: History) -> ChannelFlow:
    """The channel that a run was in."""
    flow = run.last.flow
    assert isinstance(flow, ChannelFlow), "unbounded fluid has no walls"
    return flow


def channel(run: History) -> Boundary:
    """Its boundary."""
    return channel_flow(run).problem.boundary


def report_stopped(runs: Mapping[str, History]) -> None:
    """Which runs ended early, and why."""
    for name, run in runs.items():
        if run.last.stopped:
            print(f"{name}: {run.last.stopped}")
