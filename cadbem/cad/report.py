"""The health of a CAD file: what its faces are, and what keeps it from being a boundary."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from math import inf, nan
from pathlib import Path

import numpy as np
from tqdm import tqdm

from cadbem.boundary import Boundary, Patch
from cadbem.cad.brep import BrepFace
from cadbem.cad.face_geometry import points_on
from cadbem.cad.gaps import largest_distance
from cadbem.cad.model import CadModel, open_model
from cadbem.cad.read import REMEDY, oriented
from cadbem.errors import CadError
from cadbem.spline.basis import Array


@dataclass(frozen=True)
class FaceReport:
    """One face; lengths in the file's unit. `area` is nan and `patches` 0 if `problem` is set."""

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


@dataclass(frozen=True, eq=False)
class CadReport:
    """A file and its faces; lengths in the file's `unit`.

    `area`, `volume` and `gap` (largest distance between a patch and an edge that two faces share)
    are those of the patches, nan if some face has none. `bounds` (2, 3) is the box of edges and
    patches, by sampling.
    `problems` are lines that say what is wrong and what to do; there are none if `read_cad` works.
    `remarks` are what `read_cad` warns about, and what the CAD kernel complained about.
    """

    file: str
    unit: str
    faces: tuple[FaceReport, ...]
    area: float
    volume: float
    bounds: Array
    gap: float
    problems: tuple[str, ...]
    remarks: tuple[str, ...]


def inspect_cad(path: str | Path, *, names: str = "names", time_limit: float = 60.0) -> CadReport:
    """Describe a STEP or IGES file, also one that `read_cad` refuses; `names` as there.

    Raises CadError only if the file cannot be read at all or has no faces.
    """
    model = open_model(path, time_limit, names)
    patches: dict[int, list[Patch]] = {}
    reports = []
    for face in tqdm(model.faces, desc=f"{model.file}: faces", delay=2, leave=False, disable=None):
        report, patches[face.number] = _examined(model, face)
        reports.append(report)
    problems = [*model.obstacles(), *(r.problem for r in reports if r.problem)]
    everything = tuple(patch for group in patches.values() for patch in group)
    area = volume = gap = nan
    if not any(r.problem for r in reports):
        area, gap = sum(r.area for r in reports), _largest_gap(model, patches)
    if not problems:
        try:
            boundary = oriented(Boundary(everything, model.file, model.unit.name))
            volume = _converged(boundary.volume)
        except CadError as error:
            problems.append(str(error))
    return CadReport(
        model.file, model.unit.name, tuple(reports), area, volume, _bounds(model, everything), gap,
        tuple(problems), (*model.warnings, *model.kernel.log),
    )  # fmt: skip


def _examined(model: CadModel, face: BrepFace) -> tuple[FaceReport, list[Patch]]:
    name = model.names.get(face.number, "")
    mark = model.marks.get(face.number)
    says = (mark.layer, mark.colour) if mark else ("", "")
    kind = face.surface.kind
    try:
        patches = model.patches(face)
    except CadError:
        problem = f"{model.file}: {model.label(face)} cannot become patches: {REMEDY}"
        centre = tuple(model.centre(face).tolist())
        return FaceReport(face.number, name, kind, (), 0, nan, centre, problem, *says), []
    group = Boundary(tuple(patches))
    area = _converged(group.area)
    points, weights = group.quadrature()
    centre = tuple((points.position @ weights / weights.sum()).tolist())
    degrees = tuple(max(d) for d in zip(*(p.surface.degrees for p in patches), strict=True))
    counts = face.number, name, kind, degrees, len(patches), area, centre
    return FaceReport(*counts, "", *says), patches


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
    for face in tqdm(model.faces, desc=f"{model.file}: gaps", delay=2, leave=False, disable=None):
        uses = [use for loop in face.loops for use in loop if counts[use.key] > 1]
        points = [points_on(use).T for use in uses if use.curve is not None]
        if points:
            places = np.concatenate(points, axis=1) / model.unit.millimetres
            gap = max(gap, largest_distance(places, patches[face.number]))
    return gap
