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
_FACE = re.compile(r"(#(\d+)\s*=\s*(?:ADVANCED_FACE|FACE_SURFACE)\s*\(\s*)'(?:[^']|'')*'")


def solid_names(source: CadSource, faces: Sequence[BrepFace], unit: Unit) -> dict[int, str]:
    """Name of the solid, by face number, for faces of outer shells of named solids."""
    return _spread(source, faces, unit, _SOLID)


def shell_names(source: CadSource, faces: Sequence[BrepFace], unit: Unit) -> dict[int, str]:
    """Name of the closed shell, by face number, for faces of named shells."""
    return _spread(source, faces, unit, _SHELL)


def _spread(
    source: CadSource, faces: Sequence[BrepFace], unit: Unit, kind: re.Pattern[str]
) -> dict[int, str]:
    """The name of what faces belong to, found as if it were each face's own."""
    if source.kind != "step":
        return {}
    names = dict(_members(entities(source.text), kind))
    if not names:
        return {}
    text = _FACE.sub(lambda face: f"{face[1]}'{names.get(int(face[2]), '')}'", source.text)
    labels = match_labels(StepText(text).faces(), list(faces), unit)
    return {number: label.name for number, label in labels.items() if label.name}


def _members(found: dict[int, str], kind: re.Pattern[str]) -> Iterator[tuple[int, str]]:
    """Faces and the name of the solid or shell that they are in."""
    for body in found.values():
        match = kind.match(body)
        if match:
            shell = body if kind is _SHELL else found.get(int(match[2]), "")
            for face in references(shell):
                yield face, match[1]
