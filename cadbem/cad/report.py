"""The report on a CAD file: its faces, and what prevents them from being a boundary."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from math import inf, nan
from pathlib import Path

import numpy as np

from cadbem.boundary import Boundary, Patch
from cadbem.cad.body.between import Pick
from cadbem.cad.body.gaps import largest_distance
from cadbem.cad.body.model import CadModel
from cadbem.cad.body.witness import disagreements
from cadbem.cad.chips import chip_remarks
from cadbem.cad.faces.face_geometry import edge_points, points_on
from cadbem.cad.faces.flux import face_area, face_flux
from cadbem.cad.kernel.brep import BrepFace
from cadbem.cad.layout.face_patches import TOLERANCE
from cadbem.cad.layout.quality import jacobian_ratio, worst_angle
from cadbem.cad.survey import CadSurvey, survey_cad
from cadbem.checks import positive, within
from cadbem.errors import CadError
from cadbem.progress import progress
from cadbem.spline.basis import Array


@dataclass(frozen=True)
class FaceReport:
    """One face; lengths in the file's unit. `area` is nan and `patches` 0 if `problem` is set.

    `exact_area` is that of the CAD kernel's own surface within the face's edges. `deviation` is
    the largest distance of patches from it; `angle` (degrees) the smallest between parameter lines
    and `jacobian_ratio` the least over the largest area element, of the worst patch.
    """

    number: int
    name: str
    kind: str
    degrees: tuple[int, ...]
    patches: int
    area: float
    centre: tuple[float, ...]
    problem: str = ""
    layer: str = ""
    colour: str = ""  # "#rrggbb"
    exact_area: float = nan
    deviation: float = nan
    angle: float = nan
    jacobian_ratio: float = nan


@dataclass(frozen=True, eq=False)
class CadReport:
    """A file and its faces; lengths in the file's `unit`.

    `area`, `volume` and `gap` (largest distance between a patch and an edge that two faces share)
    are those of the patches, nan if some face has none; `exact_area` and `exact_volume` those of
    the CAD kernel's surfaces and edges, integrated without patches. `bounds` (2, 3) is the box of
    edges and patches, by sampling.
    `problems` are lines that say what is wrong and what to do; there are none if `read_cad` works.
    `remarks` are what `read_cad` warns about, and what the CAD kernel complained about.
    `defects` says what is wrong with faces, by number.
    """

    file: str
    unit: str
    faces: tuple[FaceReport, ...]
    area: float
    volume: float
    exact_area: float
    exact_volume: float
    bounds: Array
    gap: float
    problems: tuple[str, ...]
    remarks: tuple[str, ...]
    defects: dict[int, str]

    @property
    def deviation(self) -> float:
        """Largest distance of a patch from its face."""
        return max((f.deviation for f in self.faces if not f.problem), default=nan)


def inspect_cad(
    path: str | Path,
    *,
    fluid: int | str = "solid",
    between: Sequence[Pick] = (),
    names: str = "names",
    tolerance: float = TOLERANCE,
    sew: float = 0.0,
    time_limit: float = 60.0,
) -> CadReport:
    """Describe a STEP or IGES file, also one that `read_cad` refuses; arguments as there.

    Raises CadError only if the file cannot be read at all or has no faces.
    """
    within("tolerance", tolerance, 1e-16, 0.1)
    positive("time_limit", time_limit)
    survey = survey_cad(
        path, fluid=fluid, between=between, names=names, tolerance=tolerance, sew=sew,
        time_limit=time_limit,
    )
    model = survey.model
    label = f"{model.file}: measures"
    faces = progress(model.faces, label)
    reports = [_examined(survey, face) for face in faces]
    refused = {r.number: r.problem for r in reports if r.problem}
    area = volume = gap = nan
    if not refused:
        area, gap = sum(r.area for r in reports), _largest_gap(model, survey.patches)
    witnessed: list[str] = []
    if not survey.problems:
        witnessed = disagreements(model, survey.boundary)
        volume = _converged(survey.boundary.volume)
    return CadReport(
        file=model.file,
        unit=model.unit.name,
        faces=tuple(reports),
        area=area,
        volume=volume,
        exact_area=sum(r.exact_area for r in reports),
        exact_volume=_exact_volume(model),
        bounds=_bounds(model, survey.boundary.patches),
        gap=gap,
        problems=survey.problems,
        remarks=(
            *model.warnings,
            *chip_remarks(path, model, time_limit),
            *_relaxed(survey, tolerance),
            *witnessed,
            *model.kernel.log,
        ),
        defects=refused | model.defective_faces(),
    )


def _relaxed(survey: CadSurvey, tolerance: float) -> list[str]:
    """Remarks on faces whose patches deviate by more than the tolerance."""
    return [
        line
        for face in survey.model.faces
        if face.number in survey.deviations
        for line in survey.model.relaxed(face, survey.deviations[face.number], tolerance)
    ]


def _examined(survey: CadSurvey, face: BrepFace) -> FaceReport:
    model, label = survey.model, survey.model.labels.get(face.number)
    report = FaceReport(
        number=face.number,
        name=model.names.get(face.number, ""),
        kind=face.surface.kind,
        degrees=(),
        patches=0,
        area=nan,
        centre=tuple(model.centre(face).tolist()),
        layer=label.layer if label else "",
        colour=label.colour if label else "",
        exact_area=_exact(lambda: face_area(face)) / model.unit.millimetres**2,
    )
    if face.number in survey.refused:
        return replace(report, problem=f"{model.file}: {survey.refused[face.number]}")
    patches = survey.patches[face.number]
    points, weights = Boundary(tuple(patches)).quadrature()
    surfaces = [patch.surface for patch in patches]
    return replace(
        report,
        degrees=tuple(max(d) for d in zip(*(s.degrees for s in surfaces), strict=True)),
        patches=len(patches),
        area=_converged(Boundary(tuple(patches)).area),
        centre=tuple((points.position @ weights / weights.sum()).tolist()),
        deviation=survey.deviations[face.number],
        angle=float(np.degrees(min(worst_angle(surface) for surface in surfaces))),
        jacobian_ratio=min(jacobian_ratio(surface) for surface in surfaces),
    )


def _exact(integral: Callable[[], float]) -> float:
    """nan where edges lack what the integral needs."""
    try:
        return integral()
    except CadError:
        return nan


def _exact_volume(model: CadModel) -> float:
    centre = np.concatenate([edge_points(face) for face in model.faces]).mean(axis=0)
    volume = _exact(lambda: sum(f.outward * face_flux(f, centre) for f in model.faces))
    return abs(volume) / model.unit.millimetres**3


def _bounds(model: CadModel, patches: tuple[Patch, ...]) -> Array:
    points = [model.bounds()]
    for patch in patches:
        grid = np.meshgrid(*[np.linspace(*ends, 9) for ends in patch.surface.domain])
        points.append(patch.surface.evaluate(*grid).reshape(3, -1).T)
    stacked = np.concatenate(points)
    return np.stack([stacked.min(axis=0), stacked.max(axis=0)])


def _converged(integral: Callable[[int], float]) -> float:
    """Gauss quadrature of rising order, until two results agree to 1e-13."""
    previous, value = inf, integral(8)
    for order in (16, 32, 64):
        if abs(value - previous) <= 1e-13 * abs(value):
            break
        previous, value = value, integral(order)
    return value


def _largest_gap(model: CadModel, patches: dict[int, list[Patch]]) -> float:
    counts = Counter(
        key for face in model.faces for key in {u.key for loop in face.loops for u in loop}
    )
    gap = 0.0
    for face in progress(model.faces, f"{model.file}: gaps"):
        uses = [use for loop in face.loops for use in loop if counts[use.key] > 1]
        points = [points_on(use).T for use in uses if use.curve is not None]
        if points:
            places = np.concatenate(points, axis=1) / model.unit.millimetres
            gap = max(gap, largest_distance(places, patches[face.number]))
    return gap
