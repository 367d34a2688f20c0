"""Legends of coloured names in the strip below the panels."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from cadbem.post.display import load_pyvista
from cadbem.post.layout import Size, strip
from cadbem.post.style import INK, SMALL, add_text

_SWATCH, _GAP = 26, 34  # pixels
_LETTER = 0.56  # mean width of a letter over its height


def draw_legend(plotter: Any, colours: Mapping[str, str], note: str = "") -> None:
    """Names beside patches of their colours, row by row, and a ``note`` in the last row."""
    pyvista = load_pyvista()
    strip(plotter)
    size = plotter.renderer.GetSize()
    rows = _rows([name or "unnamed" for name in colours], size[0])
    line = min(1.6 * SMALL, size[1] / (len(rows) + bool(note)))
    by_name = {name or "unnamed": colour for name, colour in colours.items()}
    for i, row in enumerate(rows):
        bottom = size[1] - (i + 1) * line
        for left, name in row:
            box = (left, left + _SWATCH, bottom, bottom + 0.8 * SMALL, 0, 0)
            plotter.add_mesh(
                pyvista.Box(box),
                color=by_name[name],
                lighting=False,
                show_edges=True,
                edge_color=INK,
            )
            _write(plotter, name, left + _SWATCH + 8, bottom, size)
    if note:
        _write(plotter, note, _GAP, size[1] - (len(rows) + 1) * line, size)
    _use_pixels(plotter, size)


def _rows(names: list[str], width: int) -> list[list[tuple[float, str]]]:
    """Left ends and names, in as many rows as the width asks for."""
    rows: list[list[tuple[float, str]]] = [[]]
    left = float(_GAP)
    for name in names:
        needed = _SWATCH + 8 + _LETTER * SMALL * len(name) + _GAP
        if rows[-1] and left + needed > width:
            rows.append([])
            left = float(_GAP)
        rows[-1].append((left, name))
        left += needed
    return rows


def _write(plotter: Any, text: str, left: float, bottom: float, size: Size) -> None:
    add_text(plotter, text, (left / size[0], bottom / size[1]), SMALL)


def _use_pixels(plotter: Any, size: Size) -> None:
    """Let one unit of length in the panel be one pixel."""
    middle = (0.5 * size[0], 0.5 * size[1])
    plotter.camera_position = [(*middle, 10.0), (*middle, 0.0), (0, 1, 0)]
    plotter.enable_parallel_projection()
    plotter.camera.parallel_scale = 0.5 * size[1]
    plotter.renderer.reset_camera_clipping_range()
