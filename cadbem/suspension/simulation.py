"""Droplets moving in time: velocities, steps, repairs, and when to stop."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike
from tqdm import tqdm

from cadbem.closed_points import ClosedPoints, collocation_grid
from cadbem.errors import ShapeError
from cadbem.operators.closed import ClosedLayers, closed_operator
from cadbem.quadrature.closed import PolarRule, SelfRule
from cadbem.spline.basis import Array
from cadbem.spline.closed import ClosedSpline
from cadbem.suspension.droplet import Droplet
from cadbem.suspension.fields import velocity_at
from cadbem.suspension.free_flow import FreeFlow
from cadbem.suspension.measures import Measures, measure
from cadbem.suspension.mesh import RelaxMesh, stretches, turning
from cadbem.suspension.motion import Motion, affine_velocity
from cadbem.suspension.stepping import Adaptive, Rate, Step, Stepper
from cadbem.suspension.together import Response
from cadbem.suspension.volume import CorrectVolume, volume

TURN_LIMIT = 75.0  # degrees between neighbouring normals from which a shape is not resolved
RATE_MARGIN = 1.15  # of the fastest relaxation: splines make short waves a little stiffer
SMALLEST_STEP = 1e-7  # share of the run below which a step has failed


@dataclass(frozen=True, eq=False)
class State:
    """A ``droplet`` at a ``time`` and how it got there: accepted ``steps`` and ``evaluations`` of
    the velocity so far, the ``length`` of the last step, and ``drift``, the relative error of the
    volume that it made, before correction.

    ``stopped`` is empty, or says why a run ended early.
    """

    simulation: Simulation
    time: float
    droplet: Droplet
    steps: int = 0
    evaluations: int = 0
    length: float = 0.0
    drift: float = 0.0
    stopped: str = ""

    @cached_property
    def layers(self) -> ClosedLayers:
        """The interface's layers."""
        return self.simulation.layers(self.droplet.shape)

    @cached_property
    def response(self) -> Response:
        """The fluid's velocity on the interface and the traction jump."""
        return self.simulation.flow.respond(self.droplet, self.layers)

    def velocity_at(self, points: ArrayLike) -> Array:
        """Velocity (dim, M) of the fluids at points (dim, M) inside and outside."""
        flow = self.simulation.flow
        return velocity_at(flow, self.droplet, self.layers, self.response, points)

    @cached_property
    def measures(self) -> Measures:
        """Deformation, inclination, volume, energies, mesh quality and more."""
        flow, response = self.simulation.flow, self.response
        return measure(
            self.droplet.shape, response.velocity, response.jump, flow.background,
            flow.viscosity, self.droplet.viscosity_ratio,
        )  # fmt: skip


@dataclass(frozen=True, eq=False)
class _Point:
    """A state with the slope of its coefficients there."""

    state: State
    slope: Array


