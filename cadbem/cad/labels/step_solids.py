"""Names of solids and shells in the text of a STEP file; the CAD kernel loses most of them."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence

from cadbem.cad.kernel.brep import BrepFace
from cadbem.cad.labels.face_labels import match_labels
from cadbem.cad.labels.step_labels import StepText
from cadbem.cad.text.source import CadSource
from cadbem.cad.text.step_syntax import entities, references
from cadbem.cad.text.unit import Unit

_SOLID = re.compile(
    r"(?:MANIFOLD_SOLID_BREP|BREP_WITH_VOIDS|FACETED_BREP)\('((?:[^']|'')*)',#(\d+)"
)
_SHELL = re.compile(r"CLOSED_SHELL\('((?:[^']|'')*)'")
_OWN = re.compile(r"(?:ADVANCED_FACE|FACE_SURFACE)\('((?:[^']|'')*)'")
_SHEET = re.compile(r"OPEN_SHELL\('((?:[^']|'')*)'")
_MODEL = re.compile(r"(?:SHELL_BASED_SURFACE_MODEL|GEOMETRIC_SET)\('((?:[^']|'')*)'")
_DEFINED = re.compile(r"SHAPE_DEFINITION_REPRESENTATION\(#(\d+),#(\d+)\)")
_ALIKE = re.compile(r"SHAPE_REPRESENTATION_RELATIONSHIP\((?:[^#]*),#(\d+),#(\d+)\)")
_PRODUCT = re.compile(r"PRODUCT\('((?:[^']|'')*)'")
_FACE = re.compile(r"(#(\d+)\s*=\s*(?:ADVANCED_FACE|FACE_SURFACE)\s*\(\s*)'(?:[^']|'')*'")


def solid_names(source: CadSource, faces: Sequence[BrepFace], unit: Unit) -> dict[int, str]:
    """Name of the solid, by face number, for faces of outer shells of named solids."""
    return _spread(source, faces, unit, _SOLID)


def shell_names(source: CadSource, faces: Sequence[BrepFace], unit: Unit) -> dict[int, str]:
    """Name of the closed shell, by face number, for faces of named shells."""
    return _spread(source, faces, unit, _SHELL)


def sheet_names(source: CadSource, faces: Sequence[BrepFace], unit: Unit) -> dict[int, str]:
    """Name of the sheet, by face number, for faces of open shells: that of the face itself, else
    of the shell, of its model, or of the product."""
    if source.kind != "step":
        return {}
    found = entities(source.text)
    models = {k: (body, m[1]) for k, body in found.items() if (m := _MODEL.match(body))}
    names = {}
    for number, body in found.items():
        shell = _SHEET.match(body)
        if shell is None:
            continue
        holders = [k for k, (holder, _) in models.items() if number in references(holder)]
        said = [shell[1], *(models[k][1] for k in holders)]
        said += [name for k in holders for name in _products(found, k)]
        called = next((name for name in said if name), "")
        for face in references(body):
            own = _OWN.match(found.get(face, ""))
            names[face] = own[1] if own and own[1] else called
    return _matched(source, faces, unit, names) if any(names.values()) else {}


def _products(found: dict[int, str], item: int) -> list[str]:
    """Names of the products whose representation has an item, itself or by one that is alike."""
    holders = {
        k for k, body in found.items() if "REPRESENTATION(" in body and item in references(body)
    }
    for body in found.values():
        alike = _ALIKE.match(body)
        if alike and {int(alike[1]), int(alike[2])} & holders:
            holders |= {int(alike[1]), int(alike[2])}
    names = []
    for body in found.values():
        defined = _DEFINED.match(body)
        if defined and int(defined[2]) in holders:
            place = int(defined[1])
            for _ in range(4):  # shape, definition, formation, product
                product = _PRODUCT.match(found.get(place, ""))
                if product:
                    names.append(product[1])
                    break
                place = next(iter(references(found.get(place, ""))), 0)
    return names


def _spread(
    source: CadSource, faces: Sequence[BrepFace], unit: Unit, kind: re.Pattern[str]
) -> dict[int, str]:
    """The name of what faces belong to, found as if it were each face's own."""
    if source.kind != "step":
        return {}
    names = dict(_members(entities(source.text), kind))
    if not names:
        return {}
    return _matched(source, faces, unit, names)


def _matched(
    source: CadSource, faces: Sequence[BrepFace], unit: Unit, names: dict[int, str]
) -> dict[int, str]:
    """Names of the text's faces, by entity, as those of the kernel's faces, by number."""
    text = _FACE.sub(lambda face: f"{face[1]}'{names.get(int(face[2]), '')}'", source.text)
    labels = [label for label in StepText(text).faces() if label.name]
    found = match_labels(labels, list(faces), unit)
    return {number: label.name for number, label in found.items()}


def _members(found: dict[int, str], kind: re.Pattern[str]) -> Iterator[tuple[int, str]]:
    """Faces and the name of the solid or shell that they are in."""
    for body in found.values():
        match = kind.match(body)
        if match:
            shell = body if kind is _SHELL else found.get(int(match[2]), "")
            for face in references(shell):
                yield face, match[1]
