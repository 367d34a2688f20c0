"""OpenCASCADE's `.brep` text: the model's faces with surface, loops, orientation and location.

The kernel writes 17 digits, so nothing is lost. The composed orientation solid → shell → face says
whether ∂u × ∂v of the *located* surface points out; a location that mirrors is no exception.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from cadbem.cad.kernel.brep_geometry import (
    CurveRecord,
    SurfaceRecord,
    Tokens,
    read_curve,
    read_surface,
)
from cadbem.errors import CadError

VERTEX, EDGE, WIRE, FACE, SHELL, SOLID = "Ve", "Ed", "Wi", "Fa", "Sh", "So"
_SIGNS = {"+": 1, "-": -1, "i": 0, "e": 0}  # internal and external: bound nothing


@dataclass(frozen=True, eq=False)
class EdgeUse:
    """One pass of a face's loop along an edge, in world coordinates."""

    key: tuple  # the same for every use of the shared edge
    curve: CurveRecord | None  # None where the edge is a point (a pole)
    interval: tuple[float, float]
    matrix: np.ndarray  # (4, 4) location of the curve
    parameter_curves: tuple[CurveRecord, ...]  # on the face's surface; two on a seam
    sign: int  # +1 if the loop runs along the curve
    ends: np.ndarray  # (2, 3) vertices of the edge, as the curve runs (equal if closed)


@dataclass(frozen=True, eq=False)
class BrepFace:
    """A face: a piece of `surface` inside `loops`."""

    number: int  # 1-based, in the order of the record
    solid: int  # 1-based number of its solid, 0 if it belongs to none
    surface: SurfaceRecord
    matrix: np.ndarray  # (4, 4) location of the surface
    outward: int  # +1 if ∂u × ∂v of the located surface points out of the solid; 0: bounds nothing
    loops: tuple[tuple[EdgeUse, ...], ...]
    key: tuple = ()  # the same for the face that two solids share


@dataclass(frozen=True)
class _Use:
    shape: int
    sign: int
    location: int


@dataclass(frozen=True)
class _Shape:
    kind: str
    data: tuple
    parts: tuple[_Use, ...]


@dataclass(frozen=True, eq=False)
class _Record:
    locations: list[np.ndarray]
    curves_2d: list[CurveRecord]
    curves: list[CurveRecord]
    surfaces: list[SurfaceRecord]
    shapes: list[_Shape]
    roots: tuple[_Use, ...]


def read_brep(text: str) -> list[BrepFace]:
    """All faces of a `.brep` text, those of solids first.

    Raises CadError if the record ends too early.
    """
    record = _read_record(text)
    found = [use for root in record.roots for use in _faces(record, root, np.eye(4), 1, 0, [0])]
    found.sort(key=lambda item: item[3] == 0)
    return [_face(record, number, *item) for number, item in enumerate(found, start=1)]


def _read_record(text: str) -> _Record:
    # the second parameter curve of a seam is glued to the continuity, as in `4CN`
    words = re.sub(r"(?<=\d)(C\d|CN|G1|G2)(?=\s)", r" \1", text).split()
    tokens = Tokens(words)
    locations = _read_locations(tokens)
    curves_2d = [read_curve(tokens, 2) for _ in range(tokens.count_after("Curve2ds"))]
    curves = [read_curve(tokens, 3) for _ in range(tokens.count_after("Curves"))]
    surfaces = [read_surface(tokens) for _ in range(tokens.count_after("Surfaces"))]
    count = tokens.count_after("TShapes")
    shapes = [_read_shape(tokens, count) for _ in range(count)]
    roots = _read_uses(tokens, count, last=True)
    # shapes are referred to by N - k + 1, written parts first
    return _Record(locations, curves_2d, curves, surfaces, shapes, roots)


def _read_locations(tokens: Tokens) -> list[np.ndarray]:
    locations = [np.eye(4)]
    for _ in range(tokens.count_after("Locations")):
        matrix = np.eye(4)
        if tokens.integer() == 1:
            matrix[:3] = tokens.numbers(12).reshape(3, 4)
        else:
            while (index := tokens.integer()) != 0:
                # the kernel writes the innermost placement first
                matrix = np.linalg.matrix_power(locations[index], tokens.integer()) @ matrix
        locations.append(matrix)
    return locations


def _read_shape(tokens: Tokens, count: int) -> _Shape:
    kind = tokens.word()
    if kind == VERTEX:
        data = _read_vertex(tokens)
    elif kind == EDGE:
        data = _read_edge(tokens)
    elif kind == FACE:
        data = _read_face(tokens)
    else:
        data = ()
        tokens.word()  # the seven flags
    return _Shape(kind, data, _read_uses(tokens, count))


def _read_vertex(tokens: Tokens) -> tuple:
    tokens.number()
    point = tokens.numbers(3)
    while True:  # the vertex on curves and surfaces: not needed
        tokens.number()
        kind = tokens.integer()
        if kind == 0:
            break
        tokens.numbers({1: 2, 2: 3, 3: 3}[kind])
    tokens.word()
    return (point,)


