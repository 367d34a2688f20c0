"""Picture of a boundary in a plane: its edges, names and numbers."""

from __future__ import annotations

from pathlib import Path

from cadbem.boundary import Boundary
from cadbem.post.fields.frames import spread_points
from cadbem.post.files.export import prepared
from cadbem.post.plane.plane import add_legend, add_name, along_curve, plane_figure
from cadbem.post.style.layout import Size
from cadbem.post.style.style import INK, UNNAMED, WALL, colours_of


def draw_plane_boundary(boundary: Boundary, path: str | Path, size: Size) -> Path:
    """Edges in the colours of their names, with their numbers outside; see ``draw_boundary``."""
    from matplotlib.lines import Line2D

    figure, (axes,) = plane_figure(spread_points(boundary), boundary.unit, size)
    colours = {n: INK if c == WALL else c for n, c in colours_of(boundary.names).items()}
    ports = [n for n, c in colours.items() if c not in (INK, UNNAMED)]
    labelled = set()
    for patch in boundary.patches:
        axes.plot(*along_curve(patch.surface), color=colours[patch.name], linewidth=2.5)
        if patch.face and patch.face not in labelled:
            middle = patch.middle()
            label = f"{patch.face} {patch.name}" if patch.name in ports else str(patch.face)
            add_name(axes, label, middle.position[:, 0], -middle.normal[:, 0])
            labelled.add(patch.face)
    add_legend(figure, [Line2D([], [], color=c, label=n or "unnamed") for n, c in colours.items()])
    figure.savefig(target := prepared(path))
    return target
