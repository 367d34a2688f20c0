"""The style of all pictures: colours, fonts, colour bars, units."""

from __future__ import annotations

import colorsys
from collections.abc import Sequence
from typing import Any

import numpy as np

from cadbem.boundary import Boundary
from cadbem.post.style.display import load_pyvista
from cadbem.spline.basis import Array
from cadbem.units import UnitNames

BACKGROUND = "#ffffff"
INK = "#1a1a1a"
WALL = "#d4d9de"
GLASS = "#f3f5f7"  # walls, seen as glass on paper
UNNAMED = "#f3e3bd"
OPENING = "#8fb8de"
DEFECT = "#d62728"
COLOUR_MAP = "viridis"
FONT = "arial"
# heights of letters in pixels of a sheet 1800 wide, legible when it fills the width of a page
TEXT, SMALL = 26, 22
LETTER = 0.56  # mean width of a letter over its height
# Okabe and Ito's colours, told apart by readers with colour blindness as well
PALETTE = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#9467bd", "#8c564b")


SPEEDS = ("speed", "velocity")
STRESSES = ("pressure", "traction", "traction jump", "jump", "wall shear stress")
# pale ones for the faces of one name, so that one sees where each ends
TINTS = ("#f3e3bd", "#cfe3f1", "#f6d2c1", "#cdebdd", "#f1dbe8", "#e3dcef", "#dfe8c4", "#ead9cf")


def colours_of(names: Sequence[str]) -> dict[str, str]:
    """A colour for each name: walls grey, patches without a name pale, ports in strong colours."""
    colours = {name: WALL for name in names if name.startswith("wall")}
    colours |= {name: UNNAMED for name in names if not name}
    ports = [name for name in names if name not in colours]
    return colours | dict(zip(ports, _palette(len(ports)), strict=True))


def _palette(count: int) -> list[str]:
    more = max(0, count - len(PALETTE))
    mixed = [colorsys.hls_to_rgb(i / more, 0.45 + 0.2 * (i % 2), 0.6) for i in range(more)]
    hexadecimal = ["#" + "".join(f"{round(255 * c):02x}" for c in rgb) for rgb in mixed]
    return [*PALETTE[:count], *hexadecimal]


def quantity_label(quantity: str, unit: str, units: UnitNames | None = None) -> str:
    """Label of a colour bar, with the quantity's unit, from ``units`` or, without them, from the
    ``unit`` of length.

    A CAD file knows a unit of length only; those of time and viscosity are the user's.
    """
    length, time, stress = unit, "time", "viscosity / time"
    if units is not None:
        length, time, stress = units.length, units.time, units.pressure
    known = {
        **dict.fromkeys(SPEEDS, f"{length} / {time}" if units is None else f"{length}/{time}"),
        **dict.fromkeys(STRESSES, stress),
        "mean curvature": f"1/{length}",
        "time": "" if units is None else time,
    }
    if not length:
        return f"{quantity} (dimensionless)" if quantity != "time" else quantity
    return f"{quantity} ({known[quantity]})" if known.get(quantity) else quantity


def length_unit(boundary: Boundary | None, units: UnitNames | None) -> str:
    """The name of the unit of length: from ``units``, else from the boundary's CAD file."""
    if units is not None:
        return units.length
    return "" if boundary is None else boundary.unit


def size_label(points: Array, unit: str) -> str:
    """Extent along x, y and z of points (3, N)."""
    extent = " × ".join(f"{length:.3g}" for length in np.ptp(points, axis=1))
    return f"x × y × z: {extent} {unit or '(dimensionless)'}"


def scaled(plotter: Any, pixels: float) -> int:
    """Pixels on this sheet for what has so many on a sheet 1800 wide and 1100 high."""
    width, height = plotter.window_size
    return max(1, round(pixels * min(width / 1800, height / 1100)))


def colour_bar(plotter: Any, actor: Any, title: str, left: float, width: float) -> None:
    """A horizontal colour bar in the panel drawn at present, a strip, for what ``actor`` shows.

    ``left`` and ``width`` in parts of the strip's width.
    """
    from vtkmodules.util.numpy_support import numpy_to_vtk

    bar = plotter.add_scalar_bar(
        title,
        mapper=actor.mapper,
        vertical=False,
        fmt="{:.6g}",
        color=INK,
        font_family=FONT,
        label_font_size=scaled(plotter, SMALL),
        unconstrained_font_size=True,
        position_x=left,
        position_y=0.25,
        width=width,
        height=0.4,
    )
    bar.SetTitle("")
    bar.SetTextPositionToPrecedeScalarBar()
    bar.SetTextPad(scaled(plotter, 6))
    bar.SetUseCustomLabels(True)
    bar.SetCustomLabels(numpy_to_vtk(round_values(*actor.mapper.scalar_range), deep=True))
    add_text(plotter, title, (left, 0.72), scaled(plotter, TEXT))


def colour_limits(low: float, high: float) -> tuple[float, float]:
    """Limits of the colours; rounding errors of a constant do not widen them."""
    room = 1e-3 * max(abs(low), abs(high), 1e-300)
    return (low, high) if high - low > room else (low - room, high + room)


def light_colours() -> Any:
    """The colours of all pictures without the dark ones, on which black lines are lost."""
    from matplotlib import colormaps
    from matplotlib.colors import ListedColormap

    return ListedColormap(colormaps[COLOUR_MAP](np.linspace(0.35, 1.0, 256)))


def sample_of(limits: tuple[float, float], colours: Any) -> Any:
    """An actor, not drawn, with colours from end to end: for the ``colour_bar`` of other things."""
    pyvista = load_pyvista()
    mesh = pyvista.Line()
    mesh.point_data["value"] = np.linspace(*limits, mesh.n_points)
    mapper = pyvista.DataSetMapper(mesh)
    mapper.lookup_table = pyvista.LookupTable(cmap=colours, scalar_range=limits)
    mapper.scalar_range = limits
    return pyvista.Actor(mapper=mapper)


def round_values(low: float, high: float, count: int = 5) -> Array:
    """About ``count`` values between two limits, multiples of 1, 2 or 5 times a power of ten."""
    if not high > low:
        return np.array([low])
    raw_step = (high - low) / count
    power = 10.0 ** np.floor(np.log10(raw_step))
    step = min((power, 2 * power, 5 * power, 10 * power), key=lambda s: abs(np.log(s / raw_step)))
    first, last = np.ceil(low / step - 1e-9), np.floor(high / step + 1e-9)
    return step * np.arange(first, last + 1) + 0.0  # no "-0"


def add_text(plotter: Any, text: str, position: tuple[float, float], letter: int) -> Any:
    """Text with letters of so many pixels, its lower left corner at parts of the panel."""
    actor = plotter.add_text(text, position=position, viewport=True, font=FONT, color=INK)
    actor.prop.font_size = letter
    return actor