def _read_edge(tokens: Tokens) -> tuple:
    """(curve (index, location, first, last) or None, [(curves, surface, location, first, last)])"""
    tokens.numbers(4)  # tolerance, same parameter, same range, degenerated
    curve, on_surfaces = None, []
    while (kind := tokens.integer()) != 0:
        if kind == 1:
            curve = (tokens.integer(), tokens.integer(), tokens.number(), tokens.number())
        elif kind in (2, 3):
            indices = [tokens.integer() for _ in range(kind - 1)]
            if kind == 3:
                tokens.word()  # continuity across the seam
            surface, location = tokens.integer(), tokens.integer()
            curve_range = (tokens.number(), tokens.number())
            on_surfaces.append((tuple(indices), surface, location, *curve_range))
        else:  # continuity between two surfaces; polygons
            for _ in range({4: 5, 5: 2, 6: 3, 7: 4}[kind]):
                tokens.word()
    tokens.word()
    return (curve, on_surfaces)


def _read_face(tokens: Tokens) -> tuple:
    tokens.word()
    tokens.number()
    surface, location = tokens.integer(), tokens.integer()
    if tokens.word() == "2":  # the index of a triangulation, then the flags
        tokens.word()
        tokens.word()
    return (surface, location)


def _read_uses(tokens: Tokens, count: int, last: bool = False) -> tuple[_Use, ...]:
    uses = []
    try:
        while (word := tokens.word()) not in ("*", "0"):
            location = tokens.integer()
            uses.append(_Use(count - int(word[1:]), _SIGNS[word[0]], location))
    except CadError:
        if not last:
            raise
    return tuple(uses)


def _faces(
    record: _Record, use: _Use, matrix: np.ndarray, sign: int, solid: int, counter: list[int]
) -> Iterator[tuple]:
    shape = record.shapes[use.shape]
    matrix, sign = matrix @ record.locations[use.location], sign * use.sign
    if shape.kind == FACE:
        yield use.shape, matrix, sign, solid
        return
    if shape.kind == SOLID:
        counter[0] += 1
        solid = counter[0]
    for part in shape.parts:
        yield from _faces(record, part, matrix, sign, solid, counter)


def _face(
    record: _Record, number: int, index: int, matrix: np.ndarray, sign: int, solid: int
) -> BrepFace:
    shape = record.shapes[index]
    surface_index, surface_location = shape.data
    located = matrix @ record.locations[surface_location]
    loops = tuple(
        _loop(record, wire, matrix, surface_index, located)
        for wire in shape.parts
        if wire.sign and record.shapes[wire.shape].kind == WIRE
    )
    surface = record.surfaces[surface_index - 1]
    return BrepFace(number, solid, surface, located, sign, loops, _key(index, matrix))


def _key(shape: int, matrix: np.ndarray) -> tuple:
    return (shape, *(np.round(matrix[:3].ravel(), 9) + 0.0))


def _loop(
    record: _Record, wire: _Use, matrix: np.ndarray, surface: int, located: np.ndarray
) -> tuple[EdgeUse, ...]:
    wire_matrix = matrix @ record.locations[wire.location]
    return tuple(
        _edge_use(record, edge, wire_matrix, wire.sign, surface, located)
        for edge in record.shapes[wire.shape].parts
        if edge.sign
    )


def _edge_use(
    record: _Record, use: _Use, matrix: np.ndarray, sign: int, surface: int, located: np.ndarray
) -> EdgeUse:
    matrix = matrix @ record.locations[use.location]
    curve, on_surfaces = record.shapes[use.shape].data
    indices, interval = _on_surface(record, on_surfaces, matrix, surface, located)
    parameter_curves = tuple(record.curves_2d[index - 1] for index in indices)
    curve_matrix, curve_record = matrix, None
    if curve is not None and curve[0] > 0:
        curve_record, interval = record.curves[curve[0] - 1], curve[2:]
        curve_matrix = matrix @ record.locations[curve[1]]
    return EdgeUse(
        _key(use.shape, matrix), curve_record, interval, curve_matrix, parameter_curves,
        sign * use.sign, _ends(record, use.shape, matrix),
    )  # fmt: skip


def _on_surface(
    record: _Record, candidates: list, matrix: np.ndarray, surface: int, located: np.ndarray
) -> tuple[tuple[int, ...], tuple[float, float]]:
    for indices, index, location, first, last in candidates:
        same_place = np.allclose(matrix @ record.locations[location], located, atol=1e-9)
        if index == surface and same_place:
            return indices, (first, last)
    return (), (0.0, 0.0)


def _ends(record: _Record, edge: int, matrix: np.ndarray) -> np.ndarray:
    """First (forward) and last (reversed) vertex of the edge."""
    ends: dict[int, np.ndarray] = {}
    for use in record.shapes[edge].parts:
        if use.sign == 0:
            continue
        place = matrix @ record.locations[use.location]
        ends[use.sign] = place[:3, :3] @ record.shapes[use.shape].data[0] + place[:3, 3]
    if not ends:
        return np.full((2, 3), np.nan)
    first = ends.get(1, next(iter(ends.values())))
    return np.array([first, ends.get(-1, first)])
