"""Plots of measures of bodies over time: one panel for each quantity, one colour for each body."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from cadbem.checks import shaped
from cadbem.errors import ShapeError
from cadbem.post.bodies.bodies import LEGIBLE, body_colour
from cadbem.post.files.export import prepared
from cadbem.post.style.style import INK, quantity_label
from cadbem.units import UnitNames

Column = ArrayLike | Mapping[int, ArrayLike]
WIDTH, HEIGHT = 6.0, 2.6  # inches of a panel
TALL = 3  # panels above each other


def draw_series(
    path: str | Path,
    times: ArrayLike,
    columns: Mapping[str, Column],
    *,
    units: UnitNames | None = None,
) -> Path:
    """Plots over ``times`` (N,), one below the other, of quantities by their labels.

    A quantity is given by its values (N,), or by those of each body by its number, which chooses
    the colour that it has in ``draw_movie``; nan where a body is not there.  ``units`` name the
    units of time and of quantities that have a name of their own, such as "speed" or "pressure".
    Raises ``ShapeError`` when values are not as many as times.
    """
    shaped("times", times, None)
    from matplotlib.figure import Figure

    moments = np.asarray(times, dtype=float)
    if not columns:
        raise ShapeError("no series to draw: give at least one quantity")
    across = -(-len(columns) // TALL)
    down = -(-len(columns) // across)
    figure = Figure(figsize=(WIDTH * across, HEIGHT * down + 0.6), layout="constrained")
    grid = figure.subplots(down, across, sharex=True, squeeze=False).T.ravel()
    bodies: dict[int, Any] = {}
    for axes, (label, column) in zip(grid, columns.items(), strict=False):
        _add_quantity(axes, moments, label, column, bodies)
        axes.set_ylabel(label if units is None else quantity_label(label, units.length, units))
        axes.grid(alpha=0.3)
    for axes in grid[len(columns) :]:
        axes.remove()
    time = f"t ({units.time})" if units is not None and units.time else "t"
    for place, axes in enumerate(grid[: len(columns)]):
        if place % down == down - 1 or place == len(columns) - 1:
            axes.set_xlabel(time)
            axes.tick_params(labelbottom=True)
    _add_legend(figure, bodies)
    figure.savefig(target := prepared(path), dpi=150)
    return target


def _add_quantity(
    axes: Any, times: np.ndarray, label: str, column: Column, bodies: dict[int, Any]
) -> None:
    """Lines of a quantity; those of bodies are added to ``bodies``."""
    if not isinstance(column, Mapping):
        axes.plot(times, _values(label, column, times), color=INK)
        return
    for number, values in column.items():
        name = f"{label}, body {number}"
        (line,) = axes.plot(times, _values(name, values, times), color=body_colour(number))
        bodies.setdefault(number, line)


def _values(name: str, values: ArrayLike, times: np.ndarray) -> np.ndarray:
    found = np.asarray(values, dtype=float)
    if found.shape != times.shape:
        raise ShapeError(
            f"the series '{name}' has values of shape {found.shape}, the times {times.shape}; "
            "give one value a time, nan where there is none"
        )
    return found


def _add_legend(figure: Any, bodies: Mapping[int, Any]) -> None:
    """Bodies by number, or their count when there are many."""
    if 0 < len(bodies) <= LEGIBLE:
        names = [f"body {number}" for number in bodies]
        figure.legend(bodies.values(), names, loc="outside lower center", ncols=4, frameon=False)
    elif bodies:
        figure.supxlabel(f"{len(bodies)} bodies, each in its colour", fontsize="medium")
