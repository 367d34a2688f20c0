"""Sheets of panels, and cameras that fit their objects into a panel."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from cadbem.checks import one_of, whole
from cadbem.errors import InputError
from cadbem.post.files.export import prepared
from cadbem.post.style.display import load_pyvista
from cadbem.post.style.style import BACKGROUND, INK
from cadbem.spline.basis import Array

Size = tuple[int, int]
ENDINGS = (".png", ".jpeg", ".jpg", ".bmp", ".tif", ".tiff")
LEAST, MOST = 16, 32768  # pixels along a side of a picture
STRIP = 0.12  # height of the strip for legends, as a part of the sheet


@dataclass(frozen=True, eq=False)
class View:
    """Where a camera looks: unit vectors (3,) to the right, up, and towards the viewer."""

    right: Array
    up: Array

    @property
    def toward(self) -> Array:
        """From the object to the viewer."""
        return np.cross(self.right, self.up)

    def turned(self, azimuth: float, elevation: float) -> View:
        """The viewer moves by angles in degrees to the right around ``up``, then upwards."""
        a, e = np.radians([azimuth, elevation])
        right = np.cos(a) * self.right - np.sin(a) * self.toward
        toward = np.cos(a) * self.toward + np.sin(a) * self.right
        return View(right, np.cos(e) * self.up - np.sin(e) * toward)

    def flat(self, points: Array) -> Array:
        """Coordinates (2, N) on the screen of points (3, N)."""
        return np.stack([self.right, self.up]) @ points

    def aspect(self, points: Array) -> float:
        """Width over height of points (3, N) on the screen."""
        width, height = np.ptp(self.flat(points), axis=1)
        return float(width / max(height, 1e-3 * width))


def flow_views() -> tuple[View, View]:
    """Against y, with x to the right and z up, and from a corner."""
    front = View(np.array([1.0, 0.0, 0.0]), np.array([0.0, 0.0, 1.0]))
    return front, front.turned(35.0, 25.0)


def axes_by_length(points: Array) -> tuple[int, int, int]:
    """Axes along which points (3, N) extend longest, less and least; x before y before z."""
    lengths = np.ptp(points, axis=1)
    extent = np.round(lengths / lengths.max(), 6)
    first, second, third = np.argsort(-extent, kind="stable")
    return int(first), int(second), int(third)


def plan_view(points: Array, hidden: int = 2) -> View:
    """Straight view of points (3, N) with their longest axis to the right; ``hidden`` is the
    rank of the axis along which one looks, 2 for the shortest and 1 for the middle one."""
    order = axes_by_length(points)
    right, up = np.eye(3)[order[0]], np.eye(3)[order[3 - hidden]]
    return View(right, up)


def corner_view(points: Array) -> View:
    """Oblique view of points (3, N) from the front, right and above; longest axis across."""
    return plan_view(points, hidden=1).turned(28.0, 32.0)


def back_view(points: Array) -> View:
    """Oblique view of points (3, N) from the corner opposite to that of ``corner_view``."""
    return plan_view(points, hidden=1).turned(208.0, -32.0)


def aim(plotter: Any, view: View, points: Array, margins: tuple[float, float] = (0, 0)) -> None:
    """Point the panel's camera so that points (3, N) fill it, in parallel projection.

    ``margins`` are the parts of the panel's height kept free at the bottom and at the top.
    """
    flat = view.flat(points)
    depth = view.toward @ points
    low, high = flat.min(axis=1), flat.max(axis=1)
    bottom, top = margins[0] + 0.04, margins[1] + 0.04
    panel = plotter.renderer.GetSize()
    height = max((high - low)[1] / (1 - bottom - top), (high - low)[0] / 0.92 * panel[1] / panel[0])
    middle = 0.5 * (low + high) + np.array([0.0, 0.5 * (top - bottom) * height])
    target = middle[0] * view.right + middle[1] * view.up + depth.mean() * view.toward
    distance = 10 * max(height, np.ptp(depth))
    plotter.camera_position = [target + distance * view.toward, target, view.up]
    plotter.enable_parallel_projection()
    plotter.camera.parallel_scale = 0.5 * height
    plotter.renderer.reset_camera_clipping_range()


def check_size(size: Size) -> None:
    """Raises ``InputError`` unless a picture's size is width and height in pixels."""
    if np.shape(size) != (2,):
        raise InputError(f"size is {size!r}; give width and height in pixels")
    for length in size:
        whole("size", length, LEAST, MOST)


def arrangement(count: int, aspect: float, size: Size) -> tuple[int, int]:
    """Rows and columns in which ``count`` pictures of an aspect come out largest."""
    choices = [(rows, -(-count // rows)) for rows in range(1, count + 1)]
    return max(choices, key=lambda c: min(size[0] / c[1] / aspect, size[1] / c[0]))


@contextmanager
def sheet(path: str | Path, size: Size, panels: int, aspect: float) -> Iterator[Any]:
    """A plotter as in ``stage``, written to ``path`` at the end."""
    target = prepared(path)
    one_of("the ending of the picture's name", target.suffix.lower(), ENDINGS)
    with stage(size, panels, aspect) as plotter:
        yield plotter
        plotter.screenshot(target, return_img=False)


@contextmanager
def stage(size: Size, panels: int, aspect: float) -> Iterator[Any]:
    """A plotter with ``panels`` above a strip for the legend, closed at the end.

    Inside, choose with ``panel`` and ``strip``.
    """
    pyvista = load_pyvista()
    rows, columns = arrangement(panels, aspect, (size[0], round(size[1] * (1 - STRIP))))
    plotter = pyvista.Plotter(
        off_screen=True,
        window_size=size,
        shape=(rows + 1, columns),
        row_weights=[(1 - STRIP) / rows] * rows + [STRIP],
        groups=[(rows, slice(None))],
        border=False,
    )
    try:
        plotter.set_background(BACKGROUND)
        plotter.render_window.SetMultiSamples(0)
        yield plotter
    finally:
        plotter.close()


def panel(plotter: Any, index: int) -> None:
    """Draw in a panel from now on; panels count row by row."""
    columns = plotter.shape[1]
    plotter.subplot(*divmod(index, columns))


def strip(plotter: Any) -> None:
    """Draw in the strip for the legend from now on."""
    plotter.subplot(plotter.shape[0] - 1, 0)


def add_axes(plotter: Any) -> None:
    """Arrows of x, y and z in the lower left corner of the panel."""
    width, height = plotter.renderer.GetSize()
    side = 0.14 * np.sqrt(width * height)
    plotter.add_axes(
        color=INK,
        line_width=3,
        xlabel="x",
        ylabel="y",
        zlabel="z",
        viewport=(0, 0, side / width, side / height),
    )
