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

from cadbem.errors import CadError

_SAFE_NAME = re.compile(r"[A-Za-z0-9_.+-]+( [A-Za-z0-9_.+-]+)*")
_FACE_TO_CORNER = {
    "FACE_BOUND", "FACE_OUTER_BOUND", "EDGE_LOOP", "VERTEX_LOOP", "ORIENTED_EDGE", "EDGE_CURVE",
    "VERTEX_POINT",
}  # fmt: skip
_STEP_ENTITY = re.compile(r"#(\d+) = (\w+)\((.*?)\);\n", re.DOTALL)
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

    def named(self, file_faces: dict[int, np.ndarray]) -> dict[int, str]:
        """Names of the file's faces, given the corners (n, 3) of each."""
        if len(file_faces) != len(self.faces):
            raise CadError(
                f"{self.file}: {len(self.faces)} faces in the model but {len(file_faces)} written;"
                " split closed or periodic faces first"
            )
        return {number: self._name_of(points) for number, points in file_faces.items()}

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


@contextmanager
def _silent_stdout() -> Iterator[None]:
    """Discard file descriptor 1: OpenCASCADE prints there whatever gmsh's verbosity is."""
    kept, sink = os.dup(1), os.open(os.devnull, os.O_WRONLY)
    os.dup2(sink, 1)
    try:
        yield
    finally:
        os.dup2(kept, 1)
        os.close(kept)
        os.close(sink)


# STEP (ISO 10303-21)


def _complete_step(text: str, model: _Model) -> str:
    stem = Path(model.file).stem
    header = f"FILE_NAME('{model.file}','1970-01-01T00:00:00',(''),(''),'cadbem','gmsh','');\n"
    text = re.sub(r"FILE_NAME\(.*?\);\n", lambda _: header, text, count=1, flags=re.DOTALL)
    text = re.sub(r"'Open CASCADE STEP translator[^']*'", f"'{stem}'", text)
    text = _STEP_POINT.sub(lambda found: _sharpened(found, model), text)
    entities = {int(n): (kind, body) for n, kind, body in _STEP_ENTITY.findall(text)}
    faces = {
        number: np.array(list(_step_corners(body.split("),")[0], entities)))
        for number, (kind, body) in entities.items()
        if kind == "ADVANCED_FACE"
    }
    names = model.named(faces)
    return re.sub(
        r"#(\d+) = ADVANCED_FACE\(''",
        lambda found: f"#{found[1]} = ADVANCED_FACE('{names[int(found[1])]}'",
        text,
    )


def _sharpened(found: re.Match[str], model: _Model) -> str:
    """A point of the file; if it is a corner, with the corner's own digits."""
    point = np.array([float(found[k]) for k in (2, 3, 4)])
    index, distance = model.nearest(point)
    if distance > 1e-11 * np.abs(model.corners).max():
        return found[0]
    digits = (repr(float(x) + 0.0).upper() for x in model.corners[index])
    return f"{found[1]}({','.join(digits)})"


def _step_corners(
    references: str, entities: dict[int, tuple[str, str]]
) -> Iterator[tuple[float, ...]]:
    """The corners that a face's bounds lead to, without going into its surface and curves."""
    for number in map(int, re.findall(r"#(\d+)", references)):
        kind, body = entities.get(number, ("", ""))
        if kind == "CARTESIAN_POINT":
            yield tuple(map(float, body[body.index("(") + 1 : -1].split(",")))
        elif kind in _FACE_TO_CORNER:
            yield from _step_corners(body, entities)


# IGES 5.3


@dataclass(frozen=True)
class _IgesEntity:
    kind: int
    parameters: list[str]  # without the leading type number
    matrix: int  # directory number of its transformation (type 124), 0 for none


def _complete_iges(text: str, model: _Model) -> str:
    sections: dict[str, list[str]] = {letter: [] for letter in "SGDPT"}
    for line in text.splitlines():
        sections[line[72]].append(line)
    entities = _iges_entities(sections["D"], sections["P"])
    faces = {
        number: np.vstack([_iges_ends(int(loop), entities) for loop in _loops(entity)])
        for number, entity in entities.items()
        if entity.kind == 144
    }
    for number, name in model.named(faces).items():
        if len(name) > 8:
            raise CadError(f"{model.file}: face name {name!r} is longer than IGES's 8 characters")
        line = sections["D"][number]  # the entity's second line: numbers count from 1
        sections["D"][number] = f"{line[:56]}{name:>8}{line[64:]}"
    sections["G"] = _iges_global(sections["G"], model.file)
    counts = "".join(f"{letter}{len(sections[letter]):7}" for letter in "SGDP")
    sections["T"] = [f"{counts:72}T      1"]
    return "\n".join(line for letter in "SGDPT" for line in sections[letter]) + "\n"


def _iges_entities(directory: list[str], data: list[str]) -> dict[int, _IgesEntity]:
    texts: dict[int, str] = {}
    for line in data:
        number = int(line[64:72])
        texts[number] = texts.get(number, "") + line[:64].rstrip()
    return {
        number: _IgesEntity(
            kind=int(directory[number - 1][:8]),
            parameters=text.rstrip(";").split(",")[1:],
            matrix=int(directory[number - 1][48:56] or 0),
        )
        for number, text in texts.items()
    }


def _loops(face: _IgesEntity) -> list[str]:
    """Directory numbers of a trimmed surface's boundary loops (parameters: N2, outer, inner...)."""
    inner = int(face.parameters[2])
    return [loop for loop in face.parameters[3 : 4 + inner] if int(loop)]


def _iges_ends(number: int, entities: dict[int, _IgesEntity]) -> np.ndarray:
    """End points (n, 3) of a curve in space, or of all the curves of a loop."""
    entity = entities[number]
    if entity.kind == 142:  # loop: the curve in space is its fourth parameter
        return _iges_ends(int(entity.parameters[3]), entities)
    if entity.kind == 102:
        return np.vstack([_iges_ends(int(part), entities) for part in entity.parameters[1:]])
    ends = _ends_of(entity.kind, [float(value) for value in entity.parameters])
    if entity.matrix:
        placement = np.array(entities[entity.matrix].parameters[:12], dtype=float).reshape(3, 4)
        ends = ends @ placement[:, :3].T + placement[:, 3]
    return ends


def _ends_of(kind: int, values: list[float]) -> np.ndarray:
    if kind == 110:  # line
        return np.array(values[:6]).reshape(2, 3)
    if kind == 100:  # arc: height, centre, start, end
        height, _, _, *ends = values[:7]
        return np.column_stack([np.reshape(ends, (2, 2)), [height, height]])
    if kind == 104:  # conic: six coefficients, height, start, end
        height, *ends = values[6:11]
        return np.column_stack([np.reshape(ends, (2, 2)), [height, height]])
    if kind == 126:  # B-spline: its control points follow knots and weights
        last, degree = int(values[0]), int(values[1])
        first = 6 + (last + degree + 2) + (last + 1)
        points = np.reshape(values[first : first + 3 * (last + 1)], (-1, 3))
        return points[[0, -1]]
    raise CadError(f"IGES curve of type {kind} cannot be followed; write STEP instead")


def _iges_global(lines: list[str], file: str) -> list[str]:
    """The global section with the file's name and without dates and versions."""
    fields = "".join(line[:72].rstrip() for line in lines).rstrip(";").split(",")
    stem = Path(file).stem
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
