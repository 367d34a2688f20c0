"""The history of a run: its states, and the shapes and paths of bodies over time."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from cadbem.errors import ShapeError
from cadbem.spline.basis import Array
from cadbem.spline.closed import ClosedSpline
from cadbem.suspension.interface.volume import volume
from cadbem.suspension.multibody.measures import area, taylor_deformation
from cadbem.suspension.time.state import State


@dataclass(frozen=True, eq=False)
class History:
    """The ``states`` of a run in the order of time, and the CPU ``seconds`` that they took.

    Shapes over time are those of the first droplet.
    """

    states: tuple[State, ...]
    seconds: float = 0.0

    @property
    def last(self) -> State:
        """The final state; its ``stopped`` is empty, or says why the run ended early."""
        return self.states[-1]

    @property
    def times(self) -> Array:
        """Times (N,)."""
        return np.array([state.time for state in self.states])

    def of(self, quantity: Callable[[ClosedSpline], float], number: int | None = None) -> Array:
        """A quantity of the shape at each time (N,), of the first droplet or of that with a
        ``number``, as long as it was there."""
        if number is None:
            return np.array([quantity(state.droplet.shape) for state in self.states])
        here = [s.shapes[number] for s in self.states if number in s.numbers]
        return np.array([quantity(shape) for shape in here])  # type: ignore[arg-type]

    def track(self, number: int = 1) -> tuple[Array, Array]:
        """Times (N,) and centres (dim, N) of the body of a number, as long as it was there."""
        here = [s for s in self.states if number in s.numbers]
        centres = [s.bodies[s.numbers.index(number)].centre for s in here]
        return np.array([s.time for s in here]), np.array(centres).T

    @cached_property
    def deformation(self) -> Array:
        """Taylor's D (N,)."""
        return self.of(taylor_deformation)

    @cached_property
    def volume(self) -> Array:
        """Enclosed volume, or area in 2D (N,)."""
        return self.of(volume)

    @cached_property
    def area(self) -> Array:
        """Area of the surface, or length of a plane curve (N,)."""
        return self.of(area)

    def at(self, moment: float) -> State:
        """The state kept at a time.  Raises ShapeError where there is none."""
        near = int(abs(self.times - moment).argmin())
        if abs(self.times[near] - moment) > 1e-9 * max(1.0, abs(moment)):
            raise ShapeError(
                f"no state was kept at time {moment:g}, the nearest is at {self.times[near]:g}: "
                "choose the run's 'every' so that it divides the times you ask for"
            )
        return self.states[near]


def record(states: Iterable[State]) -> History:
    """The history of a run, such as ``simulation.run(5.0, every=0.1)``, whose states are kept."""
    start = time.process_time()
    kept = tuple(states)
    return History(kept, time.process_time() - start)
