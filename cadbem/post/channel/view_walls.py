"""Picture of the stresses on the walls."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import product
from pathlib import Path
from typing import Any, Protocol

import numpy as np

from cadbem.boundary import Boundary
from cadbem.errors import SelectionError
from cadbem.post.fields.cells import PatchField, sharp_edges, tessellated, wall_stresses
from cadbem.post.scene.glass import add_lines, lifted
from cadbem.post.style.layout import (
    Size,
    add_axes,
    aim,
    back_view,
    check_size,
    corner_view,
    panel,
    sheet,
    strip,
)
from cadbem.post.style.style import (
    COLOUR_MAP,
    SMALL,
    UnitNames,
    add_text,
    colour_bar,
    colour_limits,
    length_unit,
    quantity_label,
    scaled,
    size_label,
)
from cadbem.problems.conditions import NoSlip
from cadbem.spline.basis import Array

_QUANTITIES = ("pressure", "wall shear stress")


class _Problem(Protocol):
    @property
    def conditions(self) -> Mapping[str, Any]: ...


class _Space(Protocol):
    @property
    def boundary(self) -> Boundary: ...


class WallSolution(Protocol):
    """The part of a solution that is drawn: the traction on the boundary and the conditions."""

    @property
    def problem(self) -> _Problem: ...

    @property
    def space(self) -> _Space: ...

    @property
    def traction(self) -> PatchField: ...


def draw_traction(
    solution: WallSolution,
    path: str | Path,
    *,
    units: UnitNames | None = None,
    size: Size = (1800, 1300),
) -> Path:
    """Picture of both parts of the traction on the walls: pressure, and the shear stress.

    Two views from opposite corners; walls between the viewer and the fluid are left out, so that
    one sees the channel's inside.  Walls are the patches that do not slip.  Colours leave out a
    hundredth of the points, as traction may be singular at edges.  ``units`` are the units in
    labels (``length``, ``time``, ``pressure``).  Raises ``SelectionError`` when nothing is a wall,
    ``DisplayError`` where pictures cannot be drawn.
    """
    check_size(size)
    boundary = solution.space.boundary
    surface = tessellated(boundary, 6, {"traction": solution.traction}, _walls(solution))
    _add_stresses(surface)
    edges = sharp_edges(boundary)
    extent = surface.points.T
    views = (corner_view(extent), back_view(extent))
    panels = list(product(_QUANTITIES, views))
    bars = {}
    with sheet(path, size, len(panels), views[0].aspect(extent)) as plotter:
        for i, (quantity, view) in enumerate(panels):
            panel(plotter, i)
            bars[quantity] = _add_inside(plotter, surface, quantity)
            add_lines(plotter, edges, lifted(view, extent), width=1.5)
            aim(plotter, view, extent)
            add_axes(plotter)
        strip(plotter)
        for i, (quantity, actor) in enumerate(bars.items()):
            label = quantity_label(quantity, boundary.unit, units)
            colour_bar(plotter, actor, label, 0.24 + 0.4 * i, 0.3)
        unit = length_unit(boundary, units)
        add_text(plotter, size_label(extent, unit), (0.02, 0.72), scaled(plotter, SMALL))
    return Path(path)


def _walls(solution: WallSolution) -> Sequence[int]:
    conditions = solution.problem.conditions
    names = [name for name, condition in conditions.items() if isinstance(condition, NoSlip)]
    patches = solution.space.boundary.patches
    walls = [i for i, patch in enumerate(patches) if patch.name in names]
    if not walls:
        raise SelectionError("there are no walls to draw: no face has the condition NoSlip")
    return walls


def _add_stresses(surface: Any) -> None:
    traction: Array = np.asarray(surface.point_data["traction"]).T
    normal: Array = np.asarray(surface.point_data["Normals"]).T
    values = wall_stresses(traction, normal)
    surface.point_data.update(dict(zip(_QUANTITIES, values, strict=True)))


def _limits(quantity: str, values: Array) -> tuple[float, float]:
    low, high = np.percentile(values, [0.5, 99.5])
    return colour_limits(low if quantity == "pressure" else 0.0, high)


def _add_inside(plotter: Any, surface: Any, quantity: str) -> Any:
    """The faces that show their inner side, coloured by point data."""
    return plotter.add_mesh(
        surface.copy(deep=False),
        scalars=quantity,
        cmap=COLOUR_MAP,
        clim=_limits(quantity, surface.point_data[quantity]),
        culling="back",
        ambient=0.85,
        diffuse=0.15,
        smooth_shading=True,
        show_scalar_bar=False,
    )
