"""Unit, and names (labels), levels and colours of faces, from an IGES file's text (version 5.3)."""

from __future__ import annotations

import re
from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial import cKDTree

from cadbem.cad.faces.curves import spline_nurbs
from cadbem.cad.kernel.brep_geometry import SplineRecord
from cadbem.cad.labels.face_labels import FaceLabel
from cadbem.cad.text.iges_syntax import check_parameters, number, sections, words
from cadbem.cad.text.step_styles import colour_code
from cadbem.cad.text.unit import Unit
from cadbem.spline.basis import Array

_UNITS = {
    1: Unit("inch", 25.4),
    2: Unit("mm", 1.0),
    4: Unit("ft", 304.8),
    5: Unit("mile", 1609344.0),
    6: Unit("m", 1000.0),
    7: Unit("km", 1e6),
    8: Unit("mil", 0.0254),
    9: Unit("um", 1e-3),
    10: Unit("cm", 10.0),
    11: Unit("microinch", 2.54e-5),
}
_UNIT_NAMES = {"IN": 1, "INCH": 1, "MM": 2, "FT": 4, "MI": 5, "M": 6, "KM": 7, "MIL": 8,
               "UM": 9, "CM": 10, "UIN": 11}  # fmt: skip
_COLOURS = ("", "#000000", "#ff0000", "#00ff00", "#0000ff", "#ffff00", "#ff00ff", "#00ffff",
            "#ffffff")  # fmt: skip
RAGGED = 0.02  # gap in a loop, per size of it, that nobody repairs
_LINE, _ARC, _CONIC, _COMPOSITE, _SPLINE, _MATRIX = 110, 100, 104, 102, 126, 124
_CURVE_ON_SURFACE, _TRIMMED, _BOUNDARY, _BOUNDED = 142, 144, 141, 143
_Edge = tuple[Array, Array, Array]  # both ends and a point between


@dataclass(frozen=True)
class _Entity:
    kind: int
    label: str
    level: int  # 0: none; negative: number of the entity that lists several
    colour: int  # 0: none; up to 8: a standard one; negative: number of the entity that defines it
    matrix: int
    parameters: tuple[str, ...]

    def reference(self, index: int) -> int:
        return abs(int(float(self.parameters[index] or 0)))

    def numbers(self, start: int, count: int) -> Array:
        return np.array([number(word) for word in self.parameters[start : start + count]])


class IgesText:
    """The file's entities, by the number of their first directory line."""

    def __init__(self, text: str) -> None:
        lines = sections(text)
        header = "".join(line[:72].ljust(72) for line in lines["G"])
        self._delimiters = _delimiters(header)
        self._header = words(header, *self._delimiters) + [""] * 15
        rows: dict[int, list[str]] = {}
        for line in lines["P"]:
            rows.setdefault(int(line[64:72]), []).append(line[:64].ljust(64))
        directory = lines["D"]
        self._entities = {
            2 * index + 1: self._entity(2 * index + 1, *pair, rows.pop(2 * index + 1, []))
            for index, pair in enumerate(zip(directory[::2], directory[1::2], strict=True))
        }
        if rows:
            raise ValueError(f"parameters of an entity {next(iter(rows))} that is not there")

    def _entity(self, index: int, first: str, second: str, rows: list[str]) -> _Entity:
        label, subscript = second[56:64].strip(), second[64:72].strip()
        name = label + (subscript if label and subscript != "0" else "")
        level, matrix, colour, count = (
            int(field.strip() or 0)
            for field in (first[32:40], first[48:56], second[16:24], second[24:32])
        )
        kind = int(first[:8])
        place = f"entity {index} (type {kind})"
        if len(rows) != count or int(second[:8]) != kind:
            raise ValueError(f"{place} has {len(rows)} lines of parameters instead of {count}")
        parameters = words("".join(rows), *self._delimiters)
        if kind:
            check_parameters(kind, place, parameters)
        return _Entity(kind, name, level, colour, matrix, tuple(parameters))

    def unit(self) -> Unit:
        """The unit of length (global parameters 14 and 15); inches where nothing is said."""
        flag, name = self._header[13], _UNIT_NAMES.get(self._unit_name())
        if flag == "" and name is None:
            return replace(_UNITS[1], assumed=True)
        value = int(number(flag or "1"))
        return _UNITS[(name or 2) if value == 3 else value]

    def _unit_name(self) -> str:
        return self._header[14].removeprefix("'").strip().upper()

    def remarks(self) -> list[str]:
        """Warnings about the text, which can be read nevertheless."""
        name, unit = _UNIT_NAMES.get(self._unit_name()), self.unit()
        if name is None or unit.assumed or _UNITS[name] == unit:
            return []
        return [f"the unit is {unit.name} by its number but {_UNITS[name].name} by its name; "
                f"{unit.name} is taken"]  # fmt: skip

    def faces(self) -> list[FaceLabel]:
        """Every trimmed or bounded surface with its corners and a point on each edge."""
        labels = []
        for entity in self._entities.values():
            if entity.kind in (_TRIMMED, _BOUNDED):
                surface = self._entities[entity.reference(1 if entity.kind == _TRIMMED else 2)]
                around = self._loops(entity)
                loops = [[edge for c in loop for edge in self._edges(c)] for loop in around]
                for loop, loop_edges in zip(around, loops, strict=True):
                    _check_closed(loop_edges, f"curve {loop[0]}")
                edges = [edge for loop_edges in loops for edge in loop_edges]
                corners = np.array([point for edge in edges for point in edge[:2]]).reshape(-1, 3)
                middles = np.array([edge[2] for edge in edges]).reshape(-1, 3)
                name = entity.label or surface.label
                layer = self._layer(entity.level or surface.level)
                colour = self._colour(entity.colour or surface.colour)
                labels.append(FaceLabel(name, corners, middles, layer, colour))
        return labels

    def _layer(self, level: int) -> str:
        """A level's number; the first one of several."""
        if level < 0:
            level = self._entities[-level].reference(2)
        return str(level) if level else ""

    def _colour(self, colour: int) -> str:
        if colour >= 0:
            return _COLOURS[colour]
        return colour_code(*self._entities[-colour].numbers(1, 3) / 100)

    def _loops(self, face: _Entity) -> list[list[int]]:
        """Model-space curves round the face; a boundary may list those of its loop one by one."""
        if face.kind == _TRIMMED:
            count = face.reference(3) + 1
            curves = [face.reference(4 + k) for k in range(count)]
            return [[self._entities[c].reference(4)] for c in curves if c]
        loops = []
        for k in range(face.reference(3)):
            boundary, position = self._entities[face.reference(4 + k)], 5
            loop = []
            for _ in range(boundary.reference(4)):
                loop.append(boundary.reference(position))
                position += 3 + boundary.reference(position + 2)
            loops += [loop] if loop else []
        return loops

    def _edges(self, number: int) -> list[_Edge]:
        entity = self._entities.get(number)
        if entity is None:
            return []
        if entity.kind == _COMPOSITE:
            parts = [entity.reference(2 + k) for k in range(entity.reference(1))]
            return [edge for part in parts for edge in self._edges(part)]
        shapes = {_LINE: _line, _ARC: _arc, _CONIC: _conic, _SPLINE: _spline}
        if entity.kind not in shapes:
            return []
        start, end, middle = shapes[entity.kind](entity)
        return [(self._placed(entity, start), self._placed(entity, end),
                 self._placed(entity, middle))]  # fmt: skip

    def _placed(self, entity: _Entity, point: Array) -> Array:
        transformation = self._entities.get(entity.matrix)
        if transformation is None or transformation.kind != _MATRIX:
            return point
        matrix = transformation.numbers(1, 12).reshape(3, 4)
        return self._placed(transformation, matrix[:, :3] @ point + matrix[:, 3])


