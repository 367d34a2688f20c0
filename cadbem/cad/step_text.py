"""Unit and face names from the text of a STEP file (ISO 10303-21)."""

from __future__ import annotations

import re

import numpy as np

from cadbem.cad.marks import FaceMark, Unit
from cadbem.spline.basis import Array

_ENTITY = re.compile(r"#(\d+)\s*=\s*((?:'[^']*'|[^';])*);")
_FACE = re.compile(r"(?:ADVANCED_FACE|FACE_SURFACE)\('((?:[^']|'')*)',\(([#\d,]*)\)")
_SPLINE = re.compile(
    r"(?:B_SPLINE_CURVE(?:_WITH_KNOTS)?|BEZIER_CURVE)\((?:'[^']*',)?\d+,\(([#\d,]*)\)"
)
_PREFIXES = {
    "": (1000.0, "m"),
    "MILLI": (1.0, "mm"),
    "CENTI": (10.0, "cm"),
    "DECI": (100.0, "dm"),
    "MICRO": (1e-3, "um"),
    "NANO": (1e-6, "nm"),
    "KILO": (1e6, "km"),
}
_NAMES = {
    "IN": "inch", "INCHES": "inch", "FOOT": "ft", "FEET": "ft", "METRE": "m", "METER": "m",
    "MILLIMETRE": "mm", "MILLIMETER": "mm", "CENTIMETRE": "cm", "CENTIMETER": "cm",
}  # fmt: skip
_NAMELESS = ("", "NONE")  # some programs write 'NONE' for want of a name


class StepText:
    """The file's entities, by number."""

    def __init__(self, text: str) -> None:
        text = re.sub(r"/\*.*?\*/", "", text, flags=re.DOTALL)
        found = _ENTITY.findall(text)
        self._entities = {int(number): _without_blanks(body) for number, body in found}

    def unit(self) -> Unit:
        """The unit of length; nameless millimetres if the file does not say."""
        for body in self._entities.values():
            context = re.search(r"GLOBAL_UNIT_ASSIGNED_CONTEXT\(\(([#\d,]*)\)", body)
            for reference in _references(context[1]) if context else []:
                if "LENGTH_UNIT()" in self._entities.get(reference, ""):
                    return self._unit_of(self._entities[reference])
        return Unit("", 1.0)

    def _unit_of(self, body: str) -> Unit:
        si = re.search(r"SI_UNIT\((?:\.(\w+)\.|\$),\.METRE\.\)", body)
        if si:
            millimetres, name = _PREFIXES[si[1] or ""]
            return Unit(name, millimetres)
        converted = re.search(r"CONVERSION_BASED_UNIT\('([^']*)',#(\d+)\)", body)
        measure = self._entities[int(converted[2])] if converted else ""
        amount = re.search(r"LENGTH_MEASURE\(([^)]*)\)\)?,#(\d+)", measure)
        if converted is None or amount is None:
            return Unit("", 1.0)
        base = self._unit_of(self._entities[int(amount[2])])
        name = _NAMES.get(converted[1].upper(), converted[1].lower())
        return Unit(name, float(amount[1]) * base.millimetres)

    def faces(self) -> list[FaceMark]:
        """Every face with its corners and a point on each edge."""
        marks = []
        for body in self._entities.values():
            face = _FACE.match(body)
            if face:
                edges = [e for bound in _references(face[2]) for e in self._edges(bound)]
                corners = [point for start, end, _ in edges for point in (start, end)]
                middles = [middle for _, _, middle in edges]
                name = "" if face[1] in _NAMELESS else _decoded(face[1])
                marks.append(FaceMark(name, _rows(corners), _rows(middles)))
        return marks

    def _edges(self, bound: int) -> list[tuple[Array, Array, Array]]:
        loop = self._entities[_references(self._entities[bound])[0]]
        if loop.startswith("VERTEX_LOOP"):
            point = self._point(_references(loop)[0])
            return [(point, point, point)]
        oriented = [self._entities[reference] for reference in _references(loop)]
        return [self._edge(self._entities[_references(body)[0]]) for body in oriented]

    def _edge(self, body: str) -> tuple[Array, Array, Array]:
        first, last, curve = _references(body)[:3]
        start, end = self._point(first), self._point(last)
        return start, end, self._middle(curve, start, end, forward=".T." in body)

    def _point(self, vertex: int) -> Array:
        body = self._entities[vertex]
        if body.startswith("VERTEX_POINT"):
            body = self._entities[_references(body)[0]]
        return np.array(
            [float(word) for word in body[body.rindex("(") + 1 :].split(")")[0].split(",")]
        )

    def _middle(self, curve: int, start: Array, end: Array, forward: bool) -> Array:
        body = self._entities[curve]
        if body.startswith(("SURFACE_CURVE", "SEAM_CURVE", "INTERSECTION_CURVE", "TRIMMED_CURVE")):
            return self._middle(_references(body)[0], start, end, forward)
        if body.startswith(("CIRCLE", "ELLIPSE")):
            return self._arc_middle(body, start, end, forward)
        spline = _SPLINE.search(body)
        if spline:
            return np.mean([self._point(point) for point in _references(spline[1])], axis=0)
        return 0.5 * (start + end)

    def _arc_middle(self, body: str, start: Array, end: Array, forward: bool) -> Array:
        placement = [self._point(r) for r in _references(self._entities[_references(body)[0]])]
        centre = placement[0]
        axis = placement[1] if len(placement) > 1 else np.array([0.0, 0.0, 1.0])
        helper = placement[2] if len(placement) > 2 else np.array([1.0, 0.0, 0.0])
        if np.linalg.norm(np.cross(axis, helper)) < 1e-9:  # the default X is taken by the axis
            helper = np.array([0.0, 1.0, 0.0])
        y = np.cross(axis, helper)
        y /= np.linalg.norm(y)
        x = np.cross(y, axis) / np.linalg.norm(axis)
        radii = [float(r) for r in body[: body.rindex(")")].split(",")[2:]]
        a, b = radii[0], radii[-1]
        angles = [np.arctan2((p - centre) @ y / b, (p - centre) @ x / a) for p in (start, end)]
        if not forward:
            angles.reverse()
        turn = (angles[1] - angles[0]) % (2 * np.pi)
        middle = angles[0] + 0.5 * (turn if turn > 1e-9 else 2 * np.pi)
        return centre + a * np.cos(middle) * x + b * np.sin(middle) * y


def _without_blanks(body: str) -> str:
    parts = re.split(r"('[^']*')", body)
    return "".join(part if part.startswith("'") else re.sub(r"\s+", "", part) for part in parts)


def _references(body: str) -> list[int]:
    return [int(number) for number in re.findall(r"#(\d+)", re.sub(r"'[^']*'", "", body))]


def _rows(points: list[Array]) -> Array:
    return np.array(points).reshape(-1, 3)


def _decoded(text: str) -> str:
    """Undo the escapes of STEP strings: doubled apostrophes, \\X\\ and \\X2\\ code points."""
    text = re.sub(
        r"\\X2\\([0-9A-F]*)\\X0\\", lambda m: bytes.fromhex(m[1]).decode("utf-16-be"), text
    )
    text = re.sub(r"\\X\\([0-9A-F]{2})", lambda m: chr(int(m[1], 16)), text)
    return text.replace("''", "'")
