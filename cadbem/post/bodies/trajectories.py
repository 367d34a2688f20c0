"""Paths of bodies on the plan of a channel."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from cadbem.boundary import Boundary
from cadbem.errors import CadbemError, ShapeError
from cadbem.post.bodies.bodies import body_colour
from cadbem.post.fields.frames import spread_points
from cadbem.post.files.export import prepared
from cadbem.post.plane.plane import add_legend, add_plan, add_plane_channel, plane_figure
from cadbem.post.style.layout import Size, axes_by_length, check_size
from cadbem.post.style.style import BACKGROUND, length_unit
from cadbem.spline.basis import Array
from cadbem.units import UnitNames


def draw_trajectories(
    path: str | Path,
    channel: Boundary | None,
    tracks: Mapping[str | int, ArrayLike],
    *,
    units: UnitNames | None = None,
    size: Size = (1500, 1200),
) -> Path:
    """Picture of paths (dim, N), by label, from open to filled circles, on the channel's plan.

    In space one looks along the shortest axis of the channel, or of the paths without one.  A
    path whose label is a body's number has that body's colour in ``draw_movie``.  ``size`` is the
    largest one, in pixels.  Raises ``CadbemError`` when there is no path, ``ShapeError`` when
    paths and channel are not in the same dimension.
    """
    check_size(size)
    paths = {label: np.asarray(track, dtype=float) for label, track in tracks.items()}
    extent = extent_of_paths(channel, list(paths.values()))
    widest = extent if channel is None else spread_points(channel)
    shown = sorted(axes_by_length(widest)[:2]) if len(extent) == 3 else [0, 1]
    unit, names = length_unit(channel, units), "".join("xyz"[k] for k in shown)
    figure, (axes,) = plane_figure(extent[shown], unit, size, names=names)
    if channel is not None and channel.dimension == 2:
        add_plane_channel(axes, channel)
    elif channel is not None:
        add_plan(axes, channel, shown)
    lines = []
    for place, (label, track) in enumerate(paths.items()):
        colour = body_colour(label if isinstance(label, int) else place)
        name = f"body {label}" if isinstance(label, int) else label
        x, y = track[shown]
        lines += axes.plot(x, y, color=colour, linewidth=1.8, label=name, zorder=3)
        for end, fill in ((0, BACKGROUND), (-1, colour)):
            axes.plot(x[end], y[end], "o", color=colour, markerfacecolor=fill, zorder=4)
    axes.set_title("open circles: start, filled: end", loc="right", fontsize="small")
    add_legend(figure, lines)
    figure.savefig(target := prepared(path))
    return target


def extent_of_paths(channel: Boundary | None, paths: Sequence[Array]) -> Array:
    """Points (dim, N) of all paths and of the channel."""
    if not paths:
        raise CadbemError("no trajectories to draw: give at least one path of positions (dim, N)")
    found = [*paths] if channel is None else [*paths, spread_points(channel)]
    if len({len(points) for points in found}) > 1:
        raise ShapeError("trajectories and channel must all be in 2D or all in 3D to be drawn")
    return np.concatenate(found, axis=1)
