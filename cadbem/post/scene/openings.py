"""Openings of a channel in pictures: tinted, and with their names beside them."""

from __future__ import annotations

from typing import Any

import numpy as np

from cadbem.boundary import Boundary
from cadbem.post.fields.cells import sharp_edges, tessellated
from cadbem.post.scene.glass import lifted
from cadbem.post.style.layout import View
from cadbem.post.style.style import FONT, INK, LETTER, OPENING, SMALL, scaled
from cadbem.spline.basis import Array


def opening_names(channel: Boundary) -> list[str]:
    """The names that are not those of walls."""
    return [name for name in channel.names if name and not name.startswith("wall")]


def add_openings(plotter: Any, channel: Boundary, view: View) -> Array:
    """Openings in the panel drawn at present; returns points (3, N) up to which names reach."""
    extent = tessellated(channel).points.T
    # panels are not yet aimed, so that this is somewhat less than a pixel will be
    pixel = np.max(np.ptp(view.flat(extent), axis=1) / plotter.renderer.GetSize())
    ends = [np.empty((3, 0))]
    for name in opening_names(channel):
        opening = tessellated(channel, patches=channel.select(name))
        plotter.add_mesh(opening, color=OPENING, opacity=0.35, lighting=False)
        rim = sharp_edges(Boundary(tuple(channel.patches[i] for i in channel.select(name))))
        # wide lines have gaps between their pieces, tubes do not
        tube = rim.tube(radius=scaled(plotter, 2) * pixel, n_sides=12)
        tube = tube.translate(2 * lifted(view, extent))
        plotter.add_mesh(tube, color=OPENING, lighting=False)
        ends.append(_add_name(plotter, name, opening, view, pixel))
    return np.concatenate(ends, axis=1)


def _add_name(plotter: Any, name: str, opening: Any, view: View, pixel: float) -> Array:
    """A name beside its opening, towards the outside as it appears on the screen."""
    across, along = _outside(view, opening)
    letter = scaled(plotter, SMALL)
    direction = across * view.right + along * view.up
    middle = opening.points.mean(axis=0)
    clear = ((opening.points - middle) @ direction).max() + 0.6 * letter * pixel
    anchor = middle + clear * direction
    plotter.add_point_labels(
        anchor[None],
        [name],
        font_family=FONT,
        font_size=letter,
        bold=False,
        text_color=INK,
        shape=None,
        show_points=False,
        always_visible=True,
        justification_horizontal=_edge(across, "right", "left"),
        justification_vertical=_edge(along, "top", "bottom"),
    )
    reach = 1.3 * LETTER * len(name) * letter * pixel * np.sign(across) * view.right
    return np.stack([anchor, anchor + reach], axis=1)


def _outside(view: View, opening: Any) -> Array:
    """Unit vector (2,) on the screen out of an opening; up for one that is seen straight on."""
    outward = -np.asarray(opening.point_data["Normals"]).mean(axis=0)
    flat = view.flat(outward[:, None])[:, 0]
    length = np.linalg.norm(flat)
    return flat / length if length > 0.1 else np.array([0.0, 1.0])


def _edge(share: float, low: str, high: str) -> str:
    """The edge of a text that is at its anchor when it goes towards lower or higher coordinates."""
    return "center" if abs(share) < 0.4 else high if share > 0 else low
