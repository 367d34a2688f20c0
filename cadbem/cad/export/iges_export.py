"""The text of an IGES file (version 5.3) that holds patches.

Each patch is a rational B-spline surface (entity 128) within a trimmed surface (144) that carries
the name and whose border (142) is given twice: as lines (110) in the parameter plane and as the
patch's edges (126), each a composite (102).
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np

from cadbem.boundary import Patch
from cadbem.cad.body.shells import Piece, Shells
from cadbem.cad.text.digits import written
from cadbem.errors import CadError
from cadbem.spline.nurbs import Nurbs

UNITS = {"inch": (1, "INCH"), "mm": (2, "MM"), "": (2, "MM"), "ft": (4, "FT"), "mile": (5, "MI"),
         "m": (6, "M"), "km": (7, "KM"), "mil": (8, "MIL"), "um": (9, "UM"), "cm": (10, "CM"),
         "microinch": (11, "UIN")}  # fmt: skip
LINE, COMPOSITE, CURVE, SURFACE, ON_SURFACE, TRIMMED = 110, 102, 126, 128, 142, 144
FREE, DEPENDENT, IN_PARAMETERS = "00000000", "00010000", "00010500"  # status of an entity
PREFERRED = 3  # of both borders: 1 the lines, 2 the curves, 3 either
LABEL = 8  # characters of an entity's label
RESOLUTION = 1e-10  # of lengths, per size of the boundary


def iges_text(shells: Shells, path: Path) -> str:
    """The whole file. Raises CadError for a unit or a name that IGES cannot hold."""
    boundary = shells.boundary
    for patch in boundary.patches:
        if len(patch.name) > LABEL or not patch.name.isascii():
            raise CadError(
                f"{path.name}: the name '{patch.name}' does not fit IGES's labels of {LABEL} ASCII "
                "characters; shorten it with named(...), or write .step"
            )
    if boundary.unit not in UNITS:
        known = ", ".join(unit for unit in UNITS if unit)
        raise CadError(f"{path.name}: the unit '{boundary.unit}' is none of IGES's: {known}")
    writer = _Writer()
    for patch, border in zip(boundary.patches, shells.borders, strict=True):
        _add_patch(writer, patch, [piece.reversed() for piece in reversed(border)])
    size = float(np.abs(boundary.bounds()).max())
    return writer.text(_header(path, boundary.unit, size))


class _Writer:
    """Directory and parameter lines of the entities in the order in which they are added."""

    def __init__(self) -> None:
        self._directory: list[str] = []
        self._parameters: list[str] = []

    def add(self, kind: int, parameters: Iterable[str], status: str, label: str = "") -> int:
        """The entity's number, by which others refer to it."""
        number, first = len(self._directory) + 1, len(self._parameters) + 1
        rows = _wrapped([str(kind), *parameters], 64)
        self._parameters += [f"{row:64}{number:8}P{first + k:7}" for k, row in enumerate(rows)]
        zeros = f"{0:8}" * 5
        self._directory += [
            f"{kind:8}{first:8}{zeros}{0:8}{status}D{number:7}",
            f"{kind:8}{0:8}{0:8}{len(rows):8}{0:8}{'':16}{label:>8}{0:8}D{number + 1:7}",
        ]
        return number

    def text(self, header: list[str]) -> str:
        start = [f"{'':72}S{1:7}"]
        rows = [f"{row:72}G{k:7}" for k, row in enumerate(header, start=1)]
        sections = {"S": start, "G": rows, "D": self._directory, "P": self._parameters}
        counts = "".join(f"{letter}{len(lines):7}" for letter, lines in sections.items())
        end = f"{counts:72}T{1:7}"
        return "\n".join([*(line for lines in sections.values() for line in lines), end]) + "\n"


def _header(path: Path, unit: str, size: float) -> list[str]:
    """The global section (IGES 5.3, section 2.2.4.3)."""
    flag, name = UNITS[unit]
    stem = "".join(c if c.isascii() and c.isprintable() else "_" for c in path.stem)[:40]
    words = ["1H,", "1H;", _string(stem), _string(stem + path.suffix), "6Hcadbem", "6Hcadbem",
             "32", "38", "6", "308", "15", _string(stem), "1.", str(flag), _string(name), "1",
             "1.", "15H19700101.000000", written(RESOLUTION * size), written(size), "", "", "11",
             "0", "15H19700101.000000"]  # fmt: skip
    return _wrapped(words, 72)


def _add_patch(writer: _Writer, patch: Patch, border: Sequence[Piece]) -> None:
    """A patch whose border runs counter-clockwise seen from where its normal points."""
    surface = writer.add(SURFACE, _spline(patch.surface), DEPENDENT)
    lines = [
        writer.add(LINE, _reals([*start, 0.0, *end, 0.0]), IN_PARAMETERS)
        for start, end in (piece.parameters for piece in border)
    ]
    curves = [writer.add(CURVE, _spline(piece.curve), DEPENDENT) for piece in border]
    flat = writer.add(COMPOSITE, _references(lines), IN_PARAMETERS)
    solid = writer.add(COMPOSITE, _references(curves), DEPENDENT)
    loop = writer.add(ON_SURFACE, map(str, [0, surface, flat, solid, PREFERRED]), DEPENDENT)
    writer.add(TRIMMED, map(str, [surface, 1, 0, loop]), FREE, patch.name)


def _references(numbers: list[int]) -> list[str]:
    return [str(len(numbers)), *map(str, numbers)]


def _spline(spline: Nurbs) -> list[str]:
    """Parameters of a curve (126) or surface (128); the first direction's points run fastest."""
    is_curve, parameters = len(spline.degrees) == 1, len(spline.degrees)
    polynomial = int(np.ptp(spline.weights) == 0)
    flags = [0] * parameters + [polynomial] + [0] * parameters  # closed, polynomial, periodic
    if is_curve:
        flags = [0, 0, polynomial, 0]  # plane, closed, polynomial, periodic
    counts = [n - 1 for n in spline.weights.shape]
    weights, points = spline.weights, spline.points
    if not is_curve:
        weights, points = weights.T, points.swapaxes(0, 1)
    reals = [*spline.knots, weights.ravel(), points.ravel(), np.ravel(spline.domain)]
    words = [*map(str, [*counts, *spline.degrees, *flags]), *_reals(np.concatenate(reals))]
    return words + ["0.", "0.", "0."] if is_curve else words  # the normal of a plane curve


def _reals(values: Iterable[float]) -> list[str]:
    return [written(value) for value in values]


def _wrapped(words: list[str], width: int) -> list[str]:
    """Rows of words, a comma after each and a semicolon after the last; no word is broken."""
    rows = [""]
    for k, word in enumerate(words, start=1):
        piece = word + (";" if k == len(words) else ",")
        if len(rows[-1]) + len(piece) > width:
            rows.append("")
        rows[-1] += piece
    return rows


def _string(text: str) -> str:
    return f"{len(text)}H{text}" if text else ""
