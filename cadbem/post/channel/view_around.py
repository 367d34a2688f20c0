"""Picture of the flow around bodies: speed on a plane."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Protocol

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial import cKDTree

from cadbem.checks import positive, whole
from cadbem.post.fields.cells import PatchField, tessellated
from cadbem.post.style.display import load_pyvista
from cadbem.post.style.layout import Size, add_axes, aim, check_size, panel, plan_view, sheet, strip
from cadbem.post.style.style import (
    COLOUR_MAP,
    INK,
    SMALL,
    WALL,
    UnitNames,
    add_text,
    colour_bar,
    quantity_label,
    scaled,
    size_label,
)
from cadbem.quadrature.options import Quadrature
from cadbem.space import Space
from cadbem.spline.basis import Array

DISPLAY_TOLERANCE = 1e-4  # of integrals: more than a colour can show
AXES_ROOM = (0.12, 0.0)  # share of the picture kept free for the axes and at the top


class FlowSolution(Protocol):
    """The part of a solution that is drawn: the velocity on bodies and in the fluid."""

    @property
    def space(self) -> Space: ...

    @property
    def velocity(self) -> PatchField: ...

    def velocity_at(self, points: ArrayLike, quadrature: Quadrature | None = None) -> Array: ...


def draw_around(
    solution: FlowSolution,
    path: str | Path,
    *,
    reach: float = 1.5,
    resolution: int = 120,
    units: UnitNames | None = None,
    size: Size = (1500, 1600),
) -> Path:
    """Picture of the speed on the middle plane of bodies, along their two longest axes.

    The plane goes ``reach`` times the bodies' greatest length beyond them on all sides, with
    ``resolution`` points along it; lines of equal speed are a tenth of its range apart.
    """
    check_size(size)
    positive("reach", reach)
    whole("resolution", resolution, 2)
    boundary = solution.space.boundary
    bodies = tessellated(boundary, fields={"velocity": solution.velocity})
    extent = np.array(bodies.points.T)
    view = plan_view(extent)
    grid = _plane(view.right, view.up, extent, reach, resolution)
    grid.point_data["speed"] = np.linalg.norm(_velocity(solution, bodies, grid.points), axis=1)
    with sheet(path, size, 1, view.aspect(grid.points.T)) as plotter:
        panel(plotter, 0)
        colours = plotter.add_mesh(
            grid, scalars="speed", cmap=COLOUR_MAP, lighting=False, show_scalar_bar=False
        )
        slowest, fastest = grid.get_data_range("speed")
        lines = grid.contour(np.linspace(slowest, fastest, 11)[1:-1], "speed")
        lift = 1e-3 * np.ptp(extent, axis=1).max() * view.toward
        plotter.add_mesh(lines.translate(lift), color=INK, line_width=1, lighting=False)
        # the bodies themselves hide the plane's part that is inside them
        plotter.add_mesh(bodies, color=WALL, smooth_shading=True)
        aim(plotter, view, grid.points.T, AXES_ROOM)
        add_axes(plotter)
        strip(plotter)
        colour_bar(plotter, colours, quantity_label("speed", boundary.unit, units), 0.4, 0.5)
        add_text(plotter, size_label(extent, boundary.unit), (0.02, 0.72), scaled(plotter, SMALL))
    return Path(path)


def _velocity(solution: FlowSolution, bodies: Any, points: Array) -> Array:
    """Velocity (M, 3) at points (M, 3); inside bodies that of their nearest point, so that
    colours do not fade towards them."""
    _, nearest = cKDTree(bodies.points).query(points)
    gap = points - bodies.points[nearest]
    velocity = np.array(bodies.point_data["velocity"][nearest])
    fluid = (gap * bodies.point_data["Normals"][nearest]).sum(axis=1) > 0
    quadrature = Quadrature(DISPLAY_TOLERANCE)
    velocity[fluid] = solution.velocity_at(points[fluid].T, quadrature).T
    return velocity


def _plane(right: Array, up: Array, extent: Array, reach: float, resolution: int) -> Any:
    """Structured grid around the bodies through the middle of their box."""
    middle, lengths = extent.mean(axis=1), np.ptp(extent, axis=1)
    halves = [0.5 * abs(axis) @ lengths + reach * lengths.max() for axis in (right, up)]
    counts = [max(2, round(resolution * half / max(halves))) for half in halves]
    s, t = np.meshgrid(
        *[np.linspace(-h, h, n) for h, n in zip(halves, counts, strict=True)], indexing="ij"
    )
    points = middle + s[..., None] * right + t[..., None] * up
    return load_pyvista().StructuredGrid(*np.moveaxis(points, -1, 0)[..., None])
