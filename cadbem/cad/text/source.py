"""The text of a CAD file, checked before the kernel reads it."""

from __future__ import annotations

import os
import re
from dataclasses import dataclass
from pathlib import Path

from cadbem.checks import instance
from cadbem.errors import CadError, printable

WRITTEN = {".step": "step", ".stp": "step", ".igs": "iges", ".iges": "iges"}
ENDINGS = WRITTEN | {".brep": "brep", ".brp": "brep"}
_FORMATS = {"step": "STEP", "iges": "IGES", "brep": "OpenCASCADE's BREP"}
_OTHERS = {  # endings of files that people have, what they hold, and what to do
    "stl obj ply off 3mf amf wrl glb gltf": (
        "a mesh of triangles, from which no smooth surface can be had",
        "export STEP from the program in which the part was drawn",
    ),
    "msh vtk vtu vtp inp unv med cgns bdf nas mesh neu cas": (
        "a mesh, from which no smooth surface can be had",
        "take the STEP or IGES file that was meshed",
    ),
    "dxf gds gdsii": (
        "a plane drawing",
        "read_layout(path, height=...) makes a channel of it, read_outline a plane boundary",
    ),
    "oas oasis cif svg pdf ai dwg": ("a plane drawing", "save it as DXF or GDS, for read_layout"),
    "sldprt sldasm ipt iam f3d fcstd prt asm par catpart x_t x_b sat 3dm skp blend jt": (
        "in the format of one program",
        "export it there as STEP (AP214 or AP242)",
    ),
}
_NOT_A_NUMBER = re.compile(
    r"(?<=[(,=\s])[+-]?(?:nan|inf|infinity|\d*+\.#\w++)(?:\(\w++\))?(?=\s*+[,;)])", re.IGNORECASE
)
# from 1e100, whose cubes are no floats any more, and from 100 digits
_HUGE = re.compile(r"(?<![\d.])[\d.]++(?:(?<=[\d.]{100})|[eEdD]\+?0*+[1-9]\d{2,})")
MOST_BYTES = 2**28
_START = re.compile(r"\s*+(?>/\*.*?\*/\s*+)*+ISO-10303-21\s*+;", re.DOTALL)


@dataclass(frozen=True)
class CadSource:
    """A file of a known kind: "step", "iges" or "brep"."""

    name: str
    kind: str
    data: bytes

    @property
    def text(self) -> str:
        """As UTF-8, or byte by byte where it is not that, and in IGES, where columns count."""
        if self.kind == "step":
            try:
                return self.data.decode("utf-8")
            except UnicodeDecodeError:
                pass
        return self.data.decode("latin-1")


def read_source(path: str | Path) -> CadSource:
    """The file's text after all checks that need no CAD kernel.

    Raises CadError for a missing, empty or cut-off file, a directory, an unknown ending, a content
    that is not what the ending says, and numbers that are not finite.
    """
    path = Path(instance("path", path, str | os.PathLike, "the path of a STEP or IGES file"))
    name = printable(path.name)
    kind = ENDINGS.get(path.suffix.lower())
    if os.path.isdir(path):
        raise CadError(f"{path}: this is a directory; give a STEP or IGES file")
    if not os.path.exists(path):
        raise CadError(f"{str(path):.300}: no such file")
    if kind is None:
        raise CadError(f"{name}: {_what_to_do(path.suffix)}")
    try:
        if path.stat().st_size > MOST_BYTES:
            raise CadError(f"{name}: a file above {MOST_BYTES >> 20} MB is not read; simplify it")
        data = path.read_bytes().removeprefix(b"\xef\xbb\xbf")
    except OSError as error:
        raise CadError(f"{path}: cannot be read ({error.strerror})") from None
    source = CadSource(name, kind, data)
    _check_content(source)
    _check_numbers(source)
    return source


def _what_to_do(suffix: str) -> str:
    """What a file with another ending holds, and the remedy."""
    for endings, (what, remedy) in _OTHERS.items():
        if suffix.lower()[1:] in endings.split():
            return f"'{suffix}' is {what}; {remedy}"
    return f"unknown ending '{suffix}'; use .step, .stp, .iges, .igs or .brep"


def _check_content(source: CadSource) -> None:
    if not source.data.strip():
        raise CadError(f"{source.name}: the file is empty; export it again")
    found = _kind_of(source.text)
    if found is None:
        raise CadError(
            f"{source.name}: the content is not {_FORMATS[source.kind]}; "
            "export the model as STEP or IGES text"
        )
    if found != source.kind:
        raise CadError(
            f"{source.name}: the content is {_FORMATS[found]}, the ending says "
            f"{_FORMATS[source.kind]}; rename the file to .{found}"
        )
    if not _is_complete(source):
        raise CadError(f"{source.name}: the file is cut off before its end; export it again")


def _kind_of(text: str) -> str | None:
    if _START.match(text):
        return "step"
    if re.match(r"\s*(DBRep_DrawableShape\s+)?CASCADE Topology V\d", text):
        return "brep"
    first = text.split("\n", 1)[0].rstrip("\r")
    return "iges" if re.fullmatch(r".{72}[SG] *\d+ *", first) else None


def _is_complete(source: CadSource) -> bool:
    if source.kind == "step":
        return re.search(r"END-ISO-10303-21\s*;", source.text[-2000:]) is not None
    if source.kind == "brep":  # the last line places the whole shape
        return re.search(r"\*\s+\+\d+ \d+\s*\d*\s*$", source.text[-2000:]) is not None
    return any(line[72:73] == "T" for line in source.text.splitlines()[-5:])


def _check_numbers(source: CadSource) -> None:
    text = _without_labels(source)
    bad = _NOT_A_NUMBER.search(text)
    if bad is None:
        bad = _HUGE.search(text)
    if bad is not None:
        line = text.count("\n", 0, bad.start()) + 1
        raise CadError(
            f"{source.name}: '{bad[0].strip()[:40]}' near line {line} is not a finite number "
            "below 1e100; repair the model and export it again"
        )


def _without_labels(source: CadSource) -> str:
    """The text, line by line, without strings (STEP) or directory and sequence columns (IGES)."""
    if source.kind == "brep":
        return source.text
    if source.kind == "step":
        return re.sub(r"'[^']*'", lambda m: "''" + "\n" * m[0].count("\n"), source.text)
    lines = source.text.splitlines()
    return "\n".join(line[:64] if line[72:73] == "P" else "" for line in lines)
