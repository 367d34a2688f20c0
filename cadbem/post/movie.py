"""Pictures and movies of bodies on their way through a channel."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image
from tqdm import tqdm

from cadbem.boundary import Boundary
from cadbem.errors import CadbemError
from cadbem.post.export import prepared
from cadbem.post.frames import Frame, Shape, require_frames, time_labels
from cadbem.post.layout import Size
from cadbem.post.palette import Palette
from cadbem.post.plane_scenes import plane_camera, plane_still
from cadbem.post.scenes import Scene, camera, still

PACE = 70  # milliseconds that a frame is shown
REST = 1500  # milliseconds that the last one is shown


def draw_scene(
    path: str | Path,
    channel: Boundary | None,
    shapes: Mapping[int, Shape],
    *,
    size: Size = (1800, 1000),
) -> Path:
    """Picture of bodies, by their numbers, in a channel; also without one, or without bodies.

    Closed splines are droplets, drawn plain; boundaries are rigid particles, drawn chequered.  In
    space the channel is seen along its shortest axis and from a corner, without one along y.
    Walls are glass, openings are tinted.  Raises ``CadbemError`` when there is nothing to draw,
    ``ShapeError`` for two dimensions at once, ``DisplayError`` where nothing can be drawn.
    """
    frame = Frame(0.0, shapes)
    if require_frames(channel, [frame]) == 2:
        return _saved(path, plane_still(channel, [frame], [(frame, "")], size))
    scene = Scene.of(channel, [frame])
    return _saved(path, still(scene, [(view, frame, "") for view in scene.views], size))


def draw_movie(
    path: str | Path,
    channel: Boundary | None,
    frames: Sequence[Frame],
    *,
    size: Size = (900, 600),
) -> Path:
    """Animated picture (``.gif``) of bodies in a channel, seen as by ``draw_scene``.

    All frames are shown equally long, also those of unequal steps of time.  Raises as
    ``draw_scene`` does, and ``CadbemError`` when the name does not end in .gif.
    """
    target = Path(path)
    if target.suffix != ".gif":
        raise CadbemError(f"{target}: a movie is written to a file that ends in .gif")
    plane = require_frames(channel, frames) == 2
    taking: Any = (
        plane_camera(channel, frames, size) if plane else camera(Scene.of(channel, frames), size)
    )
    with taking as picture:
        shots = list(zip(frames, time_labels(frames), strict=True))
        palette = Palette.of([picture(*shots[k]) for k in {0, len(shots) // 2, len(shots) - 1}])
        images = [
            palette.applied(picture(*shot)) for shot in tqdm(shots, desc=target.name, delay=2)
        ]
    times = [PACE] * (len(images) - 1) + [REST]
    images[0].save(
        prepared(target), save_all=True, append_images=images[1:], duration=times, loop=0
    )
    return target


def filmstrip(
    path: str | Path,
    channel: Boundary | None,
    frames: Sequence[Frame],
    count: int = 6,
    *,
    size: Size = (1800, 1100),
) -> Path:
    """Picture of ``count`` frames side by side, evenly spread from the first to the last.

    Raises as ``draw_scene`` does.
    """
    plane = require_frames(channel, frames) == 2
    chosen = np.linspace(0, len(frames) - 1, min(count, len(frames))).round().astype(int)
    labels = time_labels(frames)
    if plane:
        plates = [(frames[k], labels[k]) for k in chosen]
        return _saved(path, plane_still(channel, frames, plates, size))
    scene = Scene.of(channel, frames)
    panels = [(scene.views[0], frames[k], labels[k]) for k in chosen]
    return _saved(path, still(scene, panels, size))


def _saved(path: str | Path, image: Image.Image) -> Path:
    image.save(target := prepared(path))
    return target
