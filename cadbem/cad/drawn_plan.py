"""The plan of a channel in a drawing, DXF or GDS: its outline with ports at the frame."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from warnings import warn

import numpy as np
from numpy.typing import ArrayLike

from cadbem.boundary import Boundary, Patch
from cadbem.cad.body.sizes import assumed_unit
from cadbem.cad.drawings.drawing import Drawing, DrawnCurve
from cadbem.cad.drawings.dxf import read_dxf
from cadbem.cad.drawings.frames import closed_at_frame, on_frame, split_frame
from cadbem.cad.drawings.gds import read_gds
from cadbem.cad.plane_region import in_words, plane_region
from cadbem.errors import CadError, CadWarning
from cadbem.spline.basis import Array
from cadbem.spline.project import closest_point

READERS = {".dxf": read_dxf, ".gds": read_gds, ".gdsii": read_gds}
NEAR = 0.02  # distance of a point from the port that it means, per size of the plan


def is_drawing(path: str | Path) -> bool:
    """Whether the file is a drawing, by its ending."""
    return Path(path).suffix.lower() in READERS


def read_drawing(path: str | Path) -> Drawing:
    """Raises CadError if the file is not there, or cannot be read."""
    path = Path(path)
    if not path.is_file():
        raise CadError(f"{path}: no such file")
    if not is_drawing(path):
        raise CadError(f"{path.name}: not a drawing; give a .dxf or .gds file")
    drawing = READERS[path.suffix.lower()](path)
    for line in (*drawing.warnings, *assumed_unit(drawing.file, drawing.unit)):
        warn(line, CadWarning, stacklevel=4)
    return drawing


def drawn_plan(
    path: str | Path,
    layer: str | int | None,
    *,
    region: int | None = None,
    names: str = "names",
    ports: Sequence[ArrayLike] | None = None,
) -> Boundary:
    """The outline on a layer, with ports named at the frame, or where `ports`, points, are.

    Raises CadError for layers, ports and regions that are not there or not clear.
    """
    drawing = read_drawing(path)
    curves, others = drawing.on_layer(layer)
    curves, frame = split_frame(curves, others)
    curves = closed_at_frame(curves, frame)
    called = [drawn.layer if names == "layers" else "" for drawn in curves]
    scale = drawing.unit.millimetres
    patches = [
        Patch(replace(drawn.curve, points=scale * drawn.curve.points), name, number)
        for number, (drawn, name) in enumerate(zip(curves, called, strict=True), start=1)
    ]
    plan = plane_region(drawing.file, patches, drawing.unit, region)
    if ports is not None:
        return _with_ports(plan, _at_points(drawing, plan, ports))
    return _with_ports(plan, _at_frame(plan, frame))


def _with_ports(plan: Boundary, ports: list[int]) -> Boundary:
    """Curves, by index, called port_1, port_2, ... in this order."""
    called = {index: f"port_{k}" for k, index in enumerate(ports, start=1)}
    patches = [
        replace(patch, name=called[k], port=True) if k in called else patch
        for k, patch in enumerate(plan.patches)
    ]
    return replace(plan, patches=tuple(patches))


def _at_frame(plan: Boundary, frame: list[DrawnCurve]) -> list[int]:
    """Straight curves on the frame, by x, then y of their middles."""
    found = [
        (_rounded(plan, k), k)
        for k, patch in enumerate(plan.patches)
        if patch.surface.degrees == (1,) and on_frame(patch.surface.points[[0, -1]], frame)
    ]
    return [k for _, k in sorted(found)]


def _rounded(plan: Boundary, index: int) -> tuple[float, ...]:
    middle = plan.patches[index].surface.points[[0, -1]].mean(axis=0)
    return tuple(np.round(middle / (1e-6 * _size(plan))).tolist())


def _size(plan: Boundary) -> float:
    return float(np.ptp(plan.bounds(), axis=0).max())


def _at_points(drawing: Drawing, plan: Boundary, ports: Sequence[ArrayLike]) -> list[int]:
    """The curve nearest to each point; it must be near, and no other port."""
    found: list[int] = []
    for given in ports:
        point: Array = np.asarray(given, dtype=float)
        gaps = [closest_point(patch.surface, point)[1] for patch in plan.patches]
        nearest = int(np.argmin(gaps))
        place = in_words(drawing.unit.millimetres * point, drawing.unit)
        if gaps[nearest] > NEAR * _size(plan):
            raise CadError(f"{drawing.file}: no curve of the outline is at the port {place}")
        if nearest in found:
            raise CadError(f"{drawing.file}: two ports are on the same curve, at {place}")
        found.append(nearest)
    return found
