"""A channel of constant height over the plan in a drawing."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from cadbem.boundary import Boundary, Patch
from cadbem.cad.drawn_plan import drawn_plan
from cadbem.cad.kernel.brep_geometry import BSPLINE, CurveRecord, SplineRecord
from cadbem.cad.layout.charts import PlaneChart, region_from
from cadbem.cad.layout.partition import divided
from cadbem.cad.layout.trimming_curves import TrimmingCurve
from cadbem.checks import positive, shaped, whole
from cadbem.errors import CadError
from cadbem.progress import stage
from cadbem.spline.nurbs import Nurbs

FLOOR, CEILING = 1, 2  # numbers of the plane faces; walls are numbered on from 3
TOLERANCE = 1e-9  # deviation per size of parts that cannot be blended exactly
UNCOVERED = 1e-6  # share of the plan by which patches may miss it


def read_layout(
    path: str | Path,
    height: float,
    *,
    layer: str | int | None = None,
    ports: Sequence[ArrayLike] | None = None,
    region: int | None = None,
) -> Boundary:
    """The channel of a ``height`` over the outline in a DXF or GDS file, from z = 0 up.

    ``layer`` and ``region`` choose the outline as in `read_outline`. Walls where it meets a frame,
    drawn on another layer, are called port_1, port_2, ... by x, then y; ``ports`` are points
    (x, y) on the outline instead, in their order. Ports keep their names in `named(rest=...)`.
    Face 1 is the floor, 2 the ceiling; walls are numbered on from 3. Lengths, the height too, are
    in the file's unit, which the boundary has.

    Raises CadError as `read_outline` does, and if no well-shaped patches cover the plan.
    """
    positive("height", height)
    if region is not None:
        whole("region", region)
    for k, port in enumerate(() if ports is None else ports, start=1):
        shaped(f"ports, point {k}", port, 2)
    with stage(f"reading {path}"):
        return extruded_plan(drawn_plan(path, layer, region=region, ports=ports), height)


def extruded_plan(plan: Boundary, height: float) -> Boundary:
    """Floor, ceiling and walls over a plane boundary with the fluid to the right of its curves."""
    up = np.array([0.0, 0.0, height])
    floor = [Patch(surface, "", FLOOR) for surface in _plane_patches(plan)]
    ceiling = [
        Patch(patch.surface.transformed(np.eye(3), up).swapped(), "", CEILING) for patch in floor
    ]
    walls = [
        replace(patch, surface=_wall(patch.surface, up), face=CEILING + number)
        for number, patch in enumerate(plan.patches, start=1)
    ]
    return replace(plan, patches=(*floor, *ceiling, *walls))


def _wall(curve: Nurbs, up: np.ndarray) -> Nurbs:
    """Over a curve; its normal points to the right of it."""
    low = np.column_stack([curve.points, np.zeros(len(curve.points))])
    points = np.stack([low, low + up], axis=1)
    weights = np.stack([curve.weights] * 2, axis=1)
    knots = (curve.knots[0], np.repeat([0.0, 1.0], 2))
    return Nurbs((*curve.degrees, 1), knots, points, weights)


def _plane_patches(plan: Boundary) -> list[Nurbs]:
    """Patches (in space, z = 0) that cover the plan, their normals along z."""
    loops = [[_trim(patch.surface) for patch in ring] for ring in _rings(plan)]
    region = region_from(loops)
    parts = divided(region) if region else None
    if region is None or not parts:
        raise CadError(
            f"{plan.source}: no way was found to divide the plan into well-shaped patches; "
            "remove slivers, or split it into several outlines"
        )
    chart = PlaneChart((region,), np.zeros(3), np.eye(2, 3))
    allowed = TOLERANCE * region.size
    surfaces = [surface for part in parts for surface, _ in chart.pieces(part, allowed)]
    area, expected = Boundary(tuple(map(Patch, surfaces))).area(), plan.volume()
    if abs(area - expected) > UNCOVERED * expected:
        raise CadError(
            f"{plan.source}: patches would cover {area / expected:.7f} of the plan; "
            "remove slivers, or split it into several outlines"
        )
    return surfaces


def _rings(plan: Boundary) -> list[list[Patch]]:
    """Curves of the plan, which follow each other round each loop."""
    rings: list[list[Patch]] = []
    for patch in plan.patches:
        if rings and not _is_closed(plan, rings[-1]):
            rings[-1].append(patch)
        else:
            rings.append([patch])
    return rings


def _is_closed(plan: Boundary, ring: list[Patch]) -> bool:
    gap = np.abs(ring[-1].surface.points[-1] - ring[0].surface.points[0]).max()
    return bool(gap < 2e-4 * np.ptp(plan.bounds(), axis=0).max())


def _trim(curve: Nurbs) -> TrimmingCurve:
    spline = SplineRecord(curve.degrees, curve.knots, curve.points, curve.weights, (False,))
    low, high = curve.domain[0]
    return TrimmingCurve(CurveRecord(BSPLINE, np.zeros((0, 2)), spline=spline), low, high)
