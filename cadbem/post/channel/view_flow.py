"""Pictures of the flow inside: speed on cutting planes, streamlines."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from cadbem.boundary import Boundary, Patch
from cadbem.checks import whole
from cadbem.errors import ShapeError
from cadbem.points import surface_points
from cadbem.post.fields.sampling import FlowSolution, sample_flow
from cadbem.post.plane.plane_flow import draw_plane_flow
from cadbem.post.scene.glass import add_channel
from cadbem.post.style.display import load_pyvista
from cadbem.post.style.layout import (
    Size,
    View,
    add_axes,
    aim,
    axes_by_length,
    check_size,
    corner_view,
    panel,
    plan_view,
    sheet,
    strip,
)
from cadbem.post.style.style import (
    COLOUR_MAP,
    SMALL,
    UnitNames,
    add_text,
    colour_bar,
    length_unit,
    quantity_label,
    scaled,
    size_label,
)
from cadbem.spline.basis import Array

SECTIONS, LINES = 7, 60  # cross-sections and streamlines
AXES_ROOM = (0.12, 0.0)  # share of a panel kept free for the axes and at the top


def draw_slices(
    grid: Any,
    boundary: Boundary,
    path: str | Path,
    *,
    sections: int = 7,
    units: UnitNames | None = None,
    size: Size = (1800, 1300),
) -> Path:
    """Picture of the speed on the lengthwise middle planes and on cross-sections, and of the
    pressure on the first of these planes.

    ``grid`` is a ``volume_grid``; its mesh must be fine enough for the colours to be smooth.
    """
    check_size(size)
    whole("sections", sections)
    extent = grid.points.T
    middle, shortest = axes_by_length(extent)[1:]
    flat = [_plane(grid, shortest, 0.5)]
    shown = [
        (plan_view(extent), "speed", flat),
        (plan_view(extent, hidden=1), "speed", [_plane(grid, middle, 0.5)]),
        (corner_view(extent), "speed", _cross_sections(grid, sections)),
        (plan_view(extent), "pressure", flat),
    ]
    _draw_panels(path, grid, boundary, shown, units, size)
    return Path(path)


def draw_flow(
    solution: FlowSolution,
    path: str | Path,
    *,
    points: int = 4000,
    units: UnitNames | None = None,
    size: Size = (1800, 1300),
) -> Path:
    """Picture of a solved flow in a channel: speed and pressure on the widest middle plane, speed
    on cross-sections, and streamlines; in a plane speed with streamlines, and pressure.

    The flow is sampled at about ``points`` places in the fluid, and more on its boundary, where
    it is known; more of them for narrow or long channels.  ``units`` are the units in labels
    (``length``, ``time``, ``pressure``).  Raises ``ShapeError`` for a flow that no channel
    encloses, ``DisplayError`` where pictures cannot be drawn.
    """
    check_size(size)
    whole("points", points)
    boundary = solution.space.boundary
    if boundary.volume() <= 0:
        raise ShapeError("there is no channel around this flow: draw it by draw_around")
    sample = sample_flow(solution, points)
    if boundary.dimension == 2:
        return draw_plane_flow(sample, boundary, path, units, size)
    grid = sample.grid()
    extent = grid.points.T
    plan, corner = plan_view(extent), corner_view(extent)
    flat = [_plane(grid, axes_by_length(extent)[2], 0.5)]
    shown = [
        (plan, "speed", flat),
        (plan, "pressure", flat),
        (corner, "speed", _cross_sections(grid, SECTIONS)),
        (corner, "speed", [_tubes(grid, boundary, LINES)]),
    ]
    _draw_panels(path, grid, boundary, shown, units, size)
    return Path(path)


def _draw_panels(
    path: str | Path,
    grid: Any,
    boundary: Boundary,
    shown: Sequence[tuple[View, str, Sequence[Any]]],
    units: UnitNames | None,
    size: Size,
) -> None:
    """Panels of parts of the grid, each with its view and the quantity that colours show."""
    extent = grid.points.T
    bars = {}
    aspect = min(view.aspect(extent) for view, _, _ in shown)
    with sheet(path, size, len(shown), aspect) as plotter:
        for i, (view, quantity, parts) in enumerate(shown):
            panel(plotter, i)
            for part in parts:
                shading = 0.3 if part.n_strips or part.n_lines else 0.0
                bars[quantity] = _add_colours(plotter, grid, part, quantity, shading)
            add_channel(plotter, boundary, view)
            aim(plotter, view, extent, AXES_ROOM)
            add_axes(plotter)
        _add_bars(plotter, bars, boundary, extent, units)


def _cross_sections(grid: Any, count: int) -> list[Any]:
    longest = axes_by_length(grid.points.T)[0]
    return [_plane(grid, longest, (k + 0.5) / count) for k in range(count)]


def draw_streamlines(
    grid: Any,
    boundary: Boundary,
    path: str | Path,
    *,
    lines: int = 60,
    units: UnitNames | None = None,
    size: Size = (1800, 1200),
) -> Path:
    """Picture of about ``lines`` streamlines from the openings where fluid enters, in a
    transparent channel, coloured by speed; ``grid`` is a ``volume_grid``.
    """
    check_size(size)
    whole("lines", lines)
    view = corner_view(grid.points.T)
    shown = [(view, "speed", [_tubes(grid, boundary, lines)])]
    _draw_panels(path, grid, boundary, shown, units, size)
    return Path(path)


def _tubes(grid: Any, boundary: Boundary, lines: int) -> Any:
    """About ``lines`` streamlines as tubes."""
    streams = grid.streamlines_from_source(
        load_pyvista().PolyData(inflow_seeds(grid, boundary, lines)),
        vectors="velocity",
        integration_direction="forward",
        initial_step_length=0.1,
        max_step_length=0.2,
        max_steps=20000,
        terminal_speed=1e-4 * _speed_limits(grid)[1],
        compute_vorticity=False,
    )
    return streams.tube(radius=0.002 * np.linalg.norm(np.ptp(grid.points, axis=0)), n_sides=6)


def inflow_seeds(grid: Any, boundary: Boundary, count: int) -> Array:
    """About ``count`` points (N, 3), evenly spread just inside where fluid enters."""
    depth = 2e-3 * float(np.ptp(grid.points, axis=0).max())
    slow = 0.01 * _speed_limits(grid)[1]
    inlets = [p for p in boundary.patches if _inflow(grid, p, depth) > slow]
    area = sum(float(p.quadrature(4)[1].sum()) for p in inlets)
    spacing = np.sqrt(area / count)
    return np.concatenate([_spread(patch, spacing, depth) for patch in inlets])


def _plane(grid: Any, axis: int, share: float) -> Any:
    """Cut across an axis at a share of the grid's extent along it."""
    low, high = np.asarray(grid.points).min(axis=0), np.asarray(grid.points).max(axis=0)
    return grid.slice(normal=np.eye(3)[axis], origin=low + share * (high - low))


