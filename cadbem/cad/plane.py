"""Plane regions of fluid from CAD files: plane sketches, or sections of a solid."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from pathlib import Path
from warnings import warn

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial import cKDTree

from cadbem.boundary import Boundary, Patch
from cadbem.cad.body.model import CadModel, file_unit, open_model
from cadbem.cad.drawn_plan import drawn_plan, is_drawing
from cadbem.cad.faces.face_geometry import edge_points, is_planar, world_curve
from cadbem.cad.kernel.brep import BrepFace, read_brep
from cadbem.cad.kernel.process import import_model, section_model
from cadbem.cad.plane_region import in_words, plane_region
from cadbem.cad.sections import cut_faces, face_at
from cadbem.cad.text.source import CadSource, read_source
from cadbem.cad.text.unit import Unit
from cadbem.checks import direction, positive, shaped, whole
from cadbem.errors import CadError, CadWarning
from cadbem.spline.basis import Array
from cadbem.spline.nurbs import Nurbs

SAME = 1e-6  # share of the figure's size within which points lie in its plane
AXIS = 1e-9  # how near a normal is to an axis that is meant


@dataclass(frozen=True, eq=False)
class Plane:
    """A point, the unit normal, and two unit vectors (2, 3) that carry the plane's coordinates."""

    point: Array
    normal: Array
    axes: Array

    @classmethod
    def through(cls, point: Array, normal: Array) -> Plane:
        """Coordinates are those of the file without the one that runs along the normal most: x, y
        for a normal along z; (x, z) along y; (y, z) along x. In oblique planes the first axis lies
        below the first of them."""
        n = normal / np.linalg.norm(normal)
        along = int(np.argmax(np.abs(n)))
        if np.abs(n[along]) > 1 - AXIS**2 or np.linalg.norm(np.delete(n, along)) < AXIS:
            n = np.sign(n[along]) * np.eye(3)[along]
        first, second = np.delete(np.eye(3), along, axis=0)
        x = first - first @ n * n
        x /= np.linalg.norm(x)
        y = np.cross(n, x)
        return cls(point, n, np.array([x, y if y @ second > 0 else -y]))

    @classmethod
    def fitted(cls, points: Array) -> Plane:
        """The plane nearest to points (n, 3)."""
        centre = points.mean(axis=0)
        return cls.through(centre, np.linalg.svd(points - centre)[2][2])

    def off(self, points: Array) -> float:
        """Largest distance of points (..., 3) from the plane."""
        return float(np.abs((points - self.point) @ self.normal).max())

    def flat(self, curve: Nurbs) -> Nurbs:
        """A curve in the plane, in its coordinates."""
        return replace(curve, points=curve.points @ self.axes.T)


def read_outline(
    path: str | Path,
    *,
    point: ArrayLike | None = None,
    normal: ArrayLike | None = None,
    region: int | None = None,
    layer: str | int | None = None,
    fluid: int | str = "solid",
    names: str = "names",
    time_limit: float = 60.0,
) -> Boundary:
    """The outline of a plane region in a STEP, IGES, DXF or GDS file, a boundary of dimension 2.

    A file with solids is cut by the plane through ``point`` (in the file's unit; default: the
    middle of the solids' box) with a ``normal`` (default: along z, for a plan). Curves keep name
    and number of the face that they are cut from; ``fluid`` and ``names`` are as in `read_cad`. A
    file without solids holds plane faces, which together are the region, or closed wires around
    it and its holes; curves are numbered, so that `named(inlet=3)` can name them.

    Of a drawing (DXF, GDS) the curves on a ``layer`` are taken (a name; of GDS a number or
    "1/0"), by default the only one. Straight curves on a frame round it, on any other layer, are
    called port_1, port_2, ... by x, then y; open curves that end at the frame are closed there.
    ``names="layers"`` calls curves by their layer. Polygons of a GDS layer are united, and
    corners on circles become arcs.

    Lines, arcs and splines stay exact (a cut across curved splines is as exact as the CAD kernel
    makes it); curves end at kinks and after 90 degrees, and run with the fluid to their right.
    Coordinates are (x, y), (x, z) or (y, z): the file's without the one along the normal.

    Raises CadError as `read_cad` does, and for a plane that misses the solid, figures that are not
    plane or do not close, and several regions unless ``region`` (1 is the largest) chooses.
    """
    positive("time_limit", time_limit)
    if point is not None:
        shaped("point", point, 3)
    if normal is not None:
        direction("normal", normal, 3)
    if region is not None:
        whole("region", region)
    if is_drawing(path):
        if point is not None or normal is not None:
            raise CadError(f"{Path(path).name}: a drawing is plane; leave out point and normal")
        return drawn_plan(path, layer, region=region, names=names)
    source = read_source(path)
    kernel = import_model(source, time_limit)
    if kernel.solids:
        model = open_model(path, time_limit, names, fluid)
        for warning in model.warnings:
            warn(warning, CadWarning, stacklevel=2)
        for obstacle in model.obstacles():
            raise CadError(obstacle)
        unit, patches = model.unit, _cut(source, model, point, normal, time_limit)
    elif point is not None or normal is not None:
        raise CadError(f"{source.name}: there is no solid to cut; leave out point and normal")
    else:
        unit = file_unit(source)
        patches = _drawn(source, kernel.brep, unit, time_limit)
    return plane_region(source.name, patches, unit, region)


