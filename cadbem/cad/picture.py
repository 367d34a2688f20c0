"""Lines and triangles that show the defective faces of a CAD file in a picture."""

from __future__ import annotations

import numpy as np
from scipy.spatial import Delaunay

from cadbem.cad.body.defects import find_defects
from cadbem.cad.body.orientation import real_uses
from cadbem.cad.faces.face_geometry import sampled, world_curve
from cadbem.cad.kernel.brep import BrepFace, EdgeUse
from cadbem.cad.layout.charts import PlaneChart, SurfaceChart, chart_of
from cadbem.cad.layout.region import Region, distance
from cadbem.cad.survey import CadSurvey
from cadbem.errors import CadError
from cadbem.spline.basis import Array

GRID = 40  # triangles along the longer side of a face


def defect_lines(survey: CadSurvey) -> dict[int, list[Array]]:
    """Polylines (3, N) in the file's unit on each defective face, by number: all its edges if it
    has no patches, else those edges that are at fault."""
    uses: dict[int, list[EdgeUse]] = {n: [] for n in survey.refused}
    for face in survey.model.faces:
        if face.number in uses:
            uses[face.number] += real_uses(face)
    for defect in find_defects(survey.model.faces):
        for number in set(defect.faces) - survey.refused.keys():
            uses.setdefault(number, []).append(defect.use)
    scale = survey.model.unit.millimetres
    return {n: [_polyline(use) / scale for use in uses[n]] for n in sorted(uses)}


def skins(survey: CadSurvey) -> dict[int, Array]:
    """Triangles (M, 3 corners, 3) in the file's unit on faces that have no patches, by number;
    their normals point into the fluid. Faces whose edges are too odd for that are left out."""
    found = {}
    for face in survey.model.faces:
        if face.number in survey.refused:
            try:
                chart = chart_of(face)
            except (CadError, ValueError):
                continue
            if chart is not None:
                found[face.number] = _skin(face, chart) / survey.model.unit.millimetres
    return found


def _polyline(use: EdgeUse) -> Array:
    try:
        curve = world_curve(use)
    except CadError:  # no NURBS; its ends must do
        return use.ends.T
    assert curve is not None
    return sampled(curve)


def _skin(face: BrepFace, chart: PlaneChart | SurfaceChart) -> Array:
    skin = []
    for region in chart.regions:
        flat, cells = triangulated(region)
        if isinstance(chart, PlaneChart):
            points = chart.origin + flat.T @ chart.axes
        else:
            points = chart.surface.points(*(flat / chart.scale[:, None])).T
        skin.append(points[cells[:, ::-1] if face.outward > 0 else cells])
    return np.concatenate(skin)


def triangulated(region: Region) -> tuple[Array, np.ndarray]:
    """Points (2, N) and triangles (M, 3), counter-clockwise, of about equal size."""
    start, end = region.segments
    low, high = start.min(axis=1), start.max(axis=1)
    step = float((high - low).max()) / GRID
    counts = np.ceil(np.hypot(*(end - start)) / step).astype(int)
    shares = np.concatenate([np.arange(n) / n for n in counts if n])
    border = np.repeat(start, counts, axis=1) + shares * np.repeat(end - start, counts, axis=1)
    grid = np.meshgrid(*[np.arange(a + step / 2, b, step) for a, b in zip(low, high, strict=True)])
    inner = np.stack([axis.ravel() for axis in grid])
    clear = distance(inner, region.segments).min(axis=1) > step / 2
    points = np.concatenate([border, inner[:, clear & _inside(inner, region)]], axis=1)
    cells = Delaunay(points.T).simplices
    return points, cells[_inside(points[:, cells].mean(axis=2), region)]


def _inside(points: Array, region: Region) -> np.ndarray:
    """Points (2, n) from which a ray along x meets the border an odd number of times."""
    (x0, y0), (x1, y1) = region.segments
    x, y = points[:, :, None]
    crossed = (y0 <= y) != (y1 <= y)
    with np.errstate(divide="ignore", invalid="ignore"):
        ahead = x < x0 + (y - y0) / (y1 - y0) * (x1 - x0)
    return (crossed & ahead).sum(axis=1) % 2 == 1
