"""The march in time: steps, what is repaired or chosen anew between them, and reasons to stop."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from cadbem.errors import ConditionError, ShapeError
from cadbem.spline.basis import Array
from cadbem.suspension.bodies.body import Body
from cadbem.suspension.interface.mesh import RelaxMesh
from cadbem.suspension.interface.motion import Motion
from cadbem.suspension.interface.volume import CorrectVolume
from cadbem.suspension.time.adapting import adapted_state, finer_state, with_elements
from cadbem.suspension.time.checkpoint import (
    Checkpoint,
    coordinates,
    coordinates_between,
    ends,
    moved,
)
from cadbem.suspension.time.choices import Choices
from cadbem.suspension.time.limits import bounded, leaving, longest_step, too_far
from cadbem.suspension.time.relaxation import Relaxation
from cadbem.suspension.time.state import State
from cadbem.suspension.time.stepping import Errors, Lengths, Step

SMALLEST_STEP = 1e-7  # share of the run below which a step has failed
FIRST_MOVES = 10.0  # the first step is a share of the time in which a body moves by its size


@dataclass(frozen=True, eq=False)
class March:
    """What leads from one state to the next: see ``Simulation``.

    ``starts`` are the bodies at the beginning, by their numbers from 1 on.
    """

    starts: Sequence[Body]
    choices: Choices
    motion: Motion
    volume: CorrectVolume | None
    mesh: RelaxMesh | None

    def beginning(self, state: State) -> Checkpoint:
        """A checkpoint at a state, with the length of a first step."""
        slope = self.slope(state)
        # the fastest rate, that of motion included
        rate = max(self.fastest(state), FIRST_MOVES * self._error(state, slope))
        return Checkpoint(state, slope, self.choices.stepper.first_lengths(rate))

    def to(self, checkpoint: Checkpoint, end: float) -> Iterator[tuple[Checkpoint, Checkpoint]]:
        """Accepted steps up to ``end``, or to the last sound shapes."""
        while not checkpoint.state.stopped and checkpoint.state.time < end * (1 - 1e-12):
            checkpoint = after = self._adapted(self._without_left(checkpoint))
            if not checkpoint.state.stopped:
                after = self._step_to(checkpoint, end)
            points = self.choices.points
            while after.state.steps == checkpoint.state.steps and points is not None:
                finer = self._moved_to(checkpoint, finer_state(checkpoint.state, points))
                if finer is checkpoint:
                    break
                checkpoint, after = finer, self._step_to(finer, end)
            yield checkpoint, after
            checkpoint = after

    def _step_to(self, checkpoint: Checkpoint, end: float) -> Checkpoint:
        """The next accepted checkpoint, not after ``end``."""
        return self._step(checkpoint, end - checkpoint.state.time, SMALLEST_STEP * end)

    def _adapted(self, checkpoint: Checkpoint) -> Checkpoint:
        """The checkpoint with the points and elements that its bodies need: the same one if they
        have them."""
        points, elements = self.choices.points, self.choices.elements
        if points is not None:
            starts = [start for _, start in self._with_starts(checkpoint.state)]
            checkpoint = self._moved_to(checkpoint, adapted_state(checkpoint, starts, points))
        if elements is None or checkpoint.state.stopped:
            return checkpoint
        state = with_elements(checkpoint.state, checkpoint.slope, elements)
        if state is checkpoint.state:
            return checkpoint
        return replace(checkpoint, state=state, slope=self.slope(state))

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
            implicit, length = self.choices.stepper.choose(lengths, longest, largest)
            if length <= smallest:
                break
            rate, relaxing = _Rate(self, state, state.guess), relaxation.damping
            try:
                step = self.choices.stepper.attempt(
                    rate, coordinates(state), checkpoint.slope, length, largest,
                    relaxing if implicit else None,
                )  # fmt: skip
                evaluations += step.evaluations
                errors = Errors(
                    self._error(state, step.error), relaxation.error(step.error, step.state)
                )
                accepted, lengths = self.choices.stepper.next_lengths(
                    lengths, length, errors, step.power, implicit
                )
                if accepted:
                    old = replace(state, guess=rate.guess)
                    after = self._after(old, step, length, evaluations, errors.whole)
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

    def _after(
        self, old: State, step: Step, length: float, evaluations: int, error: float
    ) -> State:
        """The state that a step leads to, repaired."""
        bare = moved(old, step.state)
        drifts = [b.drift(start) for b, start in self._with_starts(bare)]
        return replace(
            self._repaired(bare, self.mesh), time=old.time + length, steps=old.steps + 1,
            evaluations=evaluations + self._needs_slope(step.slope), length=length,
            error=error, drift=max(drifts, key=abs),
        )  # fmt: skip

    def _needs_slope(self, slope: Array | None) -> bool:
        """Whether the slope at the end of a step is needed for the next step."""
        return slope is None or self.mesh is not None

    def _accept(self, old: State, after: State, step: Step, lengths: Lengths) -> Checkpoint:
        """The checkpoint after a step; the old one, stopped, if the new one is not valid.

        The state is made anew only where it changes: it has its gaps worked out.
        """
        reasons = [b.unresolved() for b in after.bodies]
        reasons += [self.choices.contact.reason(gap) for gap in after.gaps]
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
        starts = [self.starts[n - 1] for n in state.numbers]
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
        return max(p.fastest(state.flow.viscosity) for p in state.placed)

    def between(self, before: Checkpoint, after: Checkpoint, time: float) -> State:
        """The state at a time within a step."""
        flat = coordinates_between(before, after, time)
        return self._repaired(replace(moved(after.state, flat), time=time), None)


@dataclass(eq=False)
class _Rate:
    """The rate of a state's coordinates elsewhere; it remembers the latest unknowns as a guess."""

    march: March
    state: State
    guess: tuple[Array, ...]

    def __call__(self, flat: Array) -> Array:
        state = replace(moved(self.state, flat), guess=self.guess)
        slope = self.march.slope(state)
        self.guess = tuple(np.ascontiguousarray(r.unknown) for r in state.responses)
        return slope
