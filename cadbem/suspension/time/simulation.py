"""The simulation of bodies in time: velocities, steps, corrections, and reasons to stop."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from cadbem.errors import ConditionError, ShapeError
from cadbem.operators.far.equivalent import FarField
from cadbem.progress import progress
from cadbem.quadrature.closed import PolarRule, SelfRule
from cadbem.spline.basis import Array
from cadbem.suspension.bodies.body import Body
from cadbem.suspension.bodies.droplet import Droplet
from cadbem.suspension.interface.mesh import RelaxMesh
from cadbem.suspension.interface.motion import Motion, affine_velocity
from cadbem.suspension.interface.points import AdaptivePoints
from cadbem.suspension.interface.volume import CorrectVolume
from cadbem.suspension.multibody.contact import Contact, StopAtGap, check_start
from cadbem.suspension.multibody.environment import Environment
from cadbem.suspension.surroundings.surroundings import Surroundings
from cadbem.suspension.time.adapting import adapted_state, finer_state
from cadbem.suspension.time.checkpoint import (
    Checkpoint,
    coordinates,
    coordinates_between,
    ends,
    moved,
)
from cadbem.suspension.time.inputs import check_parts, check_times
from cadbem.suspension.time.limits import bounded, leaving, longest_step, output_times, too_far
from cadbem.suspension.time.overview import simulation_overview
from cadbem.suspension.time.relaxation import Relaxation
from cadbem.suspension.time.state import State
from cadbem.suspension.time.stepping import Adaptive, Errors, Lengths, Step, Stepper

SMALLEST_STEP = 1e-7  # share of the run below which a step has failed
FIRST_MOVES = 10.0  # the first step is a share of the time in which a body moves by its size


@dataclass(frozen=True, eq=False)
class Simulation:
    """One body or several, droplets and rigid particles, in a ``flow``, unbounded or in a channel.

    ``stepper`` advances in time; ``motion`` chooses how points move along droplets; ``volume`` and
    ``mesh`` repair their shapes after each step, or do not (None); ``rule`` integrates over them;
    ``contact`` is the rule for narrow gaps; ``far`` are the equivalent sources of distant bodies
    (None: direct sums); ``points`` chooses the points of droplets anew (None: they stay).  Bodies
    that reach an opening of the channel have left and are taken out; the run ends with the last.
    """

    flow: Surroundings
    bodies: Body | Sequence[Body]
    stepper: Stepper = Adaptive()
    motion: Motion = affine_velocity
    volume: CorrectVolume | None = CorrectVolume()
    mesh: RelaxMesh | None = None
    rule: SelfRule = PolarRule()
    contact: Contact = StopAtGap()
    far: FarField | None = FarField()
    points: AdaptivePoints | None = None

    def __post_init__(self) -> None:
        check_parts(self)

    def __repr__(self) -> str:
        return simulation_overview(self).text()

    def _repr_html_(self) -> str:
        return simulation_overview(self).html()

    @cached_property
    def start(self) -> State:
        """The state at time 0."""
        bodies = tuple(self.bodies) if isinstance(self.bodies, Sequence) else (self.bodies,)
        return State(self.environment, 0.0, bodies, tuple(range(1, len(bodies) + 1)))

    @property
    def droplet(self) -> Droplet:
        """The first droplet at the beginning."""
        return self.start.droplet

    @property
    def environment(self) -> Environment:
        """The surroundings and rules that all states of the run share."""
        return Environment(self.flow, self.rule, self.contact, self.far)

    def run(self, end: float, every: float | None = None) -> Iterator[State]:
        """States at time 0, at each multiple of ``every`` (or after each step), and at ``end``.

        A run ends early when points no longer resolve a shape or a gap: the last state is the last
        valid one, and its ``stopped`` says why.  Raises ConditionError for bodies that are not
        inside the channel, or overlap.
        """
        for states, _ in self.advance(end, every):
            yield from states

    def advance(
        self, end: float, every: float | None = None, since: Checkpoint | None = None
    ) -> Iterator[tuple[list[State], Checkpoint]]:
        """As ``run``, step by step: the states of each step, and a checkpoint at its end.

        From that, as ``since``, another call goes on as if there had been no pause.
        """
        check_times(end, every)
        if since is None:
            check_start(self.flow, self.start.placed, self.start.numbers)
            since = self.beginning(self.start)
            yield [self.start], since
        now = since.state.time
        wanted = [time for time in output_times(end, every) if time > now * (1 + 1e-12)]
        with progress(label="time", total=end, initial=now) as bar:
            for before, after in self._march(since, end):
                state, kept = after.state, []
                bar.update(max(state.time - bar.n, 0.0))
                while wanted and wanted[0] < state.time * (1 - 1e-12):
                    kept.append(self._between(before, after, wanted.pop(0)))
                due = bool(wanted) and wanted[0] <= state.time * (1 + 1e-12)
                if every is None or state.stopped or due:
                    wanted = wanted[1:]
                    kept.append(state)
                yield kept, after

    def beginning(self, state: State) -> Checkpoint:
        """A checkpoint at a state, with the length of a first step."""
        slope = self.slope(state)
        # the fastest rate, that of motion included
        rate = max(self.fastest(state), FIRST_MOVES * self._error(state, slope))
        return Checkpoint(state, slope, self.stepper.first_lengths(rate))

    def _march(self, checkpoint: Checkpoint, end: float) -> Iterator[tuple[Checkpoint, Checkpoint]]:
        """Accepted steps up to ``end``, or to the last sound shapes."""
        while not checkpoint.state.stopped and checkpoint.state.time < end * (1 - 1e-12):
            checkpoint = after = self._adapted(self._without_left(checkpoint))
            if not checkpoint.state.stopped:
                after = self._step_to(checkpoint, end)
            while after.state.steps == checkpoint.state.steps and self.points is not None:
                finer = self._moved_to(checkpoint, finer_state(checkpoint.state, self.points))
                if finer is checkpoint:
                    break
                checkpoint, after = finer, self._step_to(finer, end)
            yield checkpoint, after
            checkpoint = after

    def _step_to(self, checkpoint: Checkpoint, end: float) -> Checkpoint:
        """The next accepted checkpoint, not after ``end``."""
        return self._step(checkpoint, end - checkpoint.state.time, SMALLEST_STEP * end)

    def _adapted(self, checkpoint: Checkpoint) -> Checkpoint:
        """The checkpoint with the points that its droplets need: the same one if they have them."""
        if self.points is None:
            return checkpoint
        starts = [start for _, start in self._with_starts(checkpoint.state)]
        return self._moved_to(checkpoint, adapted_state(checkpoint, starts, self.points))

    def _moved_to(self, checkpoint: Checkpoint, state: State) -> Checkpoint:
        """The checkpoint with another state at the same time."""
        if state is checkpoint.state:
            return checkpoint
        if state.stopped:
            return replace(checkpoint, state=state)
        state = self._repaired(state, None)
        return replace(checkpoint, state=state, slope=self.slope(state))

    def _step(self, checkpoint: Checkpoint, longest: float, smallest: float) -> Checkpoint:
        """The next accepted checkpoint."""
        state, largest = checkpoint.state, self.fastest(checkpoint.state)
        relaxation = self._relaxation(state)
        lengths = bounded(checkpoint, relaxation.known)
        longest = min(longest, longest_step(checkpoint))
        evaluations = state.evaluations
        while True:
            implicit, length = self.stepper.choose(lengths, longest, largest)
            if length <= smallest:
                break
            rate, relaxing = _Rate(self, state, state.guess), relaxation.damping
            try:
                step = self.stepper.attempt(
                    rate, coordinates(state), checkpoint.slope, length, largest,
                    relaxing if implicit else None,
                )  # fmt: skip
                evaluations += step.evaluations
                errors = Errors(
                    self._error(state, step.error), relaxation.error(step.error, step.state)
                )
                accepted, lengths = self.stepper.next_lengths(
                    lengths, length, errors, step.power, implicit
                )
                if accepted:
                    old = replace(state, guess=rate.guess)
                    after = self._after(old, step, length, evaluations)
                    if not too_far(state, after):
                        return self._accept(old, after, step, lengths)
                    longest = length / 2
            except (ShapeError, ConditionError):
                longest = length / 4
        reason = (
            f"the time step fell below {smallest:.1e} at time {state.time:.6g}: a droplet breaks "
            "up, or bodies come too close; take more points"
        )
        return replace(checkpoint, state=replace(state, stopped=reason))

    def _relaxation(self, state: State) -> Relaxation:
        """How the bodies of a state relax."""
        return Relaxation(state, [start for _, start in self._with_starts(state)], self.motion)

    def _after(self, old: State, step: Step, length: float, evaluations: int) -> State:
        """The state that a step leads to, repaired."""
        bare = moved(old, step.state)
        drifts = [b.drift(start) for b, start in self._with_starts(bare)]
        return replace(
            self._repaired(bare, self.mesh), time=old.time + length, steps=old.steps + 1,
            evaluations=evaluations + self._needs_slope(step.slope), length=length,
            drift=max(drifts, key=abs),
        )  # fmt: skip

    def _needs_slope(self, slope: Array | None) -> bool:
        """Whether the slope at the end of a step is needed for the next step."""
        return slope is None or self.mesh is not None

    def _accept(self, old: State, after: State, step: Step, lengths: Lengths) -> Checkpoint:
        """The checkpoint after a step; the old one, stopped, if the new one is not valid.

        The state is made anew only where it changes: it has its gaps worked out.
        """
        reasons = [b.unresolved() for b in after.bodies]
        reasons += [self.contact.reason(gap) for gap in after.gaps]
        if any(reasons):
            stopped = f"{next(filter(None, reasons))}, at time {after.time:.6g}"
            return Checkpoint(replace(old, stopped=stopped), np.empty(0), lengths)
        if gone := leaving(after):
            left = old.left | gone
            last = all(n in left for n in after.numbers)
            after = replace(after, left=left, stopped="; ".join(left.values()) if last else "")
        slope = step.slope
        if slope is None or self._needs_slope(slope):
            slope = self.slope(after)
        return Checkpoint(after, slope, lengths, step.ends)

    def _without_left(self, checkpoint: Checkpoint) -> Checkpoint:
        """The checkpoint without bodies that have left."""
        state = checkpoint.state
        stay = [i for i, n in enumerate(state.numbers) if n not in state.left]
        if len(stay) == len(state.numbers):
            return checkpoint
        bodies = tuple(state.bodies[i] for i in stay)
        numbers = tuple(state.numbers[i] for i in stay)
        state = replace(state, bodies=bodies, numbers=numbers, guess=())
        return replace(checkpoint, state=state, slope=self.slope(state))

    def _with_starts(self, state: State) -> list[tuple[Body, Body]]:
        """Each body, and what it was at the beginning."""
        starts = [self.start.bodies[n - 1] for n in state.numbers]
        return list(zip(state.bodies, starts, strict=True))

    def _repaired(self, state: State, mesh: RelaxMesh | None) -> State:
        """The state with the right volumes, and points relaxed."""
        pairs = self._with_starts(state)
        bodies = tuple(b.repaired(start, self.volume, mesh) for b, start in pairs)
        return replace(state, bodies=bodies)

    def _error(self, state: State, change: Array) -> float:
        """Largest displacement of a body in a change of coordinates, relative to its size."""
        parts = np.split(change, ends(state))
        return max(b.error(part) for b, part in zip(state.bodies, parts, strict=True))

    def slope(self, state: State) -> Array:
        """Rate of change of all coordinates, flat."""
        pairs = zip(state.placed, state.responses, strict=True)
        return np.concatenate([p.rate(r, self.motion) for p, r in pairs])

    def fastest(self, state: State) -> float:
        """Rate at which the shortest waves that the points carry relax, at most."""
        return max(p.fastest(self.flow.viscosity) for p in state.placed)

    def _between(self, before: Checkpoint, after: Checkpoint, time: float) -> State:
        """The state at a time within a step."""
        flat = coordinates_between(before, after, time)
        return self._repaired(replace(moved(after.state, flat), time=time), None)


@dataclass(eq=False)
class _Rate:
    """The rate of a state's coordinates elsewhere; it remembers the latest unknowns as a guess."""

    simulation: Simulation
    state: State
    guess: tuple[Array, ...]

    def __call__(self, flat: Array) -> Array:
        state = replace(moved(self.state, flat), guess=self.guess)
        slope = self.simulation.slope(state)
        self.guess = tuple(np.ascontiguousarray(r.unknown) for r in state.responses)
        return slope
