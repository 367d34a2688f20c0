"""How every picture looks: colours, fonts, colour bars, units."""

from __future__ import annotations

import colorsys
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from cadbem.spline.basis import Array

BACKGROUND = "#ffffff"
INK = "#1a1a1a"
WALL = "#d4d9de"
UNNAMED = "#f3e3bd"
DEFECT = "#d62728"
COLOUR_MAP = "viridis"
FONT = "arial"
# heights of letters in pixels, legible when a picture fills the width of a page
TITLE, TEXT, SMALL = 30, 26, 22
# Okabe and Ito's colours, told apart by readers with colour blindness as well
PALETTE = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#9467bd", "#8c564b")


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


def quantity_label(quantity: str, unit: str) -> str:
    """Label of a colour bar, with the quantity's unit, from the ``unit`` of length.

    A CAD file knows a unit of length only; those of time and viscosity are the user's.
    """
    units = {"speed": f"{unit} / time"}
    return f"{quantity} ({units.get(quantity, 'viscosity / time') if unit else 'dimensionless'})"


def size_label(points: Array, unit: str) -> str:
    """Extent along x, y and z of points (3, N)."""
    extent = " × ".join(f"{length:.3g}" for length in np.ptp(points, axis=1))
    return f"x × y × z: {extent} {unit or '(dimensionless)'}"


def colour_bar(plotter: Any, actor: Any, title: str, place: Mapping[str, float]) -> None:
    """A horizontal colour bar for what ``actor`` shows, in the panel that is drawn at present."""
    plotter.add_scalar_bar(
        title,
        mapper=actor.mapper,
        vertical=False,
        n_labels=5,
        fmt="{:.3g}",
        color=INK,
        font_family=FONT,
        title_font_size=TEXT,
        label_font_size=SMALL,
        **place,
    )


def add_text(plotter: Any, text: str, position: tuple[float, float], size: int = TEXT) -> None:
    """Text whose lower left corner lies at a ``position`` in parts of the panel."""
    actor = plotter.add_text(text, position=position, viewport=True, font=FONT, color=INK)
    actor.prop.font_size = size
