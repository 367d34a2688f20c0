"""Paths in a channel as tubes: of tracers and bodies, coloured by speed or by time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from cadbem.boundary import Boundary
from cadbem.errors import ShapeError
from cadbem.post.bodies.bodies import body_colour
from cadbem.post.bodies.trajectories import extent_of_paths
from cadbem.post.files.export import prepared
from cadbem.post.plane.plane import add_colour_bar, add_plane_channel, plane_figure
from cadbem.post.scene.glass import add_channel
from cadbem.post.scene.openings import add_openings
from cadbem.post.style.display import load_pyvista
from cadbem.post.style.layout import (
    Size,
    View,
    add_axes,
    aim,
    check_size,
    corner_view,
    panel,
    plan_view,
    sheet,
    strip,
)
from cadbem.post.style.style import (
    COLOUR_MAP,
    SMALL,
    UnitNames,
    add_text,
    colour_bar,
    colour_limits,
    length_unit,
    quantity_label,
    sample_of,
    scaled,
    size_label,
)
from cadbem.spline.basis import Array

Limits = tuple[float, float]
THICK = 0.004  # radius of tubes, as a share of the channel's diagonal
CROWD = 40  # paths from which on tubes are thinner
AXES_ROOM = (0.1, 0.0)


def draw_paths(
    path: str | Path,
    channel: Boundary | None,
    paths: Sequence[ArrayLike],
    *,
    values: Sequence[ArrayLike] | None = None,
    label: str = "",
    units: UnitNames | None = None,
    size: Size = (1800, 1000),
) -> Path:
    """Picture of paths (dim, n) as tubes in a channel, from the widest side and from a corner; as
    lines in a plane.

    ``values`` (n,) along each path give colours between their extremes, on a colour bar called
    ``label`` ("speed" and "time" get their units from ``units``); without them each path has a
    colour of its own.  Points that are not finite are left out.  Raises ``ShapeError`` without
    paths, for paths and channel in different dimensions, and for values not as many as points.
    """
    check_size(size)
    extent, tracks, scalars = _checked(channel, paths, values)
    look = _Look.of(channel, scalars, label, units)
    if len(extent) == 2:
        figure = _draw_plane(channel, tracks, scalars, look, size)
        figure.savefig(target := prepared(path))
        return target
    tubes = _tubes(tracks, scalars, extent)
    views = plan_view(extent), corner_view(extent)
    with sheet(path, size, 2, views[0].aspect(extent)) as plotter:
        for i, view in enumerate(views):
            panel(plotter, i)
            reach = extent if channel is None else _add_walls(plotter, channel, view, extent)
            for tube in tubes:
                _add_tube(plotter, tube, look.limits)
            aim(plotter, view, reach, AXES_ROOM)
            add_axes(plotter)
        strip(plotter)
        if look.limits is not None:
            colour_bar(plotter, sample_of(look.limits, COLOUR_MAP), look.title, 0.4, 0.5)
        add_text(plotter, size_label(extent, look.unit), (0.02, 0.72), scaled(plotter, SMALL))
    return Path(path)


def _add_walls(plotter: Any, channel: Boundary, view: View, extent: Array) -> Array:
    """The channel with its openings; points (3, N) that the picture has to hold."""
    add_channel(plotter, channel, view)
    return np.hstack([extent, add_openings(plotter, channel, view)])


@dataclass(frozen=True)
class _Look:
    """Limits of the colours, if values are shown, the title of their bar, the unit of length."""

    limits: Limits | None
    title: str
    unit: str

    @staticmethod
    def of(
        channel: Boundary | None, scalars: Sequence[Array], label: str, units: UnitNames | None
    ) -> _Look:
        unit = "" if channel is None else channel.unit
        title = quantity_label(label, unit, units)
        unit = length_unit(channel, units)
        if not scalars:
            return _Look(None, title, unit)
        every = np.concatenate(scalars)
        return _Look(colour_limits(float(every.min()), float(every.max())), title, unit)


def _checked(
    channel: Boundary | None,
    paths: Sequence[ArrayLike],
    values: Sequence[ArrayLike] | None,
) -> tuple[Array, list[Array], list[Array]]:
    """Points (dim, N) of everything, and those parts of paths and values that are finite."""
    tracks = [np.asarray(track, dtype=float) for track in paths]
    scalars = [np.asarray(v, dtype=float) for v in values] if values is not None else []
    lengths = [len(v) for v in scalars], [track.shape[1] for track in tracks]
    if values is not None and lengths[0] != lengths[1]:
        raise ShapeError(
            f"values along paths: {lengths[0]}, points: {lengths[1]}; give one value a point"
        )
    kept = [np.isfinite(track).all(axis=0) for track in tracks]
    tracks = [track[:, keep] for track, keep in zip(tracks, kept, strict=True)]
    scalars = [v[keep] for v, keep in zip(scalars, kept, strict=bool(scalars))]
    return extent_of_paths(channel, tracks), tracks, scalars


def _tubes(tracks: Sequence[Array], scalars: Sequence[Array], extent: Array) -> list[Any]:
    pyvista = load_pyvista()
    share = THICK * min(1.0, np.sqrt(CROWD / len(tracks)))
    radius = share * np.linalg.norm(np.ptp(extent, axis=1))
    tubes = []
    for place, track in enumerate(tracks):
        if track.shape[1] > 1:
            line = pyvista.MultipleLines(track.T)
            line.point_data["value"] = scalars[place] if scalars else np.full(len(track.T), place)
            tubes.append(line.tube(radius=radius, n_sides=12))
    return tubes


def _add_tube(plotter: Any, tube: Any, limits: Limits | None) -> None:
    """In the colours of values, or in one of its own."""
    place = int(tube.point_data["value"][0])
    colours = {"color": body_colour(place)} if limits is None else {"cmap": COLOUR_MAP}
    plotter.add_mesh(
        tube.copy(deep=False),
        scalars=None if limits is None else "value",
        clim=limits,
        ambient=0.7,
        diffuse=0.3,
        show_scalar_bar=False,
        **colours,
    )


def _draw_plane(
    channel: Boundary | None,
    tracks: Sequence[Array],
    scalars: Sequence[Array],
    look: _Look,
    size: Size,
) -> Any:
    """The figure of paths in a plane."""
    from matplotlib.collections import LineCollection

    extent = extent_of_paths(channel, tracks)
    figure, (axes,) = plane_figure(extent, look.unit, size)
    if channel is not None:
        add_plane_channel(axes, channel)
    for place, track in enumerate(tracks):
        if look.limits is None:
            axes.plot(*track, color=body_colour(place), linewidth=1.5)
            continue
        pieces = np.stack([track[:, :-1].T, track[:, 1:].T], axis=1)
        lines = LineCollection(list(pieces), cmap=COLOUR_MAP, linewidths=1.8)
        lines.set_array(0.5 * (scalars[place][:-1] + scalars[place][1:]))
        lines.set_clim(*look.limits)
        axes.add_collection(lines)
    if look.limits is not None:
        add_colour_bar(figure, [axes], look.limits, look.title, COLOUR_MAP)
    return figure
