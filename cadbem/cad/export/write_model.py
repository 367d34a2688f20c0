"""Write the current gmsh model as STEP or IGES, with the names of its faces.

OpenCASCADE's writers, as gmsh calls them, name no faces, stamp the date, and keep 13 (STEP) or
10 (IGES) digits. Here the written text is completed: each face of the file is recognised by its
corners (never by its place in the file) and named, and what changes from run to run is replaced,
so that the same model always gives the same bytes. STEP: the name of `ADVANCED_FACE`, and the
corners with all 17 digits. IGES: the entity label of the trimmed surface (type 144).
"""

import os
import re
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from cadbem.cad.labels.face_labels import FaceLabel
from cadbem.cad.labels.iges_labels import IgesText
from cadbem.cad.labels.step_labels import StepText
from cadbem.errors import CadError

_SAFE_NAME = re.compile(r"[A-Za-z0-9_.+-]+( [A-Za-z0-9_.+-]+)*")
_STEP_POINT = re.compile(r"(CARTESIAN_POINT\('',)\(([^,()]+),([^,()]+),([^,()]+)\)")


def write_cad(path: str | Path, names: dict[int, str]) -> None:
    """Write the current gmsh model (OpenCASCADE, synchronised) to `path`, .step/.stp or .igs/.iges.

    `names` maps surface tags to face names; faces left out stay nameless. Lengths are written in
    millimetres. IGES labels hold eight characters at most. Raises `CadError` for an unknown
    extension or tag, a name that the format cannot hold, and faces of different names that have
    the same corners.
    """
    path = Path(path)
    complete = {".step": _complete_step, ".stp": _complete_step, ".igs": _complete_iges,
                ".iges": _complete_iges}.get(path.suffix.lower())  # fmt: skip
    if complete is None:
        raise CadError(f"{path.name}: unknown extension, write .step, .stp, .igs or .iges")
    for name in names.values():
        if not _SAFE_NAME.fullmatch(name):
            raise CadError(f"{path.name}: face name {name!r}: use letters, digits, _ . + - only")
    model = _Model.current(names, path.name)
    text = complete(_exported(path.suffix.lower()), model)
    path.write_text(text, encoding="ascii", newline="\n")


@dataclass(frozen=True, eq=False)
class _Model:
    """Corners of the model (N, 3), and for each face the set of its corners and its name."""

    file: str
    corners: np.ndarray
    faces: tuple[tuple[frozenset[int], str], ...]

    @classmethod
    def current(cls, names: dict[int, str], file: str) -> "_Model":
        import gmsh

        points = [tag for _, tag in gmsh.model.getEntities(0)]
        tags = [tag for _, tag in gmsh.model.getEntities(2)]
        if not points or not tags:
            raise CadError(f"{file}: the gmsh model has no faces (occ.synchronize() forgotten?)")
        if unknown := sorted(set(names) - set(tags)):
            raise CadError(f"{file}: no surface {unknown[0]} in the gmsh model, it has {tags}")
        corners = np.array([gmsh.model.getValue(0, tag, []) for tag in points])
        bare = cls(file, corners, ())
        faces = []
        for tag in tags:
            ends = gmsh.model.getBoundary([(2, tag)], combined=False, recursive=True)
            ends_at = corners[[points.index(point) for _, point in ends]]
            faces.append((bare.corner_set(ends_at), names.get(tag, "")))
        return cls(file, corners, tuple(faces))

    def nearest(self, point: np.ndarray) -> tuple[int, float]:
        """The first corner within 1e-8 model sizes of the nearest one, and the distance to it."""
        distance = np.linalg.norm(self.corners - point, axis=1)
        tolerance = 1e-8 * max(1e-300, float(np.abs(self.corners).max()))
        index = int(np.argmax(distance <= distance.min() + tolerance))
        return index, float(distance[index])

    def corner_set(self, points: np.ndarray) -> frozenset[int]:
        return frozenset(self.nearest(point)[0] for point in points)

    def names_of(self, labels: list[FaceLabel]) -> Iterator[str]:
        """Names of the written file's faces, in the file's order."""
        if len(labels) != len(self.faces):
            raise CadError(
                f"{self.file}: {len(self.faces)} faces in the model but {len(labels)} written;"
                " split closed or periodic faces first"
            )
        return iter([self._name_of(label.corners) for label in labels])

    def _name_of(self, points: np.ndarray) -> str:
        wanted = self.corner_set(points)
        found = {name for corners, name in self.faces if corners == wanted}
        if len(found) == 1:
            return found.pop()
        where = np.round(points.mean(axis=0), 3).tolist()
        reason = f"could be any of {sorted(found)}: same corners" if found else "has no counterpart"
        raise CadError(f"{self.file}: written face about {where} {reason}; split it")


