"""The history of a run: its states, and the shapes and paths of bodies over time."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from cadbem.checks import finite
from cadbem.errors import ShapeError
from cadbem.spline.basis import Array
from cadbem.spline.closed import ClosedSpline
from cadbem.suspension.bodies.droplet import Droplet
from cadbem.suspension.interface.volume import volume
from cadbem.suspension.multibody.measures import area, taylor_deformation
from cadbem.suspension.surroundings.channel_flow import ChannelFlow
from cadbem.suspension.time.overview import history_overview
from cadbem.suspension.time.state import State


@dataclass(frozen=True, eq=False)
class Course:
    """What becomes of the body of a ``number`` at the ``times`` (N,) at which it is there.

    ``centre`` and its ``velocity`` (dim, N); Taylor's ``deformation`` (N,), not a number for a
    rigid particle; the narrowest ``gap`` (N,), inf where it is wide.  ``extra_pressure`` is what
    all bodies together add to the mean pressure (N,) at each opening of a channel, by name.
    """

    number: int
    times: Array
    centre: Array
    velocity: Array
    deformation: Array
    gap: Array
    extra_pressure: dict[str, Array]

    @property
    def speed(self) -> Array:
        """Of the centre (N,)."""
        return np.linalg.norm(self.velocity, axis=0)

    @property
    def heading(self) -> Array:
        """Angle (N,) in degrees to x, in the plane of x and y, of the direction in which the
        centre goes, without jumps; from two times on."""
        return plane_angle(np.gradient(self.centre[:2], self.times, axis=1))

    @property
    def way(self) -> float:
        """Length of the centre's path, by straight lines."""
        return float(np.linalg.norm(np.diff(self.centre, axis=1), axis=0).sum())

    def extra_drop(self, start: str = "inlet", end: str = "outlet") -> Array:
        """The extra pressure (N,) at one opening less that at another."""
        return self.extra_pressure[start] - self.extra_pressure[end]


@dataclass(frozen=True, eq=False)
class History:
    """The ``states`` of a run in the order of time, and the CPU ``seconds`` that they took.

    Shapes over time are those of the first droplet.
    """

    states: tuple[State, ...]
    seconds: float = 0.0

    def __post_init__(self) -> None:
        if not self.states:
            raise ShapeError("states is empty; give at least one state of a run")

    def __repr__(self) -> str:
        return history_overview(self).text()

    def _repr_html_(self) -> str:
        return history_overview(self).html()

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

    def turn(self, number: int = 1) -> Array:
        """Matrices (dim, dim, N) that turn a rigid particle's shape, as it was given, into its
        place; their columns are where the shape's axes point."""
        particles = [s.bodies[s.numbers.index(number)] for s in self.states if number in s.numbers]
        return np.stack([p.pose.matrix for p in particles], axis=-1)  # type: ignore[attr-defined]

    @property
    def cost(self) -> str:
        """What the run took, and why it ended early, if it did."""
        last = self.last
        text = f"{last.steps} steps, {last.evaluations} evaluations, {self.seconds:.0f} CPU s"
        return f"{text}\nended: {last.stopped}" if last.stopped else text

    @property
    def numbers(self) -> tuple[int, ...]:
        """Numbers of all bodies, those that left included."""
        return self.states[0].numbers

    def course(self, number: int = 1) -> Course:
        """Centre, velocity, D, gap and extra pressure over time of the body of a number.

        Solves for the velocities at each time, as often as they are not known yet.
        """
        here = [(s, s.numbers.index(number)) for s in self.states if number in s.numbers]
        times, centres = self.track(number)
        droplet = isinstance(here[0][0].bodies[here[0][1]], Droplet)
        nothing = np.full(len(times), np.nan)
        there = np.array([number in s.numbers for s in self.states])
        return Course(
            number=number,
            times=times,
            centre=centres,
            velocity=np.array([s.velocities[k] for s, k in here]).T,
            deformation=self.of(taylor_deformation, number) if droplet else nothing,
            gap=np.array([s.gap(number) for s, _ in here]),
            extra_pressure={n: v[there] for n, v in self.extra_pressure.items()},
        )

    @cached_property
    def extra_pressure(self) -> dict[str, Array]:
        """What the bodies add to the mean pressure (N,) at each opening of a channel, by name;
        nothing in unbounded fluid."""
        flow = self.last.flow
        if not isinstance(flow, ChannelFlow):
            return {}
        return {
            name: np.array([s.walls.mean_pressure(name) for s in self.states])
            - flow.empty.mean_pressure(name)
            for name in flow.problem.openings
        }

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
        finite("moment", moment)
        near = int(abs(self.times - moment).argmin())
        if abs(self.times[near] - moment) > 1e-9 * max(1.0, abs(moment)):
            raise ShapeError(
                f"no state was kept at time {moment:g}, the nearest is at {self.times[near]:g}: "
                "choose the run's 'every' so that it divides the times you ask for"
            )
        return self.states[near]


def plane_angle(vectors: Array, period: float = 360.0) -> Array:
    """Angle (N,) in degrees to x, in the plane of x and y, of vectors (dim, N), without jumps;
    ``period`` is 180 for axes without a direction."""
    return np.unwrap(np.degrees(np.arctan2(vectors[1], vectors[0])), period=period)


def record(states: Iterable[State]) -> History:
    """The history of a run, such as ``simulation.run(5.0, every=0.1)``, whose states are kept."""
    start = time.process_time()
    kept = tuple(states)
    return History(kept, time.process_time() - start)