def _check_closed(edges: list[_Edge], place: str) -> None:
    """Raises ValueError if an end of an edge lies far from all others; the kernel's repair of such
    loops may never end."""
    ends = np.array([point for edge in edges for point in edge[:2]])
    if not len(ends):
        return
    gaps = cKDTree(ends).query(ends, k=2)[0][:, 1]
    size = np.ptp(np.array(edges).reshape(-1, 3), axis=0).max()
    if gaps.max() > RAGGED * size:
        raise ValueError(f"{place} round a face is not closed")


def _line(entity: _Entity) -> _Edge:
    start, end = entity.numbers(1, 6).reshape(2, 3)
    return start, end, 0.5 * (start + end)


def _arc(entity: _Entity) -> _Edge:
    height, *flat = entity.numbers(1, 7)
    centre, start, end = np.array(flat).reshape(3, 2)
    angles = [np.arctan2(*(p - centre)[::-1]) for p in (start, end)]
    turn = (angles[1] - angles[0]) % (2 * np.pi)
    middle = angles[0] + 0.5 * (turn if turn > 1e-9 else 2 * np.pi)
    radius = np.linalg.norm(start - centre)
    points = [start, end, centre + radius * np.array([np.cos(middle), np.sin(middle)])]
    return tuple(np.append(point, height) for point in points)  # type: ignore[return-value]


def _conic(entity: _Entity) -> _Edge:
    height, *flat = entity.numbers(7, 5)
    start, end = (np.append(point, height) for point in np.array(flat).reshape(2, 2))
    return start, end, 0.5 * (start + end)


def _spline(entity: _Entity) -> _Edge:
    top, degree = entity.reference(1), entity.reference(2)
    knot_count = top + degree + 2
    knots = entity.numbers(7, knot_count)
    weights = entity.numbers(7 + knot_count, top + 1)
    points = entity.numbers(8 + knot_count + top, 3 * (top + 1)).reshape(-1, 3)
    first, last = entity.numbers(8 + knot_count + top + 3 * (top + 1), 2)
    record = SplineRecord((degree,), (knots,), points, weights, (False,))
    curve = spline_nurbs(record, ((first, last),))
    return curve.points[0], curve.points[-1], points.mean(axis=0)


def _delimiters(header: str) -> tuple[str, str]:
    """The first two global parameters, written `1H,` and `1H;` or left out."""
    match = re.match(r"(?:1H(.))?(.)(?:1H(.))?", header)
    assert match is not None
    return match[1] or ",", match[3] or ";"
