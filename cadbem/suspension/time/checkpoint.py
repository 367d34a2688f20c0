"""A checkpoint, from which a run continues, and the coordinates of all bodies in one array."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from cadbem.spline.basis import Array
from cadbem.suspension.time.state import State
from cadbem.suspension.time.stepping import Lengths


@dataclass(frozen=True, eq=False)
class Checkpoint:
    """A ``state`` with the ``slope`` of its coordinates, flat, and the ``lengths`` that the next
    step may have.

    ``ends`` are slopes at both ends of the step that led here, for states between them, if not
    those of the checkpoints; nothing later needs them.
    """

    state: State
    slope: Array
    lengths: Lengths
    ends: tuple[Array, Array] | None = None


def coordinates(state: State) -> Array:
    """The coordinates of all bodies, flat."""
    return np.concatenate([b.coordinates for b in state.bodies])


def ends(state: State) -> Array:
    """Where one body's coordinates end and the next one's begin."""
    return np.cumsum([b.coordinates.size for b in state.bodies])[:-1]


def moved(state: State, flat: Array) -> State:
    """The state with the coordinates of a flat array."""
    parts = np.split(flat, ends(state))
    bodies = [b.at(part) for b, part in zip(state.bodies, parts, strict=True)]
    return replace(state, bodies=tuple(bodies))


def coordinates_between(before: Checkpoint, after: Checkpoint, time: float) -> Array:
    """Coordinates of all bodies at a time within a step, by cubic Hermite interpolation."""
    first, last = after.ends or (before.slope, after.slope)
    length = after.state.time - before.state.time
    s = (time - before.state.time) / length
    return (
        (1 + 2 * s) * (1 - s) ** 2 * coordinates(before.state)
        + s**2 * (3 - 2 * s) * coordinates(after.state)
        + length * s * (1 - s) * ((1 - s) * first - s * last)
    )
