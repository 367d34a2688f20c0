"""A CAD file opened: its faces, names and unit, and what keeps them from enclosing a fluid."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from scipy.spatial import cKDTree

from cadbem.boundary import Patch
from cadbem.cad.brep import BrepFace, EdgeUse, read_brep
from cadbem.cad.face_geometry import edge_points, points_on, shape_of
from cadbem.cad.iges_text import IgesText
from cadbem.cad.kernel import KernelModel, import_model
from cadbem.cad.layouts import face_patches
from cadbem.cad.marks import FaceMark, Unit, check_choice, chosen, match_marks
from cadbem.cad.sizes import assumed_unit, unusual_size
from cadbem.cad.source import CadSource, read_source
from cadbem.cad.step_text import StepText
from cadbem.errors import CadError
from cadbem.spline.basis import Array

SMALLEST, LARGEST = 1e-4, 1e8  # sizes in mm; the kernel takes points within 1e-7 mm for the same


@dataclass(frozen=True, eq=False)
class CadModel:
    """Faces in millimetres, as the kernel gives them; `unit` is the file's."""

    file: str
    unit: Unit
    faces: tuple[BrepFace, ...]
    names: dict[int, str]
    kernel: KernelModel
    marks: dict[int, FaceMark] = field(default_factory=dict)  # name, layer, colour, by face
    warnings: tuple[str, ...] = ()  # what `read_cad` warns about

    def patches(self, face: BrepFace) -> list[Patch]:
        """The face's patches in the file's unit; raises CadError if there is no way to lay them."""
        name = self.names.get(face.number, "")
        return [
            Patch(replace(s, points=s.points / self.unit.millimetres), name, face.number)
            for s in face_patches(face)
        ]

    def centre(self, face: BrepFace) -> Array:
        """Middle of the box round the face's edges, in the file's unit."""
        points = edge_points(face)
        return 0.5 * (points.min(axis=0) + points.max(axis=0)) / self.unit.millimetres

    def bounds(self) -> Array:
        """Corners (2, 3) of the box of all edges, in the file's unit."""
        points = np.concatenate([edge_points(face) for face in self.faces])
        return np.stack([points.min(axis=0), points.max(axis=0)]) / self.unit.millimetres

    def label(self, face: BrepFace) -> str:
        """The face in words: number, name, kind, edges, holes, place."""
        name = self.names.get(face.number, "")
        quoted = f" '{name}'" if name else ""
        place = self.place(self.centre(face))
        return f"face {face.number}{quoted} ({shape_of(face)}) at {place}"

    def place(self, point: Array) -> str:
        """Coordinates (file's unit) in words."""
        numbers = ", ".join(f"{x:.4g}" for x in np.where(np.abs(point) < 1e-12, 0.0, point))
        return f"[{numbers}] {self.unit.name}".rstrip()

    def obstacles(self) -> list[str]:
        """Why the faces do not enclose one body of fluid, each in one line; [] if they do."""
        return [*self._solid_problems(), *self._edge_problems()]

    def _solid_problems(self) -> list[str]:
        solids = self.kernel.solids
        if len(solids) < 2:
            return []
        boxes = [np.reshape(solid.box, (2, 3)).mean(axis=0) for solid in solids[:6]]
        places = [self.place(box / self.unit.millimetres) for box in boxes]
        listed = "; ".join(
            f"{solid.name or 'solid'} with {solid.faces} faces about {place}"
            for solid, place in zip(solids, places, strict=False)
        )
        more = "; ..." if len(solids) > 6 else ""
        return [
            f"{self.file}: {len(solids)} solids ({listed}{more}); "
            "export only the one that is the fluid's space, or fuse them"
        ]

    def _edge_problems(self) -> list[str]:
        uses = [use for face in self.faces for loop in face.loops for use in loop]
        counts = Counter(use.key for use in uses if use.curve is not None)
        alone = [[u for loop in f.loops for u in loop if counts[u.key] == 1] for f in self.faces]
        free = _unpaired([use for group in alone for use in group])
        loose = [use for group in alone for use in _unpaired(group)]
        crowded = {use.key: use for use in uses if counts[use.key] > 2}
        problems = []
        if free:
            problems.append(
                f"{self.file}: the faces leave openings: {len(free)} edges belong to one face only,"
                f" the first at {self._edge_place(free[0])}; close the surface in the CAD program"
            )
        elif loose:
            problems.append(
                f"{self.file}: the faces touch without being joined, first at "
                f"{self._edge_place(loose[0])}; export them as one solid"
            )
        if crowded and len(self.kernel.solids) < 2:
            problems.append(
                f"{self.file}: {len(crowded)} edges belong to more than two faces, the first at "
                f"{self._edge_place(next(iter(crowded.values())))}; remove inner faces"
            )
        if not (self.kernel.solids or loose) and self._has_turned_faces():
            problems.append(
                f"{self.file}: the faces are turned to different sides; export them as a solid"
            )
        return problems

    def _has_turned_faces(self) -> bool:
        """Neighbours that are turned alike run along their common edge in opposite directions."""
        turns: Counter = Counter()
        for face in self.faces:
            for use in (use for loop in face.loops for use in loop if use.curve is not None):
                turns[use.key] += face.outward * use.sign
        return any(abs(total) > 1 for total in turns.values())

    def _edge_place(self, use: EdgeUse) -> str:
        points = points_on(use)
        return self.place(points[len(points) // 2] / self.unit.millimetres)


def open_model(path: str | Path, time_limit: float, names: str = "names") -> CadModel:
    """Read a STEP or IGES file and find its faces; `names` says what they are called by.

    Raises CadError if the file cannot be read, has no faces, or is absurdly small or large.
    """
    check_choice(names)
    source = read_source(path)
    unit, marks, remarks = _text_marks(source)
    kernel = import_model(source, time_limit)
    if kernel.faces == 0:
        curves = f" but {kernel.curves} curves (a wireframe)" if kernel.curves else ""
        raise CadError(
            f"{source.name}: no faces{curves}; export the fluid's space as a solid or as surfaces"
        )
    faces = _boundary_faces(read_brep(kernel.brep))
    _check_size(source.name, faces)
    _check_unit(source.name, unit, marks, faces)
    matched = match_marks(marks, list(faces), unit)
    warnings = [*remarks, *unusual_size(source.name, unit, faces)]
    called = chosen(matched, names)
    return CadModel(source.name, unit, faces, called, kernel, matched, tuple(warnings))


def file_unit(source: CadSource) -> Unit:
    """The file's unit of length; raises CadError if the text is damaged."""
    return _text_marks(source)[0]


def _text_marks(source: CadSource) -> tuple[Unit, list[FaceMark], list[str]]:
    """Unit, faces and lines to warn with."""
    try:
        text = StepText(source.text) if source.kind == "step" else IgesText(source.text)
        unit, marks = text.unit(), text.faces()
        remarks = [f"{source.name}: {remark}" for remark in text.remarks()]
        return unit, marks, [*remarks, *assumed_unit(source.name, unit)]
    except (LookupError, ArithmeticError, ValueError, RecursionError) as error:
        what = error if isinstance(error, ValueError) else f"{type(error).__name__}: {error}"
        raise CadError(
            f"{source.name}: the text is damaged ({what}); export it again from the CAD program"
        ) from None


def _boundary_faces(faces: list[BrepFace]) -> tuple[BrepFace, ...]:
    """The faces of solids, or all faces where there is no solid."""
    of_solids = tuple(face for face in faces if face.solid)
    return of_solids or tuple(faces)


def _unpaired(free: list[EdgeUse]) -> list[EdgeUse]:
    """Edges that do not lie on another one; both sides of a seam do."""
    points = [points_on(use) for use in free]
    if not points:
        return []
    tolerance = 1e-6 * float(np.ptp(np.concatenate(points), axis=0).max())
    middles = np.array([p.mean(axis=0) for p in points])
    paired: set[int] = set()
    for i, j in sorted(cKDTree(middles).query_pairs(tolerance)):
        if paired.isdisjoint((i, j)) and _coincide(points[i], points[j], tolerance):
            paired |= {i, j}
    return [use for k, use in enumerate(free) if k not in paired]


def _coincide(first: Array, second: Array, tolerance: float) -> bool:
    if len(first) != len(second):
        return False
    gaps = [np.abs(first - other).max() for other in (second, second[::-1])]
    return bool(min(gaps) < tolerance)


def _check_unit(file: str, unit: Unit, marks: list[FaceMark], faces: tuple[BrepFace, ...]) -> None:
    """Our reading of the unit against the kernel's, by the size of what the text describes."""
    written = [p for mark in marks for p in (mark.corners, mark.middles) if len(p)]
    sizes = [
        float(np.linalg.norm(np.ptp(np.concatenate(points), axis=0))) if points else 0.0
        for points in (written, [edge_points(face) for face in faces])
    ]
    if sizes[0] < 1e-6 * sizes[1] / unit.millimetres:  # a sphere has one corner only
        return
    ratio = sizes[1] / (sizes[0] * unit.millimetres)
    if not 0.12 < ratio < 8:  # parts may be turned, units differ by 10 at least
        raise CadError(
            f"{file}: the CAD kernel takes lengths {ratio:.3g} times as long as the file's unit "
            f"({unit.name or 'none'}) says; export the model again in millimetres"
        )


def _check_size(file: str, faces: tuple[BrepFace, ...]) -> None:
    points = np.concatenate([edge_points(face) for face in faces])
    size = float(np.ptp(points, axis=0).max()) if len(points) else 0.0
    if not SMALLEST < size < LARGEST:  # also if not a number
        raise CadError(
            f"{file}: the model is {size:.3g} mm large, which the CAD kernel cannot handle "
            f"({SMALLEST:g} to {LARGEST:g} mm); check the unit or scale it"
        )
    bare = [face.number for face in faces if not len(edge_points(face))]
    if bare:
        raise CadError(f"{file}: face {bare[0]} has no edges; export it again, perhaps larger")
