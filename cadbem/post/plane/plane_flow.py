"""Picture of a flow in a plane: speed with streamlines, and pressure."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from cadbem.boundary import Boundary
from cadbem.post.fields.frames import spread_points
from cadbem.post.fields.sampling import Sample
from cadbem.post.files.export import prepared
from cadbem.post.plane.plane import add_plane_channel, plane_figure
from cadbem.post.style.layout import Size
from cadbem.post.style.style import (
    COLOUR_MAP,
    UnitNames,
    colour_limits,
    length_unit,
    quantity_label,
    round_values,
)
from cadbem.spline.basis import Array

LEVELS = 48  # colours
RASTER = 160  # points along the longer side, for streamlines
EXTREMES = 99.5  # percentile at which colours of the pressure end: it may be singular at corners


def draw_plane_flow(
    sample: Sample, boundary: Boundary, path: str | Path, units: UnitNames | None, size: Size
) -> Path:
    """See ``draw_flow``."""
    from matplotlib.tri import Triangulation

    unit = length_unit(boundary, units)
    figure, panels = plane_figure(spread_points(boundary), unit, size, 2)
    mesh = Triangulation(sample.points[0], sample.points[1], sample.cells.T)
    speed = np.linalg.norm(sample.velocity, axis=0)
    low, high = np.percentile(sample.pressure, [100 - EXTREMES, EXTREMES])
    limits = {"speed": (0.0, speed.max()), "pressure": (low, high)}
    for axes, (name, ends), values in zip(
        panels, limits.items(), (speed, sample.pressure), strict=True
    ):
        levels = np.linspace(*colour_limits(*ends), LEVELS)
        inside = np.clip(values, levels[0], levels[-1])
        colours = axes.tricontourf(mesh, inside, levels, cmap=COLOUR_MAP)
        label = quantity_label(name, boundary.unit, units)
        ticks = round_values(levels[0], levels[-1])
        figure.colorbar(colours, ax=axes, label=label, location="bottom", ticks=ticks)
        add_plane_channel(axes, boundary)
    _add_streamlines(panels[0], mesh, sample)
    figure.savefig(target := prepared(path))
    return target


def _add_streamlines(axes: Any, mesh: Any, sample: Sample) -> None:
    from matplotlib.tri import LinearTriInterpolator

    low, high = sample.points.min(axis=1), sample.points.max(axis=1)
    counts = np.maximum(8, np.round(RASTER * (high - low) / (high - low).max())).astype(int)
    lines = [np.linspace(a, b, n) for a, b, n in zip(low, high, counts, strict=True)]
    raster: list[Array] = list(np.meshgrid(*lines))
    u, v = (LinearTriInterpolator(mesh, part)(*raster) for part in sample.velocity)
    style = {"color": "white", "linewidth": 0.7, "arrowsize": 0.7, "density": 0.6}
    axes.streamplot(*lines, u, v, **style, broken_streamlines=False)
