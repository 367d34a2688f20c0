"""Frames, the form in which pictures receive bodies at one time, and the extent of frames."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import product

import numpy as np

from cadbem.boundary import Boundary
from cadbem.errors import CadbemError, ShapeError
from cadbem.post.fields.cells import between
from cadbem.spline.basis import Array
from cadbem.spline.closed import ClosedSpline

Shape = ClosedSpline | Boundary
SPREAD = 4  # points a direction in each element, for the extent of things


@dataclass(frozen=True, eq=False)
class Frame:
    """Bodies at a ``time``, by number: droplets are closed splines, rigid particles boundaries.

    A number stands for one body in all frames, and for its colour; bodies may come and go.
    ``fields`` has fields on bodies by number and name, such as "velocity": coefficients (dim,
    *shape) or (*shape) of a droplet's spline, (dim, F) or (F,) of the functions on a particle.
    """

    time: float
    shapes: Mapping[int, Shape]
    fields: Mapping[int, Mapping[str, Array]] = field(default_factory=dict)


def require_frames(channel: Boundary | None, frames: Sequence[Frame]) -> int:
    """Dimension of space, the same for the channel and all bodies.

    Raises ``CadbemError`` when there is nothing to draw, ``ShapeError`` for two dimensions.
    """
    found = {} if channel is None else {channel.dimension: "the channel"}
    for frame in frames:
        for number, shape in frame.shapes.items():
            found.setdefault(shape.dimension, f"body {number} at t = {frame.time:g}")
    if not frames or not found:
        raise CadbemError("nothing to draw: give at least one frame, and a channel or a body")
    if len(found) > 1:
        raise ShapeError(
            f"{found[2]} is in 2D, {found[3]} in 3D: draw them in pictures of their own"
        )
    return next(iter(found))


def extent_of(channel: Boundary | None, frames: Sequence[Frame]) -> Array:
    """Points (dim, N) spread over everything at all times, the outermost ones of each frame."""
    points = [] if channel is None else [spread_points(channel)]
    for frame in frames:
        if frame.shapes:
            shapes = [spread_points(shape) for shape in frame.shapes.values()]
            points.append(_outermost(np.concatenate(shapes, axis=1)))
    return np.concatenate(points, axis=1)


def _outermost(points: Array) -> Array:
    """The points among (dim, N) that are farthest along axes and diagonals."""
    directions = np.array(list(product((-1.0, 0.0, 1.0), repeat=len(points))))
    return points[:, np.unique((directions @ points).argmax(axis=1))]


def spread_points(shape: Shape) -> Array:
    """Points (dim, N) spread over a body or a channel."""
    if isinstance(shape, ClosedSpline):
        return shape.points()
    points = []
    for patch in shape.patches:
        lines = [between(patch.surface.breaks(d), SPREAD) for d in range(shape.dimension - 1)]
        lattice = np.meshgrid(*lines, indexing="ij")
        points.append(patch.surface.evaluate(*[g.ravel() for g in lattice]))
    return np.concatenate(points, axis=1)


def time_labels(frames: Sequence[Frame], unit: str = "") -> list[str]:
    """The frames' times with as many decimals as give the longest time three digits."""
    longest = max(abs(frame.time) for frame in frames)
    decimals = int(np.clip(2 - np.floor(np.log10(longest)), 0, 9)) if longest else 0
    return [f"t = {frame.time:.{decimals}f} {unit}".rstrip() for frame in frames]
