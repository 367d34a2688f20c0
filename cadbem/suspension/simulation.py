"""Droplets moving in time: velocities, steps, repairs, and when to stop."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike
from tqdm import tqdm

from cadbem.closed_points import collocation_grid
from cadbem.errors import ConditionError, ShapeError
from cadbem.operators.closed import ClosedLayers, closed_operator
from cadbem.quadrature.closed import PolarRule, SelfRule
from cadbem.spline.basis import Array
from cadbem.spline.closed import ClosedSpline
from cadbem.suspension.droplet import Droplet
from cadbem.suspension.fields import velocity_at
from cadbem.suspension.measures import Measures, measure
from cadbem.suspension.mesh import RelaxMesh, stretches, unresolved
from cadbem.suspension.motion import Motion, affine_velocity
from cadbem.suspension.stepping import Adaptive, Step, Stepper
from cadbem.suspension.together import Response, Surroundings, respond_together
from cadbem.suspension.volume import CorrectVolume, volume

RATE_MARGIN = 1.15  # of the fastest relaxation: splines make short waves a little stiffer
SMALLEST_STEP = 1e-7  # share of the run below which a step has failed


@dataclass(frozen=True, eq=False)
class State:
    """The ``droplets`` at a ``time`` and how they got there: accepted ``steps`` and
    ``evaluations`` of the velocities so far, the ``length`` of the last step, and ``drift``, the
    largest relative error of a volume that it made, before correction.

    ``stopped`` is empty, or says why a run ended early.
    """

    simulation: Simulation
    time: float
    droplets: tuple[Droplet, ...]
    steps: int = 0
    evaluations: int = 0
    length: float = 0.0
    drift: float = 0.0
    stopped: str = ""

    @property
    def droplet(self) -> Droplet:
        """The first droplet, of most runs the only one."""
        return self.droplets[0]

    @cached_property
    def layers(self) -> list[ClosedLayers]:
        """Each interface's layers."""
        return [self.simulation.layers(d.shape) for d in self.droplets]

    @cached_property
    def responses(self) -> list[Response]:
        """The velocity of each interface and the traction jump across it."""
        return respond_together(self.simulation.flow, self.droplets, self.layers)

    @property
    def response(self) -> Response:
        """That of the first droplet."""
        return self.responses[0]

    def velocity_at(self, points: ArrayLike) -> Array:
        """Velocity (dim, M) of the fluids at points (dim, M) inside and outside the droplets."""
        return velocity_at(self.simulation.flow, self.droplets, self.layers, self.responses, points)

    @cached_property
    def measures(self) -> list[Measures]:
        """Deformation, inclination, volume, energies, mesh quality and more, of each droplet."""
        flow = self.simulation.flow
        return [
            measure(d.shape, r.velocity, r.jump, flow.background, flow.viscosity, d.viscosity_ratio)
            for d, r in zip(self.droplets, self.responses, strict=True)
        ]


@dataclass(frozen=True, eq=False)
class _Point:
    """A state with the slope of its coefficients (of all droplets, flat) there."""

    state: State
    slope: Array


