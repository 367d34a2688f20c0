"""An opened CAD file: its faces, their names, its unit, and what prevents a closed boundary."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from cadbem.boundary import Patch
from cadbem.cad.body.between import Pick
from cadbem.cad.body.defects import APART, CROWDED, OPEN, TURNED, Defect, find_defects, widest_gap
from cadbem.cad.body.fluid import choose_fluid, room_of
from cadbem.cad.body.sizes import assumed_unit, unusual_size
from cadbem.cad.faces.consistency import contradictions, sewing_gaps
from cadbem.cad.faces.face_geometry import edge_points, shape_of, size_of
from cadbem.cad.faces.reprojection import reprojected
from cadbem.cad.kernel.brep import BrepFace, read_brep
from cadbem.cad.kernel.process import KernelModel, import_model
from cadbem.cad.labels.face_labels import FaceLabel, check_choice, chosen, match_labels
from cadbem.cad.labels.iges_labels import IgesText
from cadbem.cad.labels.step_labels import StepText
from cadbem.cad.layout.causes import likely_cause
from cadbem.cad.layout.face_patches import face_patches
from cadbem.cad.text.source import CadSource, read_source
from cadbem.cad.text.unit import Unit
from cadbem.errors import CadError
from cadbem.spline.basis import Array

SMALLEST, LARGEST = 1e-4, 1e8  # sizes in mm; the kernel takes points within 1e-7 mm for the same
WIDEST = 5e-4  # gap, per size, that may be sewn on request
_COMPLAINTS = {  # number of edges and place of the first; what to do
    OPEN: (
        "the faces leave openings: {} edges belong to one face only, the first at {}",
        "close the surface in the CAD program",
    ),
    APART: ("the faces touch without being joined, first at {1}", "export them as one solid"),
    CROWDED: ("{} edges belong to more than two faces, the first at {}", "remove inner faces"),
    TURNED: ("the faces are turned to different sides, first at {1}", "export them as a solid"),
}


@dataclass(frozen=True, eq=False)
class CadModel:
    """Faces in millimetres, as the kernel gives them; `unit` is the file's."""

    file: str
    unit: Unit
    faces: tuple[BrepFace, ...]
    names: dict[int, str]
    kernel: KernelModel
    labels: dict[int, FaceLabel] = field(default_factory=dict)  # name, layer, colour, by face
    warnings: tuple[str, ...] = ()  # what `read_cad` warns about
    question: str = ""  # what the file leaves open, see `fluid` of `read_cad`
    refusals: tuple[str, ...] = ()  # what in the file contradicts itself
    bodies: tuple[int, ...] = ()  # solids of the record (from 1) that are the fluid
    caps: frozenset[int] = frozenset()  # numbers of faces that the file does not have
    ports: frozenset[int] = frozenset()  # numbers of faces that are openings

    def patches(self, face: BrepFace, tolerance: float) -> tuple[list[Patch], float]:
        """The face's patches and their largest deviation from it, in the file's unit.

        `tolerance` is the deviation allowed, per size of the face, where patches cannot be exact.
        Raises CadError if there is no way to lay them.
        """
        name, scale = self.names.get(face.number, ""), self.unit.millimetres
        port = face.number in self.ports
        try:
            covering = face_patches(face, tolerance)
        except CadError as error:
            cause = self._cause(face)
            raise CadError(f"{self.label(face)} cannot become patches: {cause}{error}") from None
        patches = [
            Patch(replace(surface, points=surface.points / scale), name, face.number, port)
            for surface in covering.surfaces
        ]
        return patches, covering.deviation / scale

    def _cause(self, face: BrepFace) -> str:
        """What is odd about the face, in words for a message; "" if nothing is."""
        cause = likely_cause(face)
        if cause is None:
            return ""
        place = self.place(cause.place / self.unit.millimetres)
        length = f"{cause.size / self.unit.millimetres:.2g} {self.unit.name}".rstrip()
        words = {
            "corner": f"it has a corner of {cause.size:.2g}°",
            "gap": f"edges are only {length} apart",
            "edge": f"it has an edge {length} long",
        }
        return f"{words[cause.kind]} at {place}; "

    def relaxed(self, face: BrepFace, deviation: float, tolerance: float) -> list[str]:
        """A line to warn with if a face's patches deviate (file's unit) by more than the
        tolerance."""
        size = size_of(face) / self.unit.millimetres
        if deviation <= tolerance * size:
            return []
        return [
            f"{self.file}: patches of {self.label(face)} deviate from it by {deviation / size:.1e} "
            f"of its size instead of {tolerance:g}: its edges are that far off it"
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
        if self.question:
            return [self.question]
        defects = find_defects(self.faces)
        lines = list(self.refusals)
        for reason, (words, remedy) in _COMPLAINTS.items():
            found = [defect for defect in defects if defect.reason == reason]
            if found and not (reason == APART and lines):
                place = self.place(found[0].place() / self.unit.millimetres)
                said = words.format(len(found), place)
                sheet = ", or read a plane sketch by read_outline" * (len(self.faces) == 1)
                apart = self._gap(found) if reason in (OPEN, APART) else ""
                lines.append(f"{self.file}: {said}{apart}; {remedy}{sheet}")
        return lines

    def _gap(self, defects: Sequence[Defect]) -> str:
        """How far open edges are from each other, and the remedy; "" if they are far."""
        gap, size = widest_gap(defects), size_of(*self.faces)
        if not 0 < gap <= WIDEST * size:
            return ""
        digit = 10.0 ** np.floor(np.log10(1.1 * gap / size))
        share = min(WIDEST, digit * np.ceil(1.1 * gap / size / digit))
        words = f"{gap / self.unit.millimetres:.2g} {self.unit.name} ({gap / size:.1g} of the size)"
        return f": they are up to {words} apart, and sew={share:g} joins them"

    def defective_faces(self) -> dict[int, str]:
        """The defects of faces that leave the surface open or ambiguous, by number."""
        reasons: dict[int, str] = {}
        for defect in find_defects(self.faces):
            place = self.place(defect.place() / self.unit.millimetres)
            for number in defect.faces:
                reasons.setdefault(number, f"the edge at {place} {defect.reason}")
        return reasons


def open_model(
    path: str | Path,
    time_limit: float,
    names: str = "names",
    fluid: int | str = "solid",
    between: Sequence[Pick] = (),
    sew: float = 0.0,
) -> CadModel:
    """Read a STEP or IGES file and find its faces; `names` says what they are called by, `fluid`
    or `between` what they enclose, `sew` which gaps may be closed.

    Raises CadError if the file cannot be read, has no faces, or is absurdly small or large.
    """
    check_choice(names)
    if not 0 <= sew <= WIDEST:
        raise CadError(f"sew={sew!r}: give a gap per size of the model, at most {WIDEST:g}")
    room = "all" if len(between) else room_of(fluid)
    source = read_source(path)
    unit, labels, remarks = _text_marks(source)
    kernel = import_model(source, time_limit, "all" if room == "void" else room, sew)
    everything = read_brep(kernel.brep) if kernel.faces else []
    found = choose_fluid(source, unit, kernel, everything, fluid, between) if everything else None
    if room == "void" and not (found and found.faces):  # no mouths: the room in the solids' box
        kernel, found = import_model(source, time_limit, room, sew), None
    if kernel.box and kernel.faces == 0:
        raise CadError(f"{source.name}: the solids fill their box, there is no void in them")
    if kernel.faces == 0:
        curves = f" but {kernel.curves} curves (a wireframe)" if kernel.curves else ""
        raise CadError(
            f"{source.name}: no faces{curves}; export the fluid's space as a solid or as surfaces"
        )
    everything = everything if found else read_brep(kernel.brep)
    _check_size(source.name, tuple(everything))
    points = [edge_points(face) for face in everything]
    extent = np.reshape(kernel.box, (2, 3)) if kernel.box else np.concatenate(points)
    _check_unit(source.name, unit, labels, extent)
    found = found or choose_fluid(source, unit, kernel, everything, fluid, between)
    faces, renewed = reprojected(found.faces)
    anew = (
        f"{source.name}: healed: {renewed} edges, whose curves in a face's parameters were off it, "
        "were projected to the face anew",
    ) * bool(renewed)
    doubts, refusals = contradictions(source.name, unit, faces)
    matched = match_labels(labels, list(faces), unit)
    healed = [f"{source.name}: healed: {line}" for line in kernel.healed]
    if kernel.sewn:
        healed += sewing_gaps(source.name, unit, faces)
    warnings = [
        *remarks, *healed, *anew, *found.warnings, *unusual_size(source.name, unit, faces), *doubts
    ]  # fmt: skip
    marked = found.sheets if names == "names" else {}
    called = chosen(matched, names) | marked | found.ports
    return CadModel(
        source.name, unit, faces, called, kernel, matched, tuple(warnings), found.question,
        tuple(refusals), found.bodies, found.caps, frozenset(found.ports),
    )  # fmt: skip


def file_unit(source: CadSource) -> Unit:
    """The file's unit of length; raises CadError if the text is damaged."""
    return _text_marks(source)[0]


def _text_marks(source: CadSource) -> tuple[Unit, list[FaceLabel], list[str]]:
    """Unit, faces and lines to warn with."""
    if source.kind == "brep":  # it has no names, and no unit
        unit = Unit("mm", 1.0, assumed=True)
        return unit, [], assumed_unit(source.name, unit)
    try:
        text = StepText(source.text) if source.kind == "step" else IgesText(source.text)
        unit, labels = text.unit(), text.faces()
        remarks = [f"{source.name}: {remark}" for remark in text.remarks()]
        return unit, labels, [*remarks, *assumed_unit(source.name, unit)]
    except (LookupError, ArithmeticError, ValueError, RecursionError) as error:
        what = error if isinstance(error, ValueError) else f"{type(error).__name__}: {error}"
        raise CadError(
            f"{source.name}: the text is damaged ({what}); export it again from the CAD program"
        ) from None


def _check_unit(file: str, unit: Unit, labels: list[FaceLabel], extent: Array) -> None:
    """Our reading of the unit against the kernel's, by the size of what the text describes;
    `extent` (n, 3) are points of all that the kernel read."""
    written = [p for label in labels for p in (label.corners, label.middles) if len(p)]
    sizes = [
        float(np.linalg.norm(np.ptp(np.concatenate(points), axis=0))) if points else 0.0
        for points in (written, [extent])
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
    size = size_of(*faces)
    if not SMALLEST < size < LARGEST:  # also if not a number
        raise CadError(
            f"{file}: the model is {size:.3g} mm large, which the CAD kernel cannot handle "
            f"({SMALLEST:g} to {LARGEST:g} mm); check the unit or scale it"
        )
    bare = [face.number for face in faces if not len(edge_points(face))]
    if bare:
        raise CadError(f"{file}: face {bare[0]} has no edges; export it again, perhaps larger")
