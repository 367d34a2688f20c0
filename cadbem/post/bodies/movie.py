"""Pictures and movies of bodies on their way through a channel."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

from cadbem.boundary import Boundary
from cadbem.checks import whole
from cadbem.post.bodies.colouring import Colouring
from cadbem.post.bodies.plane_scenes import plane_camera, plane_still
from cadbem.post.bodies.scenes import Scene, camera, still
from cadbem.post.fields.frames import Frame, Shape, require_frames, time_labels
from cadbem.post.files.encode import Shots, encoder
from cadbem.post.files.export import prepared
from cadbem.post.style.layout import Size, check_size
from cadbem.spline.basis import Array
from cadbem.units import UnitNames

Limits = tuple[float, float]
SHADES = 64  # of a colour bar that a GIF tells apart


def draw_scene(
    path: str | Path,
    channel: Boundary | None,
    shapes: Mapping[int, Shape],
    *,
    fields: Mapping[int, Mapping[str, Array]] | None = None,
    colour: str = "",
    limits: Limits | None = None,
    units: UnitNames | None = None,
    size: Size = (1800, 1000),
) -> Path:
    """Picture of bodies, by their numbers, in a channel; also without one, or without bodies.

    Closed splines are droplets, drawn plain; boundaries are rigid particles, drawn chequered.  In
    space the channel is seen along its shortest axis and from a corner, without one along y.
    Walls are glass, openings are tinted.  ``colour`` names a field to colour bodies by: "mean
    curvature", or one of ``fields`` (see ``Frame``); ``limits`` are those of the colours.
    ``units`` are the units in labels (``length``, ``time``, ``pressure``).
    Raises ``CadbemError`` when there is nothing to draw or no such field, ``ShapeError`` for two
    dimensions at once, ``DisplayError`` where nothing can be drawn.
    """
    check_size(size)
    frame = Frame(0.0, shapes, fields or {})
    plane = require_frames(channel, [frame]) == 2
    colouring = Colouring.of([frame], colour, _unit(channel), units, limits)
    if plane:
        return _saved(path, plane_still(channel, [frame], [(frame, "")], size, colouring))
    scene = Scene.of(channel, [frame], colouring)
    return _saved(path, still(scene, [(view, frame, "") for view in scene.views], size))


def draw_movie(
    path: str | Path,
    channel: Boundary | None,
    frames: Sequence[Frame],
    *,
    colour: str = "",
    limits: Limits | None = None,
    units: UnitNames | None = None,
    size: Size = (900, 600),
) -> Path:
    """Movie (``.mp4``) or animated picture (``.gif``) of bodies in a channel, seen as by
    ``draw_scene``, with the time in a corner.

    All frames are shown equally long, also those of unequal steps of time.  Bodies have colours
    of their own, or those of the field that ``colour`` names, within the same ``limits`` in all
    frames (else its extremes over all of them).  Pictures are drawn and written one at a time.
    Raises as ``draw_scene`` does, and ``CadbemError`` for other endings and where there is no
    encoder for MP4.
    """
    check_size(size)
    target = Path(path)
    write = encoder(target)
    plane = require_frames(channel, frames) == 2
    colouring = Colouring.of(frames, colour, _unit(channel), units, limits)
    taking: Any = (
        plane_camera(channel, frames, size, colouring)
        if plane
        else camera(Scene.of(channel, frames, colouring), size)
    )
    labels = time_labels(frames, "" if units is None else units.time)
    with taking as picture:
        scale = None if colouring is None else colouring.scale(SHADES)
        shots = Shots(target.name, len(frames), lambda k: picture(frames[k], labels[k]), scale)
        write(prepared(target), shots)
    return target


def filmstrip(
    path: str | Path,
    channel: Boundary | None,
    frames: Sequence[Frame],
    count: int = 6,
    *,
    colour: str = "",
    limits: Limits | None = None,
    units: UnitNames | None = None,
    size: Size = (1800, 1100),
) -> Path:
    """Picture of ``count`` frames side by side, evenly spread from the first to the last.

    Other arguments are those of ``draw_movie``, and colours' limits hold for all frames, drawn or
    not.  Raises as ``draw_scene`` does.
    """
    check_size(size)
    whole("count", count)
    plane = require_frames(channel, frames) == 2
    colouring = Colouring.of(frames, colour, _unit(channel), units, limits)
    chosen = np.linspace(0, len(frames) - 1, min(count, len(frames))).round().astype(int)
    labels = time_labels(frames, "" if units is None else units.time)
    if plane:
        plates = [(frames[k], labels[k]) for k in chosen]
        return _saved(path, plane_still(channel, frames, plates, size, colouring))
    scene = Scene.of(channel, frames, colouring)
    panels = [(scene.views[0], frames[k], labels[k]) for k in chosen]
    return _saved(path, still(scene, panels, size))


def _unit(channel: Boundary | None) -> str:
    return "" if channel is None else channel.unit


def _saved(path: str | Path, image: Image.Image) -> Path:
    image.save(target := prepared(path))
    return target
