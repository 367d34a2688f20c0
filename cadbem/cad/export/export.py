"""Patches written as CAD files: control nets with all digits, names and the unit."""

from __future__ import annotations

from pathlib import Path

from cadbem.boundary import Boundary
from cadbem.cad.body.shells import find_shells
from cadbem.cad.export.iges_export import iges_text
from cadbem.cad.export.step_export import step_text
from cadbem.cad.text.source import WRITTEN
from cadbem.errors import CadError

WRITERS = {"step": step_text, "iges": iges_text}


def write_patches(path: str | Path, boundary: Boundary, *, overwrite: bool = False) -> Path:
    """Write a boundary's patches as a STEP (.step, .stp) or IGES (.igs, .iges) file, exactly.

    Each patch becomes a rational B-spline surface, a face with its name, in the boundary's unit
    (millimetres if it has none); `read_cad` gives the same patches back, with the fluid inside
    what they enclose. STEP (AP214): patches that close become solids, others a shell. IGES (5.3):
    surfaces on their own, which the reader has to sew (STEP is better for poles and cavities).

    Raises CadError for an unknown ending, a file that is there already (unless `overwrite`), a
    boundary in a plane, a unit or a name that the format does not know; IGES labels have at most
    eight characters.
    """
    path = Path(path)
    kind = WRITTEN.get(path.suffix.lower())
    if kind is None:
        raise CadError(
            f"{path.name}: unknown ending '{path.suffix}'; write .step, .stp, .igs, .iges"
        )
    if path.exists() and not overwrite:
        raise CadError(f"{path}: the file is there already; choose another name or overwrite=True")
    if boundary.dimension != 3:
        raise CadError(f"{path.name}: plane curves cannot be written, only patches in space")
    path.parent.mkdir(parents=True, exist_ok=True)
    text = WRITERS[kind](find_shells(boundary), path)
    path.write_text(text, encoding="ascii", newline="\n")
    return path
