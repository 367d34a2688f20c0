"""Polygons of a GDS file, through gdstk: cells are resolved, polygons that overlap are united, and
corners that lie on circles become arcs."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from cadbem.cad.drawings.drawing import Drawing, DrawnCurve
from cadbem.cad.drawings.rounding import rounded
from cadbem.cad.text.unit import Unit
from cadbem.errors import CadError
from cadbem.spline.basis import Array

NAMES = {"um": 1e-6, "nm": 1e-9, "mm": 1e-3, "cm": 1e-2, "m": 1.0}  # metres


def read_gds(path: Path) -> Drawing:
    """All polygons of the only top cell; raises CadError for files that gdstk cannot read."""
    import gdstk

    try:
        library = gdstk.read_gds(path)
    except (RuntimeError, OSError, ValueError) as error:
        raise CadError(f"{path.name}: cannot be read as GDS ({error}); save it again") from None
    tops: list[Any] = library.top_level()
    if len(tops) != 1:
        names = ", ".join(sorted(cell.name for cell in tops)) or "none"
        raise CadError(f"{path.name}: top cells are {names}; export the chip's cell alone")
    unit, grid = _unit(library.unit), library.precision / library.unit
    polygons: dict[str, list[Any]] = {}
    for polygon in tops[0].get_polygons():
        polygons.setdefault(f"{polygon.layer}/{polygon.datatype}", []).append(polygon)
    if not polygons:
        raise CadError(f"{path.name}: there are no polygons in it")
    curves: list[DrawnCurve] = []
    count = 0
    for layer, parts in polygons.items():
        for ring in _outlines(gdstk.boolean(parts, [], "or", precision=0.1 * grid), grid):
            pieces, arcs = rounded(ring, grid)
            curves += [DrawnCurve(piece, layer) for piece in pieces]
            count += arcs
    said = f"{path.name}: corners on {count} arcs of circles were taken for arcs, and no corners"
    return Drawing(path.name, unit, tuple(curves), (said,) if count else ())


def _unit(metres: float) -> Unit:
    for name, size in NAMES.items():
        if abs(metres - size) < 1e-6 * size:
            return Unit(name, 1e3 * size)
    return Unit(f"{metres:g} m", 1e3 * metres)


def _outlines(polygons: list[Any], grid: float) -> list[Array]:
    """Rings (n, 2) of polygons, without the slits that join holes to what is around them."""
    rings = []
    for polygon in polygons:
        keys = np.round(polygon.points / grid).astype(np.int64)
        keys = keys[(keys != np.roll(keys, 1, axis=0)).any(axis=1)]
        edges = {(tuple(a), tuple(b)) for a, b in zip(keys, np.roll(keys, -1, axis=0), strict=True)}
        after: dict[tuple, list[tuple]] = {}
        for a, b in sorted(edges):
            if (b, a) not in edges:
                after.setdefault(a, []).append(b)
        while after:
            start = here = min(after)
            ring = []
            while True:
                ring.append(here)
                there = after[here].pop()
                if not after[here]:
                    del after[here]
                here = there
                if here == start:
                    break
            rings.append(_without_straight_corners(np.array(ring)) * grid)
    return rings


def _without_straight_corners(ring: Array) -> Array:
    """Corners (n, 2), integers, at which a polygon turns."""
    after = np.roll(ring, -1, axis=0) - ring
    before = np.roll(after, 1, axis=0)
    return ring[before[:, 0] * after[:, 1] != before[:, 1] * after[:, 0]]