def _cut(
    source: CadSource,
    model: CadModel,
    point: ArrayLike | None,
    normal: ArrayLike | None,
    time_limit: float,
) -> list[Patch]:
    """The curves in which a plane cuts the solids, with name and number of their faces."""
    scale, bounds = model.unit.millimetres, model.bounds()
    middle = bounds.mean(axis=0) if point is None else np.asarray(point, dtype=float)
    direction = np.array([0.0, 0.0, 1.0]) if normal is None else np.asarray(normal, dtype=float)
    plane = Plane.through(scale * middle, direction)
    solids = CadSource(source.name, "brep", model.kernel.brep.encode())
    brep, _ = section_model(solids, time_limit, (plane.point, plane.normal))
    if not brep:
        box = " to ".join(model.place(corner) for corner in bounds)
        raise CadError(f"{source.name}: the plane misses the solid, which reaches from {box}")
    near = SAME * scale * float(np.ptp(bounds, axis=0).max())
    upright = [
        face for face in model.faces if not is_planar(face) or plane.off(edge_points(face)) > near
    ]
    faces, patches = cut_faces(upright), []
    for cut in _outer_curves(read_brep(brep), near):
        found = face_at(faces, cut.evaluate(np.mean(cut.domain[0])), near)
        if found is None and len(model.kernel.solids) > 1:  # of a solid that is not the fluid
            continue
        number = found.face.number if found else 0
        exact = cut if found is None or cut.degrees[0] == 1 else found.curve(cut, near)
        patches.append(Patch(plane.flat(exact), model.names.get(number, ""), number))
    return patches


def _drawn(source: CadSource, brep: str, unit: Unit, time_limit: float) -> list[Patch]:
    """The curves of a drawing without solids, numbered."""
    if not brep:
        brep, ends = section_model(source, time_limit)
        if ends:
            raise CadError(
                f"{source.name}: the wires do not close: {len(ends)} open ends, the first at "
                f"{in_words(ends[0], unit)}; join them in the CAD program"
            )
    faces = read_brep(brep) if brep else []
    if not faces:
        raise CadError(
            f"{source.name}: neither a solid to cut nor plane faces nor closed wires in a plane; "
            "export the fluid's space as one of them"
        )
    points = np.concatenate([edge_points(face) for face in faces])
    plane = Plane.fitted(points)
    size = float(np.ptp(points, axis=0).max())
    if plane.off(points) > SAME * size or not all(map(is_planar, faces)):
        raise CadError(
            f"{source.name}: the faces are not plane, or not in one plane, and make no solid to "
            "cut; export the fluid's space as a solid, or a plane sketch"
        )
    curves = [plane.flat(curve) for curve in _outer_curves(faces, SAME * size)]
    return [Patch(curve, "", k) for k, curve in enumerate(curves, start=1)]


def _outer_curves(faces: Iterable[BrepFace], near: float) -> list[Nurbs]:
    """Curves of all edges that no two faces have in common."""
    curves = [world_curve(use) for face in faces for loop in face.loops for use in loop]
    found = [curve for curve in curves if curve is not None]
    places = np.array([
        [curve.evaluate(np.mean(curve.domain[0])), *sorted(curve.points[[0, -1]], key=tuple)]
        for curve in found
    ])  # fmt: skip
    pairs = cKDTree(places.reshape(len(found), -1)).query_pairs(near)
    shared = {index for pair in pairs for index in pair}
    return [curve for index, curve in enumerate(found) if index not in shared]
