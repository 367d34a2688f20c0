"""Points of droplets, and elements of walls and particles, chosen anew between two steps."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from cadbem.spline.basis import Array
from cadbem.suspension.bodies.body import Body
from cadbem.suspension.bodies.droplet import Droplet, PlacedDroplet
from cadbem.suspension.bodies.particle import PlacedParticle
from cadbem.suspension.interface.points import AdaptivePoints
from cadbem.suspension.multibody.elements import AdaptiveElements, Cloud
from cadbem.suspension.surroundings.channel_flow import ChannelFlow
from cadbem.suspension.time.checkpoint import Checkpoint, ends
from cadbem.suspension.time.state import State


def adapted_state(checkpoint: Checkpoint, starts: Sequence[Body], points: AdaptivePoints) -> State:
    """The state of a checkpoint, droplets with the points that they need: the same state if they
    have them, a stopped one if they cannot have them.

    What they need follows from their shapes, from the slope, which is at hand, and from their
    gaps; points are taken away down to the number of the bodies' ``starts``.
    """
    state, reasons = checkpoint.state, []
    bodies: list[Body] = list(state.bodies)
    slopes = np.split(checkpoint.slope, ends(state))
    for i, placed in enumerate(state.placed):
        start, gap = starts[i], state.gaps[i]
        if isinstance(placed, PlacedDroplet) and isinstance(start, Droplet):
            shape = placed.body.shape
            rate = slopes[i].reshape(shape.coefficients.shape)
            found = placed.resolution(rate, state.flow.viscosity)
            allowed = points.allowed(placed.body.size, gap.length)
            travel = rate.reshape(len(rate), -1).mean(axis=1)
            new = points.adapted(shape, found, allowed, start.shape.basis.count, travel)
            if new is not shape:
                bodies[i] = placed.body.moved(new)
            elif reason := points.reason(found, allowed, shape.basis.count):
                reasons.append(f"body {gap.body}: {reason}, at time {state.time:.6g}")
    if reasons:
        return replace(state, stopped=reasons[0])
    return _with_bodies(state, bodies)


def finer_state(state: State, points: AdaptivePoints) -> State:
    """The state with more points on its droplets, to go on from: the same one if there may not be
    more."""
    bodies: list[Body] = list(state.bodies)
    for i, body in enumerate(state.bodies):
        if isinstance(body, Droplet) and (shape := points.finer(body.shape)) is not body.shape:
            bodies[i] = body.moved(shape)
    finer = _with_bodies(state, bodies)
    return finer if finer is state else replace(finer, stopped="")


def with_elements(state: State, slope: Array | None, elements: AdaptiveElements) -> State:
    """The state on elements of walls and particles that suit its bodies: the same one if its own
    do.  Its bodies go on with a ``slope`` of their coordinates, if that is known."""
    clouds = [Cloud.of(p, b.size) for p, b in zip(state.placed, state.bodies, strict=True)]
    rates = [np.zeros_like(b.coordinates) for b in state.bodies]
    if slope is not None:
        rates = np.split(slope, ends(state))
    velocities = [b.shift(rate) for b, rate in zip(state.bodies, rates, strict=True)]
    flow = elements.flow(state.flow, clouds, velocities)
    bodies: list[Body] = list(state.bodies)
    for i, placed in enumerate(state.placed):
        if isinstance(placed, PlacedParticle):
            bodies[i] = elements.particle(i, placed, flow, clouds)
    same = all(new is old for new, old in zip(bodies, state.bodies, strict=True))
    guess = state.guess if same else ()
    if flow is not state.flow:
        if isinstance(state.flow, ChannelFlow):
            state.flow.forget()  # states that are kept hold on to it
        environment = replace(state.environment, flow=flow)
        state = replace(state, environment=environment)
    elif same:
        return state
    count = state.evaluations + (slope is not None)
    return replace(state, bodies=tuple(bodies), guess=guess, evaluations=count)


def _with_bodies(state: State, bodies: Sequence[Body]) -> State:
    if all(new is old for new, old in zip(bodies, state.bodies, strict=True)):
        return state
    return replace(state, bodies=tuple(bodies), guess=(), evaluations=state.evaluations + 1)
