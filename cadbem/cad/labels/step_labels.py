"""Unit, and names, layers and colours of faces, from the text of a STEP file (ISO 10303-21)."""

from __future__ import annotations

import re

import numpy as np

from cadbem.cad.labels.face_labels import FaceLabel
from cadbem.cad.text.spline_checks import check_step_spline
from cadbem.cad.text.step_styles import colours, faces_of, layers
from cadbem.cad.text.step_syntax import dangling, decoded, entities, references, without_strings
from cadbem.cad.text.unit import Unit
from cadbem.spline.basis import Array

_FACE = re.compile(r"(?:ADVANCED_FACE|FACE_SURFACE)\('((?:[^']|'')*)',\(([#\d,]*)\)")
_CONTEXT = re.compile(r"GLOBAL_UNIT_ASSIGNED_CONTEXT\(\(([#\d,]*)\)")
# in bodies without strings
_REPRESENTATION = re.compile(r"(?<!PRESENTATION_)REPRESENTATION\(,\(([#\d,]*)\),#(\d+)\)")
_SPLINE = re.compile(r"(?:B_SPLINE_CURVE(?:_WITH_KNOTS)?|BEZIER_CURVE)\(,?\d+,\(([#\d,]*)\)")
_PREFIXES = {
    "": (1000.0, "m"), "MILLI": (1.0, "mm"), "CENTI": (10.0, "cm"), "DECI": (100.0, "dm"),
    "MICRO": (1e-3, "um"), "NANO": (1e-6, "nm"), "PICO": (1e-9, "pm"), "DECA": (1e4, "dam"),
    "HECTO": (1e5, "hm"), "KILO": (1e6, "km"), "MEGA": (1e9, "Mm"),
}  # fmt: skip
_NAMED = {
    "inch": 25.4, "ft": 304.8, "m": 1000.0, "mm": 1.0, "cm": 10.0, "um": 1e-3, "mil": 0.0254,
}  # fmt: skip
_SPELLINGS = {
    "in": "inch", "inches": "inch", "foot": "ft", "feet": "ft", "metre": "m", "meter": "m",
    "millimetre": "mm", "millimeter": "mm", "centimetre": "cm", "centimeter": "cm",
    "micrometre": "um", "micrometer": "um", "micron": "um",
}  # fmt: skip
_NAMELESS = ("", "NONE")  # some programs write 'NONE' for want of a name


class StepText:
    """The file's entities, by number."""

    def __init__(self, text: str) -> None:
        self._entities = entities(text)
        for number, body in self._entities.items():
            check_step_spline(number, body)

    def unit(self) -> Unit:
        """The unit of length; millimetres are assumed if the file does not say.

        Raises ValueError if parts are in different units.
        """
        units = {unit.millimetres: unit for unit in map(self._unit_in, self._contexts()) if unit}
        if len(units) > 1:
            names = " and in ".join(sorted(unit.name for unit in units.values()))
            raise ValueError(f"lengths are in {names}; give all parts one unit")
        return next(iter(units.values()), Unit("mm", 1.0, assumed=True))

    def remarks(self) -> list[str]:
        """Warnings about the text, which can be read nevertheless."""
        missing = dangling(self._entities)
        if not missing:
            return []
        number, reference = missing[0]
        return [f"{len(missing)} references lead nowhere, the first from #{number} to #{reference}"]

    def _contexts(self) -> list[str]:
        """The contexts of representations with faces; all if there are none."""
        used = [
            int(found[2])
            for found in map(_REPRESENTATION.search, map(without_strings, self._entities.values()))
            if found and any(faces_of(self._entities, item) for item in references(found[1]))
        ]
        return [self._entities[number] for number in used] or list(self._entities.values())

    def _unit_in(self, context: str) -> Unit | None:
        found = _CONTEXT.search(context)
        for reference in references(found[1]) if found else []:
            if "LENGTH_UNIT()" in self._entities.get(reference, ""):
                return self._unit_of(reference)
        return None

    def _unit_of(self, reference: int) -> Unit | None:
        body = self._entities[reference]
        si = re.search(r"SI_UNIT\((?:\.(\w+)\.|\$),\.METRE\.\)", body)
        if si:
            millimetres, name = _PREFIXES[si[1] or ""]
            return Unit(name, millimetres)
        converted = re.search(r"CONVERSION_BASED_UNIT\('([^']*)',#(\d+)\)", body)
        measure = self._entities[int(converted[2])] if converted else ""
        amount = re.search(r"LENGTH_MEASURE\(([^)]*)\)\)?,#(\d+)", without_strings(measure))
        base = self._unit_of(int(amount[2])) if amount and int(amount[2]) != reference else None
        if converted is None or amount is None or base is None:
            return None
        return _named(converted[1].strip().lower(), float(amount[1]) * base.millimetres)

    def faces(self) -> list[FaceLabel]:
        """Every face with its corners and a point on each edge."""
        labels = []
        layer, colour = layers(self._entities), colours(self._entities)
        for number, body in self._entities.items():
            face = _FACE.match(body)
            if face:
                edges = [e for bound in references(face[2]) for e in self._edges(bound)]
                corners = _rows([point for start, end, _ in edges for point in (start, end)])
                middles = _rows([middle for _, _, middle in edges])
                name = "" if face[1] in _NAMELESS else decoded(face[1])
                says = name, layer.get(number, ""), colour.get(number, "")
                labels.append(FaceLabel(says[0], corners, middles, *says[1:]))
        return labels

    def _edges(self, bound: int) -> list[tuple[Array, Array, Array]]:
        loop = self._entities[references(self._entities[bound])[0]]
        if loop.startswith("VERTEX_LOOP"):
            point = self._point(references(loop)[0])
            return [(point, point, point)]
        oriented = [self._entities[reference] for reference in references(loop)]
        return [self._edge(self._entities[references(body)[0]]) for body in oriented]

    def _edge(self, body: str) -> tuple[Array, Array, Array]:
        first, last, curve = references(body)[:3]
        start, end = self._point(first), self._point(last)
        return start, end, self._middle(curve, start, end, forward=".T." in body)

    def _point(self, vertex: int) -> Array:
        body = self._entities[vertex]
        if body.startswith("VERTEX_POINT"):
            body = self._entities[references(body)[0]]
        return np.array(
            [float(word) for word in body[body.rindex("(") + 1 :].split(")")[0].split(",")]
        )

    def _middle(self, curve: int, start: Array, end: Array, forward: bool) -> Array:
        body = self._entities[curve]
        if body.startswith(("SURFACE_CURVE", "SEAM_CURVE", "INTERSECTION_CURVE", "TRIMMED_CURVE")):
            return self._middle(references(body)[0], start, end, forward)
        if body.startswith(("CIRCLE", "ELLIPSE")):
            return self._arc_middle(body, start, end, forward)
        spline = _SPLINE.search(without_strings(body))
        if spline:
            return np.mean([self._point(point) for point in references(spline[1])], axis=0)
        return 0.5 * (start + end)

    def _arc_middle(self, body: str, start: Array, end: Array, forward: bool) -> Array:
        placement = [self._point(r) for r in references(self._entities[references(body)[0]])]
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


def _named(name: str, millimetres: float) -> Unit:
    """A unit with our name for it; raises ValueError if its size is not that of the name."""
    name = _SPELLINGS.get(name, name)
    expected = _NAMED.get(name, millimetres)
    if abs(millimetres - expected) > 1e-3 * expected:
        raise ValueError(f"the unit {name} is said to be {millimetres:g} mm")
    return Unit(name, millimetres)


def _rows(points: list[Array]) -> Array:
    return np.array(points).reshape(-1, 3)
