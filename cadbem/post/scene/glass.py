"""Parts that several pictures share: the channel as transparent walls, lines on a surface."""

from __future__ import annotations

from typing import Any

import numpy as np

from cadbem.boundary import Boundary
from cadbem.post.fields.cells import sharp_edges, tessellated
from cadbem.post.style.layout import View
from cadbem.post.style.style import INK, WALL
from cadbem.spline.basis import Array


def lifted(view: View, extent: Array) -> Array:
    """Shift (3,) towards the viewer that brings lines clear of the surface they lie on."""
    return 1e-3 * np.ptp(extent, axis=1).max() * view.toward


def add_lines(plotter: Any, lines: Any, lift: Array, width: float = 2) -> None:
    """Lines, or none, shifted towards the viewer."""
    if lines.n_points:
        plotter.add_mesh(lines.translate(lift), color=INK, line_width=width, lighting=False)


def add_channel(plotter: Any, boundary: Boundary, view: View) -> None:
    """The channel's sharp edges, and its far walls as a faint background.

    Near walls would veil what is inside and change its colours.
    """
    surface = tessellated(boundary)
    plotter.add_mesh(surface, color=WALL, opacity=0.25, lighting=False, culling="back")
    lift = lifted(view, surface.points.T)
    add_lines(plotter, sharp_edges(boundary), lift, width=1.5)
