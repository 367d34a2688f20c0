"""The material of solids: their faces without those that two of them share."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable

from cadbem.cad.body.defects import OPEN, TURNED, find_defects
from cadbem.cad.body.orientation import shells_of
from cadbem.cad.kernel.brep import BrepFace
from cadbem.cad.text.unit import Unit
from cadbem.errors import CadError


def material_of(
    file: str, unit: Unit, solids: dict[int, list[BrepFace]]
) -> tuple[BrepFace, ...]:
    """Faces of all solids, normals out of the material, without those that two of them share.

    Raises CadError if they do not close.
    """
    shells = [shell for faces in solids.values() for shell in shells_of(faces)]
    faces = without_doubles(face for shell in shells for face in shell.faces)[0]
    for defect in find_defects(faces):
        if defect.reason in (OPEN, TURNED):
            place = ", ".join(f"{x:.4g}" for x in defect.place() / unit.millimetres)
            raise CadError(
                f"{file}: the solids do not close round a room: the edge at [{place}] {unit.name} "
                f"{defect.reason}; export them as STEP, or united to one solid"
            )
    return faces


def without_doubles(
    faces: Iterable[BrepFace],
) -> tuple[tuple[BrepFace, ...], list[BrepFace]]:
    """Faces that are there once, and those with the same material on both sides."""
    faces = sorted(faces, key=lambda face: face.number)
    counts = Counter(face.key for face in faces)
    doubled = [face for face in faces if counts[face.key] > 1]
    return tuple(face for face in faces if counts[face.key] == 1), doubled