def _exported(suffix: str) -> str:
    import gmsh

    with tempfile.TemporaryDirectory() as folder, _silent_stdout():
        target = Path(folder) / f"model{suffix}"
        gmsh.write(str(target))
        return target.read_text(encoding="latin-1")


def _plain(file: str) -> tuple[str, str]:
    """The file's name, and that without extension, in characters that both formats allow."""
    path = Path(re.sub(r"[^A-Za-z0-9_.+-]", "_", file)[-60:])
    return path.name, path.stem


@contextmanager
def _silent_stdout() -> Iterator[None]:
    """Discard file descriptor 1: OpenCASCADE prints there whatever gmsh's verbosity is."""
    kept, accumulator = os.dup(1), os.open(os.devnull, os.O_WRONLY)
    os.dup2(accumulator, 1)
    try:
        yield
    finally:
        os.dup2(kept, 1)
        os.close(kept)
        os.close(accumulator)


# STEP (ISO 10303-21)


def _complete_step(text: str, model: _Model) -> str:
    file, stem = _plain(model.file)
    header = f"FILE_NAME('{file}','1970-01-01T00:00:00',(''),(''),'cadbem','gmsh','');\n"
    text = re.sub(r"FILE_NAME\(.*?\);\n", lambda _: header, text, count=1, flags=re.DOTALL)
    text = re.sub(r"'Open CASCADE STEP translator[^']*'", f"'{stem}'", text)
    text = _STEP_POINT.sub(lambda found: _sharpened(found, model), text)
    names = model.names_of(StepText(text).faces())
    return re.sub(r"ADVANCED_FACE\(''", lambda _: f"ADVANCED_FACE('{next(names)}'", text)


def _sharpened(found: re.Match[str], model: _Model) -> str:
    """A point of the file; if it is a corner, with the corner's own digits."""
    point = np.array([float(found[k]) for k in (2, 3, 4)])
    index, distance = model.nearest(point)
    if distance > 1e-11 * np.abs(model.corners).max():
        return found[0]
    digits = (np.format_float_positional(x + 0.0) for x in model.corners[index])
    return f"{found[1]}({','.join(digits)})"


# IGES 5.3


def _complete_iges(text: str, model: _Model) -> str:
    sections: dict[str, list[str]] = {letter: [] for letter in "SGDPT"}
    for line in text.splitlines():
        sections[line[72]].append(line)
    names = model.names_of(IgesText(text).faces())
    faces = [i for i, line in enumerate(sections["D"]) if line[:8] == "     144"]
    for index, name in zip(faces[1::2], names, strict=True):  # labels are in the second lines
        if len(name) > 8:
            raise CadError(f"{model.file}: face name {name!r} is longer than IGES's 8 characters")
        line = sections["D"][index]
        sections["D"][index] = f"{line[:56]}{name:>8}{line[64:]}"
    sections["G"] = _iges_global(sections["G"], *_plain(model.file))
    counts = "".join(f"{letter}{len(sections[letter]):7}" for letter in "SGDP")
    sections["T"] = [f"{counts:72}T      1"]
    return "\n".join(line for letter in "SGDPT" for line in sections[letter]) + "\n"


def _iges_global(lines: list[str], file: str, stem: str) -> list[str]:
    """The global section with the file's name and without dates and versions."""
    fields = "".join(line[:72].rstrip() for line in lines).rstrip(";").split(",")
    for index, value in {2: stem, 3: file, 4: "cadbem", 5: "gmsh", 17: "19700101.000000",
                         24: "19700101.000000"}.items():  # fmt: skip
        fields[index] = f"{len(value)}H{value}"
    rows = [""]
    for field in fields:
        if len(rows[-1]) + len(field) + 1 > 72:
            rows.append("")
        rows[-1] += f"{field},"
    rows[-1] = rows[-1][:-1] + ";"
    return [f"{row:72}G{number:7}" for number, row in enumerate(rows, start=1)]
