"""Warnings about units and sizes that are unlikely."""

from __future__ import annotations

from cadbem.cad.faces.face_geometry import size_of
from cadbem.cad.kernel.brep import BrepFace
from cadbem.cad.text.unit import Unit

LARGE = 1e3  # largest extent in mm; the kernel refuses less than 1e-4 mm, see `_check_size`


def assumed_unit(file: str, unit: Unit) -> list[str]:
    """A line if the file does not say its unit of length."""
    if not unit.assumed:
        return []
    return [
        f"{file}: no unit of length is given, {unit.name} is assumed; "
        "set the unit in the CAD program and export again if that is wrong"
    ]


def unusual_size(file: str, unit: Unit, faces: tuple[BrepFace, ...]) -> list[str]:
    """A line if the largest extent is not that of a microchannel."""
    size = size_of(*faces)
    if size <= LARGE:
        return []
    metres = 1e-3 * size
    plain = "" if unit.name == "m" else f" ({metres:.3g} m)"
    return [
        f"{file}: this channel is {size / unit.millimetres:.4g} {unit.name}{plain} wide; "
        f"is its unit really {unit.name}? if not, set it in the CAD program and export again"
    ]
