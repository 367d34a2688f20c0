"""The simulation of bodies in time: velocities, steps, corrections, and reasons to stop."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

from cadbem.operators.far.equivalent import FarField
from cadbem.progress import progress
from cadbem.quadrature.closed import PolarRule, SelfRule
from cadbem.suspension.bodies.accurate import accurate_body
from cadbem.suspension.bodies.body import Body
from cadbem.suspension.bodies.droplet import Droplet
from cadbem.suspension.interface.mesh import RelaxMesh
from cadbem.suspension.interface.motion import Motion, affine_velocity
from cadbem.suspension.interface.points import AdaptivePoints
from cadbem.suspension.interface.volume import CorrectVolume
from cadbem.suspension.multibody.contact import Contact, check_start
from cadbem.suspension.multibody.environment import Environment
from cadbem.suspension.surroundings.channel_flow import ChannelFlow
from cadbem.suspension.surroundings.surroundings import Surroundings
from cadbem.suspension.time.accuracy import Watch
from cadbem.suspension.time.adapting import with_elements
from cadbem.suspension.time.checkpoint import Checkpoint
from cadbem.suspension.time.choices import Choices, choices
from cadbem.suspension.time.inputs import check_parts, check_times
from cadbem.suspension.time.limits import output_times
from cadbem.suspension.time.march import March
from cadbem.suspension.time.overview import simulation_overview
from cadbem.suspension.time.state import State
from cadbem.suspension.time.stepping import Stepper


@dataclass(frozen=True, eq=False)
class Simulation:
    """One body or several, droplets and rigid particles, in a ``flow``, unbounded or in a channel.

    With an ``accuracy``, such as 1e-3, the program chooses what makes results about as accurate,
    relative to the bodies' sizes: the channel's elements, which become small near bodies; those of
    particles near others; the points of droplets; and the steps.  The channel's problem is then
    given with its patches as they were read.

    ``stepper`` advances in time; ``motion`` chooses how points move along droplets; ``volume`` and
    ``mesh`` repair their shapes after each step, or do not (None); ``rule`` integrates over them;
    ``contact`` is the rule for narrow gaps; ``far`` are the equivalent sources of distant bodies
    (None: direct sums); ``points`` chooses the points of droplets anew.  Of these, ``stepper``,
    ``contact`` and ``points`` follow from the accuracy if they are left out; without it they are
    ``Adaptive()``, ``StopAtGap()``, and points that stay.  Bodies that reach an opening of the
    channel have left and are taken out; the run ends with the last.
    """

    flow: Surroundings
    bodies: Body | Sequence[Body]
    stepper: Stepper | None = None
    motion: Motion = affine_velocity
    volume: CorrectVolume | None = CorrectVolume()
    mesh: RelaxMesh | None = None
    rule: SelfRule = PolarRule()
    contact: Contact | None = None
    far: FarField | None = FarField()
    points: AdaptivePoints | None = None
    accuracy: float | None = None

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
        if self.accuracy is not None:
            bodies = tuple(accurate_body(b, self.accuracy) for b in bodies)
        return State(self.environment, 0.0, bodies, tuple(range(1, len(bodies) + 1)))

    @property
    def droplet(self) -> Droplet:
        """The first droplet at the beginning."""
        return self.start.droplet

    @cached_property
    def choices(self) -> Choices:
        """What is given or goes with the accuracy."""
        return choices(self.accuracy, self.stepper, self.contact, self.points)

    @cached_property
    def environment(self) -> Environment:
        """The surroundings and rules at the beginning of the run."""
        flow = self.flow
        if self.accuracy is not None and isinstance(flow, ChannelFlow):
            flow = flow.with_accuracy(self.accuracy)
        return Environment(flow, self.rule, self.choices.contact, self.far)

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
            check_start(self.environment.flow, self.start.placed, self.start.numbers)
            since = self.march.beginning(self._first_state())
            yield [since.state], since
        watch = Watch(self.accuracy)
        watch.look(since.state)
        now = since.state.time
        wanted = [time for time in output_times(end, every) if time > now * (1 + 1e-12)]
        with progress(label="time", total=end, initial=now) as bar:
            for before, after in self.march.to(since, end):
                state, kept = after.state, []
                watch.look(state)
                bar.update(max(state.time - bar.n, 0.0))
                while wanted and wanted[0] < state.time * (1 - 1e-12):
                    kept.append(self.march.between(before, after, wanted.pop(0)))
                due = bool(wanted) and wanted[0] <= state.time * (1 + 1e-12)
                if every is None or state.stopped or due:
                    wanted = wanted[1:]
                    kept.append(state)
                yield kept, after

    def _first_state(self) -> State:
        """The state at time 0, with elements that suit its bodies."""
        if self.choices.elements is None:
            return self.start
        return with_elements(self.start, None, self.choices.elements)

    @cached_property
    def march(self) -> March:
        """What leads from one state to the next."""
        bodies = self.start.bodies
        return March(bodies, self.choices, self.motion, self.volume, self.mesh)
