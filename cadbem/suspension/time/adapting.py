"""Bodies whose points are chosen anew between two steps."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from cadbem.suspension.bodies.body import Body
from cadbem.suspension.bodies.droplet import Droplet, PlacedDroplet
from cadbem.suspension.interface.points import AdaptivePoints
from cadbem.suspension.time.checkpoint import Checkpoint, ends
from cadbem.suspension.time.state import State


def adapted_bodies(
    checkpoint: Checkpoint, starts: Sequence[Body], points: AdaptivePoints
) -> tuple[Body, ...]:
    """The bodies of a checkpoint, droplets with the points that they need: those whose points are
    right already are the same values.

    What they need follows from their shapes, from the slope, which is at hand, and from their
    gaps; points are taken away down to the number of the bodies' ``starts``.
    """
    state = checkpoint.state
    slopes = np.split(checkpoint.slope, ends(state))
    bodies: list[Body] = []
    for placed, slope, start, gap in zip(state.placed, slopes, starts, state.gaps, strict=True):
        body = state.bodies[len(bodies)]
        if isinstance(placed, PlacedDroplet) and isinstance(start, Droplet):
            allowed = points.allowed(placed.body.size, gap.length)
            rate = slope.reshape(placed.body.shape.coefficients.shape)
            found = placed.resolution(rate, state.flow.viscosity)
            fewest = start.shape.basis.count
            travel = rate.reshape(len(rate), -1).mean(axis=1)
            shape = points.adapted(placed.body.shape, found, allowed, fewest, travel)
            body = body if shape is placed.body.shape else placed.body.moved(shape)
        bodies.append(body)
    return tuple(bodies)


def finer_bodies(state: State, points: AdaptivePoints) -> tuple[Body, ...]:
    """The bodies of a state, droplets with more points, as far as there may be more."""
    bodies: list[Body] = []
    for body in state.bodies:
        if isinstance(body, Droplet):
            shape = points.finer(body.shape)
            body = body if shape is body.shape else body.moved(shape)
        bodies.append(body)
    return tuple(bodies)
