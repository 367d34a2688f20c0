"""Bodies in a channel in a plane: filled outlines within the channel's walls."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any

import numpy as np
from PIL import Image

from cadbem.boundary import Boundary
from cadbem.post.bodies.bodies import body_colour, legend_of, pale
from cadbem.post.bodies.colouring import NEUTRAL, Colouring, outline_values
from cadbem.post.fields.body_fields import fields_of
from cadbem.post.fields.frames import Frame, Shape, extent_of
from cadbem.post.plane.plane import (
    SAMPLES,
    add_colour_bar,
    add_legend,
    add_plane_channel,
    along_curve,
    plane_figure,
)
from cadbem.post.style.layout import Size
from cadbem.post.style.style import INK, light_colours
from cadbem.spline.basis import Array
from cadbem.spline.closed import ClosedSpline


def add_plane_bodies(axes: Any, frame: Frame, colouring: Colouring | None = None) -> list[Any]:
    """Filled outlines: droplets plain, particles in sectors, so that one sees them turn.  With a
    colouring the outlines have the colours of their values, and what they fill is neutral."""
    artists = []
    for number, shape in frame.shapes.items():
        values = None if colouring is None else fields_of(frame, number).get(colouring.name)
        colour, arcs = body_colour(number) if colouring is None else NEUTRAL, _arcs(shape)
        if values is not None:
            colour = pale(NEUTRAL)
        outline = np.hstack([*arcs, arcs[0][:, :1]])
        artists += axes.fill(*outline, color=colour, linewidth=0)
        whole, centre = artists[-1], outline.mean(axis=1, keepdims=True)
        for arc in arcs[1::2]:
            artists += axes.fill(*np.hstack([arc, centre]), color=pale(colour), linewidth=0)
            artists[-1].set_clip_path(whole)
        artists += axes.plot(*outline, color=INK, linewidth=0.8)
        if colouring is not None and values is not None:
            artists += [_rim(axes, *part, colouring) for part in outline_values(shape, values)]
    return artists


def _rim(axes: Any, points: Array, values: Array, colouring: Colouring) -> Any:
    """A wide line through points (2, n) in the colours of values (n,)."""
    from matplotlib.collections import LineCollection

    pieces = np.stack([points[:, :-1].T, points[:, 1:].T], axis=1)
    colours = colouring.colours(0.5 * (values[:-1] + values[1:])) / 255
    rim = LineCollection(list(pieces), colors=colours, linewidths=4, capstyle="round", zorder=3)
    return axes.add_collection(rim)


def _arcs(shape: Shape) -> list[Array]:
    """Points (2, n) on parts of an outline, one after the other: the whole curve of a droplet,
    halves of a particle's patches."""
    if isinstance(shape, ClosedSpline):
        return [shape.evaluate(np.linspace(0, 2 * np.pi, SAMPLES * shape.basis.count)[None])]
    rest = [along_curve(patch.surface) for patch in shape.patches]
    chain = [rest.pop(0)]
    while rest:
        gaps = [np.linalg.norm(curve[:, 0] - chain[-1][:, -1]) for curve in rest]
        chain.append(rest.pop(int(np.argmin(gaps))))
    return [half for curve in chain for half in _halves(curve)]


def _halves(curve: Array) -> tuple[Array, Array]:
    middle = curve.shape[1] // 2
    return curve[:, : middle + 1], curve[:, middle:]


def plane_still(
    channel: Boundary | None,
    frames: Sequence[Frame],
    panels: Sequence[tuple[Frame, str]],
    size: Size,
    colouring: Colouring | None = None,
) -> Image.Image:
    """A picture with panels, each a frame and what is written above it."""
    figure, all_axes = _figure(channel, frames, size, colouring, len(panels))
    for axes, (frame, caption) in zip(all_axes, panels, strict=True):
        add_plane_bodies(axes, frame, colouring)
        axes.set_title(caption, loc="left")
    return _image(figure)


@contextmanager
def plane_camera(
    channel: Boundary | None,
    frames: Sequence[Frame],
    size: Size,
    colouring: Colouring | None = None,
) -> Iterator[Callable[[Frame, str], Image.Image]]:
    """Takes pictures of frames with their captions; all but the bodies is drawn once."""
    figure, (axes,) = _figure(channel, frames, size, colouring)
    axes.set_title("t = 0", loc="left")
    figure.canvas.draw()
    figure.set_layout_engine("none")  # nothing may move any more

    def picture(frame: Frame, caption: str) -> Image.Image:
        axes.set_title(caption, loc="left")
        bodies = add_plane_bodies(axes, frame, colouring)
        image = _image(figure)
        for artist in bodies:
            artist.remove()
        return image

    yield picture


def _figure(
    channel: Boundary | None,
    frames: Sequence[Frame],
    size: Size,
    colouring: Colouring | None,
    panels: int = 1,
) -> tuple[Any, list[Any]]:
    """A figure with room for all frames, and the channel in each of its panels."""
    from matplotlib.patches import Patch

    unit = "" if channel is None else channel.unit
    figure, grid = plane_figure(extent_of(channel, frames), unit, size, panels)
    for axes in grid:
        if channel is not None:
            add_plane_channel(axes, channel)
    if colouring is None:
        legend = legend_of(frames).items()
        add_legend(figure, [Patch(fc=c, ec=INK, lw=0.5, label=name) for name, c in legend])
    else:
        add_colour_bar(figure, grid, colouring.limits, colouring.label, light_colours())
    return figure, grid


def _image(figure: Any) -> Image.Image:
    figure.canvas.draw()
    return Image.fromarray(np.asarray(figure.canvas.buffer_rgba())[..., :3].copy())
