"""Legends of coloured names in the strip below the panels."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from cadbem.post.style.display import load_pyvista
from cadbem.post.style.layout import Size, strip
from cadbem.post.style.style import INK, LETTER, SMALL, add_text, scaled

# in heights of a letter
_SWATCH, _SPACE, _GAP, _LINE = 1.2, 0.35, 1.5, 1.6


def draw_legend(plotter: Any, colours: Mapping[str, str], note: str = "") -> None:
    """Names beside patches of their colours, row by row, and a ``note`` in the last row."""
    pyvista = load_pyvista()
    strip(plotter)
    size = plotter.renderer.GetSize()
    letter = scaled(plotter, SMALL)
    by_name = {name or "unnamed": colour for name, colour in colours.items()}
    rows = _rows(list(by_name), size[0], letter)
    line = min(_LINE * letter, size[1] / (len(rows) + bool(note) + 0.5))
    letter = min(letter, round(line / 1.3))  # many names: smaller letters instead of overlaps
    for i, row in enumerate(rows):
        bottom = size[1] - (i + 1) * line
        for left, name in row:
            right = left + _SWATCH * letter
            swatch = pyvista.Box((left, right, bottom, bottom + 0.8 * letter, 0, 0))
            plotter.add_mesh(swatch, color=by_name[name], lighting=False)
            plotter.add_mesh(swatch.extract_feature_edges(), color=INK, line_width=1)
            _write(plotter, name, (right + _SPACE * letter, bottom), letter)
    if note:
        _write(plotter, note, (_GAP * letter, size[1] - (len(rows) + 1) * line), letter)
    _use_pixels(plotter, size)


def _rows(names: list[str], width: int, letter: int) -> list[list[tuple[float, str]]]:
    """Left ends and names, in as many rows as the width requires."""
    rows: list[list[tuple[float, str]]] = [[]]
    left = _GAP * letter
    for name in names:
        needed = (_SWATCH + _SPACE + LETTER * len(name) + _GAP) * letter
        if rows[-1] and left + needed > width:
            rows.append([])
            left = _GAP * letter
        rows[-1].append((left, name))
        left += needed
    return rows


def _write(plotter: Any, text: str, corner: tuple[float, float], letter: int) -> None:
    width, height = plotter.renderer.GetSize()
    add_text(plotter, text, (corner[0] / width, corner[1] / height), letter)


def _use_pixels(plotter: Any, size: Size) -> None:
    """Let one unit of length in the panel be one pixel."""
    middle = (0.5 * size[0], 0.5 * size[1])
    plotter.camera_position = [(*middle, 10.0), (*middle, 0.0), (0, 1, 0)]
    plotter.enable_parallel_projection()
    plotter.camera.parallel_scale = 0.5 * size[1]
    plotter.renderer.reset_camera_clipping_range()
