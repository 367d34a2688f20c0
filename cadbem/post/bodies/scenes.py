"""Bodies in a channel in space: panels with the channel as glass and solid bodies in it."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import numpy as np
from PIL import Image

from cadbem.boundary import Boundary
from cadbem.post.bodies.bodies import body_surface, legend_of
from cadbem.post.bodies.colouring import Colouring
from cadbem.post.fields.frames import Frame, extent_of, spread_points
from cadbem.post.scene.glass import add_channel
from cadbem.post.scene.openings import add_openings
from cadbem.post.style.layout import (
    Size,
    View,
    add_axes,
    aim,
    corner_view,
    flow_views,
    panel,
    plan_view,
    stage,
)
from cadbem.post.style.legend import draw_legend
from cadbem.post.style.style import (
    TEXT,
    add_text,
    colour_bar,
    light_colours,
    sample_of,
    scaled,
    size_label,
)
from cadbem.spline.basis import Array

FINER = 2  # pixels drawn a pixel shown, in each direction: smooth lines
ROOM = (0.1, 0.08)  # share of a panel kept free for the axes and for the time


@dataclass(frozen=True, eq=False)
class Scene:
    """The data that all frames share: the channel, if any, points (3, N) of all objects, and
    the field that bodies are coloured by, if any."""

    channel: Boundary | None
    extent: Array
    legend: Mapping[str, str]
    colouring: Colouring | None = None

    @staticmethod
    def of(
        channel: Boundary | None, frames: Sequence[Frame], colouring: Colouring | None = None
    ) -> Scene:
        """The scene that holds all frames."""
        legend = legend_of(frames) if colouring is None else {}
        return Scene(channel, extent_of(channel, frames), legend, colouring)

    @property
    def views(self) -> tuple[View, View]:
        """The widest plane of the channel, and a corner of it."""
        if self.channel is None:
            return flow_views()
        points = spread_points(self.channel)
        return plan_view(points), corner_view(points)

    def prepare(self, plotter: Any, view: View) -> None:
        """The channel and the axes in the panel drawn at present, and the camera."""
        extent = self.extent
        if self.channel is not None:
            add_channel(plotter, self.channel, view)
            extent = np.hstack([extent, add_openings(plotter, self.channel, view)])
        aim(plotter, view, extent, ROOM)
        add_axes(plotter)

    def finish(self, plotter: Any) -> None:
        """The legend or colour bar, and the size of the channel."""
        note = "" if self.channel is None else _size(self.channel)
        draw_legend(plotter, self.legend, note)
        if self.colouring is not None:
            bar = sample_of(self.colouring.limits, light_colours())
            colour_bar(plotter, bar, self.colouring.label, 0.5, 0.45)

    @property
    def shading(self) -> float:
        """The strength of the lighting, which is small where colours show values."""
        return 0.65 if self.colouring is None else 0.4

    def surface(self, frame: Frame, number: int) -> Any:
        """A body of a frame, in its colours."""
        if self.colouring is None:
            return body_surface(number, frame.shapes[number])
        return self.colouring.surface(frame, number)


def add_body(plotter: Any, surface: Any, shading: float) -> Any:
    """A body (see ``body_surface``) in the panel drawn at present; its actor."""
    actor = plotter.add_mesh(
        surface,
        scalars="colour",
        rgb=True,
        ambient=1 - shading,
        diffuse=shading,
        specular=0.4 * shading,
        specular_power=20,
        reset_camera=False,
        render=False,
    )
    actor.prop.interpolation = "Phong"
    return actor


def still(scene: Scene, panels: Sequence[tuple[View, Frame, str]], size: Size) -> Image.Image:
    """A picture with panels, each a view of a frame and what is written above it."""
    with stage(_finer(size), len(panels), panels[0][0].aspect(scene.extent)) as plotter:
        for i, (view, frame, caption) in enumerate(panels):
            panel(plotter, i)
            scene.prepare(plotter, view)
            for number in frame.shapes:
                add_body(plotter, scene.surface(frame, number), scene.shading)
            _add_caption(plotter, caption)
        scene.finish(plotter)
        return _shot(plotter)


@contextmanager
def camera(scene: Scene, size: Size) -> Iterator[Callable[[Frame, str], Image.Image]]:
    """Takes pictures of frames with their captions; all but the bodies is drawn once."""
    views = scene.views
    with stage(_finer(size), len(views), views[0].aspect(scene.extent)) as plotter:
        for i, view in enumerate(views):
            panel(plotter, i)
            scene.prepare(plotter, view)
        scene.finish(plotter)

        panel(plotter, 0)
        words = _add_caption(plotter, "t")

        actors: dict[int, Any] = {}

        def picture(frame: Frame, caption: str) -> Image.Image:
            words.input = caption
            for number in frame.shapes:
                surface = scene.surface(frame, number)
                if number in actors:
                    actors[number].mapper.dataset = surface
                else:
                    actors[number] = _add_everywhere(plotter, surface, scene.shading, len(views))
            for number, actor in actors.items():
                actor.visibility = number in frame.shapes
            return _shot(plotter)

        yield picture


def _add_everywhere(plotter: Any, surface: Any, shading: float, panels: int) -> Any:
    """One actor for a body in all panels."""
    panel(plotter, 0)
    actor = add_body(plotter, surface, shading)
    for i in range(1, panels):
        panel(plotter, i)
        plotter.add_actor(actor, reset_camera=False, render=False)
    return actor


def _finer(size: Size) -> Size:
    return FINER * size[0], FINER * size[1]


def _shot(plotter: Any) -> Image.Image:
    plotter.render()
    return Image.fromarray(plotter.screenshot(return_img=True)).reduce(FINER)


def _add_caption(plotter: Any, caption: str) -> Any:
    letter = scaled(plotter, 1.3 * TEXT)
    top = 1 - 1.5 * letter / plotter.renderer.GetSize()[1]
    return add_text(plotter, caption, (0.03, top), letter)


def _size(channel: Boundary) -> str:
    return "channel " + size_label(spread_points(channel), channel.unit)