def _inflow(grid: Any, patch: Patch, depth: float) -> float:
    """Mean velocity into the fluid just inside a patch."""
    points, weights = patch.quadrature(4)
    inner = (points.position + depth * points.normal).T
    probed = load_pyvista().PolyData(inner).sample(grid).point_data["velocity"]
    return float((probed.T * points.normal).sum(axis=0) @ weights / weights.sum())


def _spread(patch: Patch, spacing: float, depth: float) -> Array:
    """A lattice of points (N, 3) in the patch about ``spacing`` apart, shifted into the fluid."""
    parameters = []
    for along, (low, high) in enumerate(patch.surface.domain):
        count = max(1, round(_width(patch, along) / spacing))
        parameters.append(low + (high - low) * (np.arange(count) + 0.5) / count)
    u, v = np.meshgrid(*parameters, indexing="ij")
    points = surface_points(patch.surface, u.ravel(), v.ravel())
    return (points.position + depth * points.normal).T


def _width(patch: Patch, along: int) -> float:
    """Length of the patch's middle line in one direction."""
    ends = patch.surface.domain
    parameters = [np.full(17, 0.5 * (low + high)) for low, high in ends]
    parameters[along] = np.linspace(*ends[along], 17)
    steps = np.diff(patch.surface.evaluate(*parameters), axis=1)
    return float(np.linalg.norm(steps, axis=0).sum())


def _speed_limits(grid: Any) -> tuple[float, float]:
    return 0.0, float(np.linalg.norm(grid.point_data["velocity"], axis=1).max())


def _add_colours(plotter: Any, grid: Any, mesh: Any, quantity: str, shading: float = 0.0) -> Any:
    """Part of the grid, coloured by its speed or pressure within the limits of the whole."""
    pressure = grid.point_data["pressure"]
    mesh.point_data["speed"] = np.linalg.norm(mesh.point_data["velocity"], axis=1)
    return plotter.add_mesh(
        mesh.copy(deep=False),
        scalars=quantity,
        cmap=COLOUR_MAP,
        clim=_speed_limits(grid) if quantity == "speed" else (pressure.min(), pressure.max()),
        ambient=1 - shading,
        diffuse=shading,
        show_scalar_bar=False,
    )


def _add_bars(
    plotter: Any,
    bars: Mapping[str, Any],
    boundary: Boundary,
    extent: Array,
    units: UnitNames | None,
) -> None:
    strip(plotter)
    for i, (quantity, actor) in enumerate(bars.items()):
        label = quantity_label(quantity, boundary.unit, units)
        colour_bar(plotter, actor, label, 0.24 + 0.4 * i, 0.3)
    add_text(
        plotter,
        size_label(extent, length_unit(boundary, units)),
        (0.02, 0.72),
        scaled(plotter, SMALL),
    )
