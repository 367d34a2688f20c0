"""Curves of a DXF file, through ezdxf: blocks are resolved, mirrored ones too."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from math import pi
from pathlib import Path
from typing import Any

import numpy as np

from cadbem.cad.drawings.drawing import Drawing, DrawnCurve, segment
from cadbem.cad.faces.curves import arc, spline_nurbs
from cadbem.cad.kernel.brep_geometry import SplineRecord
from cadbem.cad.text.unit import Unit
from cadbem.errors import CadError
from cadbem.spline.basis import Array
from cadbem.spline.nurbs import Nurbs

UNITS = {
    1: Unit("inch", 25.4), 2: Unit("ft", 304.8), 4: Unit("mm", 1.0), 5: Unit("cm", 10.0),
    6: Unit("m", 1000.0), 8: Unit("microinch", 2.54e-5), 9: Unit("mil", 0.0254),
    12: Unit("nm", 1e-6), 13: Unit("um", 1e-3), 14: Unit("dm", 100.0),
}  # fmt: skip
SILENT = {"TEXT", "MTEXT", "POINT", "DIMENSION", "LEADER", "MULTILEADER", "ATTDEF", "ATTRIB",
          "VIEWPORT", "XLINE", "RAY", "IMAGE", "ACAD_TABLE", "TOLERANCE"}  # fmt: skip
FLAT = 1e-6  # height of curves, per extent, within which a drawing is plane
LEAST = 1e-12  # length of curves, per extent, that are points


def read_dxf(path: Path) -> Drawing:
    """All curves in the model space; raises CadError for files that ezdxf cannot read."""
    import ezdxf

    try:
        document = ezdxf.readfile(path)
    except (ezdxf.DXFError, OSError, ValueError, KeyError, IndexError) as error:
        raise CadError(f"{path.name}: cannot be read as DXF ({error}); save it again") from None
    unit = UNITS.get(document.units, Unit("mm", 1.0, assumed=True))
    left_out: Counter[str] = Counter()
    found = list(_curves(document.modelspace(), left_out))
    solid = [(curve, layer) for curve, layer in found if np.ptp(curve.points, axis=0).max() > 0]
    if not solid:
        raise CadError(f"{path.name}: no curves in the model space; export the outline as curves")
    points = np.concatenate([curve.points for curve, _ in solid])
    if np.ptp(points[:, 2]) > FLAT * np.ptp(points[:, :2], axis=0).max():
        raise CadError(f"{path.name}: the curves are not in a plane of constant z; export a plan")
    size = float(np.ptp(points, axis=0).max())
    curves = tuple(
        DrawnCurve(_flat(curve), layer)
        for curve, layer in solid
        if np.ptp(curve.points, axis=0).max() > LEAST * size
    )
    said = ", ".join(f"{n} {kind}" for kind, n in sorted(left_out.items()))
    warnings = (f"{path.name}: left out, as no curves: {said}",) if said else ()
    return Drawing(path.name, unit, curves, warnings)


def _flat(curve: Nurbs) -> Nurbs:
    return Nurbs(curve.degrees, curve.knots, curve.points[:, :2], curve.weights)


def _curves(entities: Any, left_out: Counter[str]) -> Iterator[tuple[Nurbs, str]]:
    """Curves (3D) with their layers; `left_out` counts what is none."""
    from ezdxf.disassemble import recursive_decompose

    entity: Any
    for entity in recursive_decompose(entities):
        kind, layer = entity.dxftype(), str(entity.dxf.layer)
        many = kind in ("LWPOLYLINE", "POLYLINE")
        for part in entity.virtual_entities() if many else [entity]:
            curve = _curve(part)
            if curve is not None:
                yield curve, layer
            elif kind not in SILENT:
                left_out[kind] += 1


def _curve(entity: Any) -> Nurbs | None:
    """The curve of one entity, None if it is none."""
    kind, place = entity.dxftype(), entity.dxf
    if kind == "LINE":
        return segment(_vector(place.start), _vector(place.end))
    if kind in ("CIRCLE", "ARC"):
        to_world = entity.ocs().to_wcs
        x, y = (place.radius * _vector(to_world(axis)) for axis in ((1, 0, 0), (0, 1, 0)))
        start, end = (0.0, 360.0) if kind == "CIRCLE" else (place.start_angle, place.end_angle)
        turn = (end - start) % 360.0 or 360.0
        low = np.radians(start)
        return arc(_vector(to_world(place.center)), x, y, (low, low + np.radians(turn)))
    if kind == "ELLIPSE":
        turn = (place.end_param - place.start_param) % (2 * pi) or 2 * pi
        axes = _vector(place.major_axis), _vector(entity.minor_axis)
        return arc(_vector(place.center), *axes, (place.start_param, place.start_param + turn))
    return _spline(entity) if kind == "SPLINE" else None


def _spline(entity: Any) -> Nurbs:
    tool = entity.construction_tool()
    knots, degree = np.array(tool.knots(), dtype=float), tool.degree
    points = np.array([_vector(p) for p in tool.control_points])
    weights = np.array(tool.weights() or np.ones(len(points)), dtype=float)
    record = SplineRecord((degree,), (knots,), points, weights, (False,))
    return spline_nurbs(record, ((float(knots[degree]), float(knots[-degree - 1])),))


def _vector(point: Any) -> Array:
    return np.array([point[0], point[1], point[2]], dtype=float)