@dataclass(frozen=True, eq=False)
class Simulation:
    """A ``droplet`` in a ``flow``.

    ``stepper`` advances in time; ``motion`` chooses how points move along the surface; ``volume``
    and ``mesh`` repair the shape after each step, or do not (None); ``rule`` integrates over the
    surface.
    """

    flow: FreeFlow
    droplet: Droplet
    stepper: Stepper = Adaptive()
    motion: Motion = affine_velocity
    volume: CorrectVolume | None = CorrectVolume()
    mesh: RelaxMesh | None = None
    rule: SelfRule = PolarRule(1e-5)

    def layers(self, shape: ClosedSpline) -> ClosedLayers:
        """Layers of a shape, integrated as finely as its stretch asks for."""
        points = collocation_grid(shape.basis).points(shape)
        low, high = stretches(points)
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
                if (
                    every is None
                    or point.state.stopped
                    or wanted
                    and wanted[0] <= (point.state.time * (1 + 1e-12))
                ):
                    wanted = wanted[1:]
                    yield point.state
                last = point

    def _march(self, end: float) -> Iterator[_Point]:
        """Accepted steps up to ``end``, or to the last sound shape."""
        state = State(self, 0.0, self.droplet)
        point = _Point(state, self._slope(state.layers))
        length = self.stepper.first_length(self.fastest(state.layers.targets))
        yield point
        while point.state.time < end * (1 - 1e-12):
            length = min(length, end - point.state.time)
            point, length = self._step(point, length, SMALLEST_STEP * end)
            yield point
            if point.state.stopped:
                return

    def _step(self, point: _Point, length: float, smallest: float) -> tuple[_Point, float]:
        """The next accepted point, and the length that the step after it may have."""
        state, shape = point.state, point.state.droplet.shape
        largest = self.fastest(state.layers.targets)
        length, evaluations = min(length, self.stepper.bound(largest)), state.evaluations
        while length > smallest:
            try:
                step = self.stepper.attempt(
                    self._rate(shape), shape.coefficients, point.slope, length, largest
                )
            except ShapeError:
                length /= 4
                continue
            evaluations += step.evaluations
            error = float(np.linalg.norm(step.error, axis=0).max()) / self._size
            accepted, following = self.stepper.next_length(length, error)
            if accepted:
                return self._accept(point, step, length, evaluations), following
            length = following
        reason = (
            f"the time step fell below {smallest:.1e} at time {state.time:.6g}: the droplet breaks "
            "up, or its shape needs more points"
        )
        return replace(point, state=replace(state, stopped=reason)), length

    def _accept(self, point: _Point, step: Step, length: float, evaluations: int) -> _Point:
        """The point that a step leads to, repaired; the old one, stopped, if it is not sound."""
        old = point.state
        shape = replace(old.droplet.shape, coefficients=step.state)
        drift = volume(shape) / self._volume - 1
        if self.volume is not None:
            shape = self.volume.apply(shape, self._volume)
        if self.mesh is not None:
            shape = self.mesh.relaxed(shape, old.droplet.viscosity_ratio)
        state = State(
            self, old.time + length, old.droplet.moved(shape), old.steps + 1, evaluations, length,
            drift,
        )  # fmt: skip
        reason = unresolved(state.layers.targets)
        if reason:
            return replace(point, state=replace(old, stopped=f"{reason}, at time {state.time:.6g}"))
        if step.slope is None or self.mesh is not None:
            state = replace(state, evaluations=evaluations + 1)
            return _Point(state, self._slope(state.layers))
        return _Point(state, step.slope)

    @cached_property
    def _volume(self) -> float:
        return volume(self.droplet.shape)

    @cached_property
    def _size(self) -> float:
        """Side of a cube as large as the droplet."""
        return self._volume ** (1 / self.droplet.shape.dimension)

    def _slope(self, layers: ClosedLayers) -> Array:
        """Rate of change of the coefficients."""
        droplet = self.droplet.moved(layers.spline)
        return self.motion(layers, self.flow.respond(droplet, layers).velocity)

    def _rate(self, shape: ClosedSpline) -> Rate:
        """Rates of shapes on the way; ShapeError for one that cannot be evaluated."""

        def rate(coefficients: Array) -> Array:
            return self._slope(self.layers(replace(shape, coefficients=coefficients)))

        return rate

    def fastest(self, points: ClosedPoints) -> float:
        """Rate at which the shortest waves that the points carry relax, at most.

        A wave of number k on a flat interface decays at stiffness(k) / (2 μ (1 + λ) k).
        """
        low, high = stretches(points)
        across = 1 / low if len(points.position) == 2 else np.hypot(1 / low, 1 / high)
        wave_number = points.grid.basis.shape[-1] / 2 * float(across.max())
        stiffness = self.droplet.interface.stiffness(wave_number)
        ratio = self.droplet.viscosity_ratio
        return RATE_MARGIN * stiffness / (2 * self.flow.viscosity * (1 + ratio) * wave_number)

    def _between(self, before: _Point, after: _Point, time: float) -> State:
        """The state at a time within a step, by cubic Hermite interpolation."""
        start, end = before.state, after.state
        length = end.time - start.time
        s = (time - start.time) / length
        x0, x1 = start.droplet.shape.coefficients, end.droplet.shape.coefficients
        coefficients = (
            (1 + 2 * s) * (1 - s) ** 2 * x0
            + s**2 * (3 - 2 * s) * x1
            + length * s * (1 - s) * ((1 - s) * before.slope - s * after.slope)
        )
        shape = replace(start.droplet.shape, coefficients=coefficients)
        if self.volume is not None:
            shape = self.volume.apply(shape, self._volume)
        return replace(end, time=time, droplet=start.droplet.moved(shape))


def unresolved(points: ClosedPoints) -> str:
    """Why a shape cannot be trusted any more, or nothing."""
    turn = turning(points)
    if turn.max() <= TURN_LIMIT:
        return ""
    place = ", ".join(f"{x:.3g}" for x in points.position[:, int(turn.argmax())])
    return (
        f"the surface turns by {turn.max():.0f} degrees between neighbouring points near "
        f"({place}): a neck or a tip thinner than the points resolve; take more points to go on"
    )


def _multiples(end: float, every: float | None) -> list[float]:
    if every is None:
        return []
    count = int(np.floor(end / every * (1 + 1e-12)))
    times = [every * k for k in range(1, count + 1)]
    return times if times and times[-1] > end * (1 - 1e-9) else [*times, end]