@dataclass(frozen=True, eq=False)
class Simulation:
    """One droplet or several in a ``flow``, unbounded or in a channel.

    ``stepper`` advances in time; ``motion`` chooses how points move along the surface; ``volume``
    and ``mesh`` repair the shape after each step, or do not (None); ``rule`` integrates over the
    surface.
    """

    flow: Surroundings
    bodies: Droplet | Sequence[Droplet]
    stepper: Stepper = Adaptive()
    motion: Motion = affine_velocity
    volume: CorrectVolume | None = CorrectVolume()
    mesh: RelaxMesh | None = None
    rule: SelfRule = PolarRule()

    @cached_property
    def droplets(self) -> tuple[Droplet, ...]:
        """The droplets at the beginning."""
        return (self.bodies,) if isinstance(self.bodies, Droplet) else tuple(self.bodies)

    @property
    def droplet(self) -> Droplet:
        """The first droplet."""
        return self.droplets[0]

    def layers(self, shape: ClosedSpline) -> ClosedLayers:
        """Layers of a shape, integrated as finely as its stretch asks for.

        Raises ShapeError for a shape that is not finite, or folded.
        """
        low, high = stretches(collocation_grid(shape.basis).points(shape))
        if not np.isfinite(high).all() or not (low > 0).all():
            raise ShapeError("a droplet's shape has points that are not finite, or coincide")
        rule = self.rule.suited(float((high / low).max()))
        return ClosedLayers(closed_operator(shape.basis, rule), shape)

    def run(self, end: float, every: float | None = None) -> Iterator[State]:
        """States at time 0, at each multiple of ``every`` (or after each step), and at ``end``.

        A shape that can no longer be resolved ends the run early: the last state is the last
        sound one, and its ``stopped`` tells why.
        """
        if not end > 0 or every is not None and not every > 0:
            raise ShapeError(f"run(end={end}, every={every}): times must be positive")
        with tqdm(total=end, desc="time", delay=2.0, leave=False, disable=None) as bar:
            points = self._march(end)
            last = next(points)
            yield last.state
            wanted = _multiples(end, every)
            for point in points:
                bar.update(max(point.state.time - bar.n, 0.0))
                while wanted and wanted[0] < point.state.time * (1 - 1e-12):
                    yield self._between(last, point, wanted.pop(0))
                due = bool(wanted) and wanted[0] <= point.state.time * (1 + 1e-12)
                if every is None or point.state.stopped or due:
                    wanted = wanted[1:]
                    yield point.state
                last = point

    def _march(self, end: float) -> Iterator[_Point]:
        """Accepted steps up to ``end``, or to the last sound shapes."""
        state = State(self, 0.0, self.droplets)
        point = _Point(state, self._slope(state.droplets, state.layers))
        length = self.stepper.first_length(self.fastest(state))
        yield point
        while point.state.time < end * (1 - 1e-12):
            length = min(length, end - point.state.time)
            point, length = self._step(point, length, SMALLEST_STEP * end)
            yield point
            if point.state.stopped:
                return

    def _step(self, point: _Point, length: float, smallest: float) -> tuple[_Point, float]:
        """The next accepted point, and the length that the step after it may have."""
        state, largest = point.state, self.fastest(point.state)
        length, evaluations = min(length, self.stepper.bound(largest)), state.evaluations
        start = _flat([d.shape.coefficients for d in state.droplets])
        while length > smallest:
            try:
                step = self.stepper.attempt(self._rate, start, point.slope, length, largest)
            except (ShapeError, ConditionError):
                length /= 4
                continue
            evaluations += step.evaluations
            accepted, following = self.stepper.next_length(length, self._error(step.error))
            if accepted:
                return self._accept(point, step, length, evaluations), following
            length = following
        reason = (
            f"the time step fell below {smallest:.1e} at time {state.time:.6g}: a droplet breaks "
            "up, or its shape needs more points"
        )
        return replace(point, state=replace(state, stopped=reason)), length

    def _accept(self, point: _Point, step: Step, length: float, evaluations: int) -> _Point:
        """The point that a step leads to, repaired; the old one, stopped, if it is not sound."""
        old = point.state
        moved = self._moved(step.state)
        drifts = [volume(d.shape) / v - 1 for d, v in zip(moved, self._volumes, strict=True)]
        state = State(
            self, old.time + length, self._repaired(moved, relax=True), old.steps + 1,
            evaluations, length, max(drifts, key=abs),
        )  # fmt: skip
        for d in state.droplets:
            reason = unresolved(collocation_grid(d.shape.basis).points(d.shape))
            if reason:
                stopped = f"{reason}, at time {state.time:.6g}"
                return replace(point, state=replace(old, stopped=stopped))
        if step.slope is None or self.mesh is not None:
            state = replace(state, evaluations=evaluations + 1)
            return _Point(state, self._slope(state.droplets, state.layers))
        return _Point(state, step.slope)

    def _repaired(self, droplets: Sequence[Droplet], relax: bool) -> tuple[Droplet, ...]:
        """Droplets with the right volume, and their points relaxed."""
        repaired = []
        for d, target in zip(droplets, self._volumes, strict=True):
            shape = d.shape if self.volume is None else self.volume.apply(d.shape, target)
            if relax and self.mesh is not None:
                shape = self.mesh.relaxed(shape, d.viscosity_ratio)
            repaired.append(d.moved(shape))
        return tuple(repaired)

    @cached_property
    def _volumes(self) -> list[float]:
        return [volume(d.shape) for d in self.droplets]

    def _moved(self, flat: Array) -> tuple[Droplet, ...]:
        """The droplets with the coefficients of a flat array."""
        shapes = [d.shape.coefficients.shape for d in self.droplets]
        parts = np.split(flat, np.cumsum([np.prod(s) for s in shapes])[:-1].astype(int))
        return tuple(
            d.moved(replace(d.shape, coefficients=part.reshape(shape)))
            for d, part, shape in zip(self.droplets, parts, shapes, strict=True)
        )

    def _error(self, flat: Array) -> float:
        """Largest error of a point, relative to its droplet's size."""
        shares = [
            float(np.linalg.norm(d.shape.coefficients, axis=0).max()) / v ** (1 / d.shape.dimension)
            for d, v in zip(self._moved(flat), self._volumes, strict=True)
        ]
        return max(shares)

    def _slope(self, droplets: Sequence[Droplet], layers: Sequence[ClosedLayers]) -> Array:
        """Rate of change of all coefficients, flat."""
        responses = respond_together(self.flow, droplets, layers)
        pairs = zip(layers, responses, strict=True)
        return _flat([self.motion(of, r.velocity) for of, r in pairs])

    def _rate(self, flat: Array) -> Array:
        """Rate of change of a flat array of coefficients; ShapeError if it cannot be told."""
        droplets = self._moved(flat)
        return self._slope(droplets, [self.layers(d.shape) for d in droplets])

    def fastest(self, state: State) -> float:
        """Rate at which the shortest waves that the points carry relax, at most.

        A wave of number k on a flat interface decays at stiffness(k) / (2 μ (1 + λ) k).
        """
        rates = []
        for d, of in zip(state.droplets, state.layers, strict=True):
            low, high = stretches(of.targets)
            across = 1 / low if d.shape.dimension == 2 else np.hypot(1 / low, 1 / high)
            wave_number = d.shape.basis.shape[-1] / 2 * float(across.max())
            viscosities = self.flow.viscosity * (1 + d.viscosity_ratio)
            rates.append(d.interface.stiffness(wave_number) / (2 * viscosities * wave_number))
        return RATE_MARGIN * max(rates)

    def _between(self, before: _Point, after: _Point, time: float) -> State:
        """The state at a time within a step, by cubic Hermite interpolation."""
        start, end = before.state, after.state
        length = end.time - start.time
        s = (time - start.time) / length
        x0, x1 = (_flat([d.shape.coefficients for d in x.droplets]) for x in (start, end))
        flat = (
            (1 + 2 * s) * (1 - s) ** 2 * x0
            + s**2 * (3 - 2 * s) * x1
            + length * s * (1 - s) * ((1 - s) * before.slope - s * after.slope)
        )
        return replace(end, time=time, droplets=self._repaired(self._moved(flat), relax=False))


def _flat(arrays: Sequence[Array]) -> Array:
    return np.concatenate([a.ravel() for a in arrays])


def _multiples(end: float, every: float | None) -> list[float]:
    if every is None:
        return []
    count = int(np.floor(end / every * (1 + 1e-12)))
    times = [every * k for k in range(1, count + 1)]
    return times if times and times[-1] > end * (1 - 1e-9) else [*times, end]
