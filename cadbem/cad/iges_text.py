"""Unit and face names (entity labels) from the text of an IGES file (version 5.3)."""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np

from cadbem.cad.brep_geometry import SplineRecord
from cadbem.cad.curves import spline_nurbs
from cadbem.cad.marks import FaceMark, Unit
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
_LINE, _ARC, _CONIC, _COMPOSITE, _SPLINE, _MATRIX = 110, 100, 104, 102, 126, 124
_CURVE_ON_SURFACE, _TRIMMED, _BOUNDARY, _BOUNDED = 142, 144, 141, 143
_Edge = tuple[Array, Array, Array]  # both ends and a point between


@dataclass(frozen=True)
class _Entity:
    kind: int
    label: str
    matrix: int
    parameters: tuple[str, ...]

    def reference(self, index: int) -> int:
        return abs(int(float(self.parameters[index] or 0)))

    def numbers(self, start: int, count: int) -> Array:
        words = self.parameters[start : start + count]
        return np.array([float(word.upper().replace("D", "E") or 0) for word in words])


class IgesText:
    """The file's entities, by the number of their first directory line."""

    def __init__(self, text: str) -> None:
        lines = text.splitlines()
        sections = {key: [line for line in lines if line[72:73] == key] for key in "GDP"}
        header = "".join(line[:72].ljust(72) for line in sections["G"])
        self._delimiters = _delimiters(header)
        self._header = _words(header, *self._delimiters)
        rows: dict[int, list[str]] = {}
        for line in sections["P"]:
            rows.setdefault(int(line[64:72]), []).append(line[:64].ljust(64))
        directory = sections["D"]
        self._entities = {
            int(first[73:80]): self._entity(first, second, rows.get(int(first[73:80]), []))
            for first, second in zip(directory[::2], directory[1::2], strict=False)
        }

    def _entity(self, first: str, second: str, rows: list[str]) -> _Entity:
        label, subscript = second[56:64].strip(), second[64:72].strip()
        name = label + (subscript if label and subscript != "0" else "")
        matrix = int(first[48:56].strip() or 0)
        words = _words("".join(rows), *self._delimiters)
        return _Entity(int(first[:8]), name, matrix, tuple(words))

    def unit(self) -> Unit:
        """The unit of length (global parameters 14 and 15); inches where nothing is said."""
        words = self._header + [""] * 15
        flag = int(float(words[13] or 1))
        if flag == 3:
            flag = _UNIT_NAMES.get(words[14].strip().upper(), 2)
        return _UNITS.get(flag, _UNITS[2])

    def faces(self) -> list[FaceMark]:
        """Every trimmed or bounded surface with its corners and a point on each edge."""
        marks = []
        for entity in self._entities.values():
            if entity.kind in (_TRIMMED, _BOUNDED):
                surface = entity.reference(1 if entity.kind == _TRIMMED else 2)
                name = entity.label or self._entities[surface].label
                edges = [edge for loop in self._loops(entity) for edge in self._edges(loop)]
                corners = np.array([point for edge in edges for point in edge[:2]])
                middles = np.array([edge[2] for edge in edges])
                marks.append(FaceMark(name, corners.reshape(-1, 3), middles.reshape(-1, 3)))
        return marks

    def _loops(self, face: _Entity) -> list[int]:
        """Model-space curves round the face."""
        if face.kind == _TRIMMED:
            count = face.reference(3) + 1
            curves = [face.reference(4 + k) for k in range(count)]
            return [self._entities[c].reference(4) for c in curves if c]
        loops = []
        for k in range(face.reference(3)):
            boundary, position = self._entities[face.reference(4 + k)], 5
            for _ in range(boundary.reference(4)):
                loops.append(boundary.reference(position))
                position += 3 + boundary.reference(position + 2)
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


def _words(text: str, separator: str, end: str) -> list[str]:
    """Parameters up to the end of the record; strings (`5Habc,d`) may hold separators."""
    words, position = [], 0
    while position < len(text):
        string = re.compile(r" *(\d+)H").match(text, position)
        if string:
            stop = string.end() + int(string[1])
            word, position = text[string.end() : stop], stop
        else:
            stop = min((i for c in (separator, end) if (i := text.find(c, position)) >= 0),
                       default=len(text))  # fmt: skip
            word, position = text[position:stop].strip(), stop
        words.append(word)
        rest = text[position:].lstrip() if string else text[position:]
        if not rest or rest[0] == end:
            break
        position = len(text) - len(rest) + 1
    return words
