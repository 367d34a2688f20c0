"""Axes in a plane with a channel in them: a plane one, or the plan of one in space."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from cadbem.boundary import Boundary
from cadbem.post.fields.cells import between, sharp_edges, tessellated
from cadbem.post.scene.openings import opening_names
from cadbem.post.style.layout import Size, arrangement
from cadbem.post.style.style import BACKGROUND, GLASS, INK, OPENING, WALL
from cadbem.spline.basis import Array
from cadbem.spline.nurbs import Nurbs

DPI = 150
MARGIN = 0.05  # of the greatest length, around everything
TITLE, LABELS = 0.4, 1.0  # inches above each panel; below all, with the legend
SIDE = 0.6  # inches for the labels on the left
SAMPLES = 16  # points along each element; even, for halves


def plane_figure(
    extent: Array, unit: str, size: Size, panels: int = 1, names: str = "xy"
) -> tuple[Any, list[Any]]:
    """A figure, at most ``size`` pixels large, with axes around points (2, N) in each panel.

    ``names`` are those of the two coordinates.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    low, high = extent.min(axis=1), extent.max(axis=1)
    low, high = low - MARGIN * (high - low).max(), high + MARGIN * (high - low).max()
    aspect = np.divide(*(high - low))
    rows, columns = arrangement(panels, aspect, size)
    height = rows * ((size[0] / DPI - SIDE) / columns / aspect + TITLE) + LABELS
    inches = size[0] / DPI, min(size[1] / DPI, height)
    figure = Figure(figsize=inches, dpi=DPI, layout="constrained")
    FigureCanvasAgg(figure)
    grid = figure.subplots(rows, columns, sharex=True, sharey=True, squeeze=False).ravel()
    for axes in grid[:panels]:
        axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), aspect="equal")
        axes.set(**{f"{k}label": with_unit(n, unit) for k, n in zip("xy", names, strict=True)})
        axes.spines[:].set_color(WALL)
        axes.label_outer()
    for axes in grid[panels:]:
        axes.remove()
    return figure, list(grid[:panels])


def with_unit(name: str, unit: str) -> str:
    """Label of an axis."""
    return f"{name} ({unit})" if unit else name


def add_legend(figure: Any, handles: Sequence[Any]) -> None:
    """A legend below everything."""
    if handles:
        figure.legend(handles=handles, loc="outside lower center", ncols=4, frameon=False)


def add_colour_bar(
    figure: Any, axes: Sequence[Any], limits: tuple[float, float], label: str, colours: Any
) -> None:
    """A colour bar below everything."""
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import Normalize

    shown = ScalarMappable(Normalize(*limits), colours)
    figure.colorbar(shown, ax=axes, label=label, location="bottom", shrink=0.6, aspect=40)


def add_plane_channel(axes: Any, channel: Boundary) -> None:
    """A plane channel: walls as lines, openings tinted and named."""
    names = opening_names(channel)
    for patch in channel.patches:
        opening = patch.name in names
        style = {"color": OPENING if opening else INK, "linewidth": 3 if opening else 1.5}
        axes.plot(*along_curve(patch.surface), **style, solid_capstyle="butt")
    for name in names:
        middle = channel.patches[channel.select(name)[0]].middle()
        add_name(axes, name, middle.position[:, 0], -middle.normal[:, 0])


def add_plan(axes: Any, channel: Boundary, shown: Sequence[int]) -> None:
    """The plan of a channel in space on two of its coordinates: what it covers, its sharp edges,
    its openings with their names."""
    from matplotlib.collections import LineCollection, PolyCollection

    flat = _quadrilaterals(tessellated(channel), shown)
    axes.add_collection(PolyCollection(flat, facecolor=GLASS, edgecolor=GLASS, linewidth=1))
    edges = sharp_edges(channel)
    lines = [edges.points[cell.point_ids][:, shown] for cell in edges.cell]
    axes.add_collection(LineCollection(lines, color=INK, linewidth=0.8))
    style: dict[str, Any] = {"edgecolor": OPENING, "linewidth": 3, "zorder": 2.5}  # above edges
    for name in opening_names(channel):
        opening = tessellated(channel, patches=channel.select(name))
        flat = _quadrilaterals(opening, shown)
        axes.add_collection(PolyCollection(flat, facecolor="none", **style))
        outward = -np.asarray(opening.point_data["Normals"]).mean(axis=0)[shown]
        if np.linalg.norm(outward) > 0.1:
            add_name(axes, name, opening.points.mean(axis=0)[shown], outward)


def _quadrilaterals(surface: Any, shown: Sequence[int]) -> list[Array]:
    """Corners (4, 2) of the cells of a tessellated surface."""
    corners = surface.faces.reshape(-1, 5)[:, 1:]
    return list(np.asarray(surface.points)[corners][..., shown])


def add_name(axes: Any, name: str, middle: Array, outward: Array) -> None:
    """A name along an opening, outside."""
    across, along = outward / np.linalg.norm(outward)
    slope = np.degrees(np.arctan2(-across, along))  # of the opening
    axes.annotate(
        name,
        middle,
        (9 * across, 9 * along),
        textcoords="offset points",
        rotation=(slope + 90) % 180 - 90 if abs(abs(slope) - 90) > 1e-6 else 90,
        ha="center",
        va="center",
        fontsize="small",
        bbox={"color": BACKGROUND, "pad": 0.5},
        annotation_clip=False,
    )


def along_curve(curve: Nurbs) -> Array:
    """Points (2, n) from end to end, an odd number."""
    return curve.evaluate(between(curve.breaks(0), SAMPLES))
