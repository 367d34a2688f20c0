"""Patches as rational Bézier cells of VTK: the exact geometry, with exact fields on it."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from cadbem.boundary import Boundary
from cadbem.post.fields.cells import add_numbers
from cadbem.post.style.display import load_pyvista
from cadbem.spline.basis import Array
from cadbem.spline.nurbs import Nurbs


class Coefficients(Protocol):
    """A field in the rational basis of the patches: coefficients (dim, n_u[, n_v]) of a patch."""

    def patch_coefficients(self, index: int) -> Array: ...


def bezier_grid(boundary: Boundary, fields: Mapping[str, Coefficients] | None = None) -> Any:
    """All patches as a ``pyvista.UnstructuredGrid`` of ``VTK_BEZIER_QUADRILATERAL`` cells, in a
    plane of ``VTK_BEZIER_CURVE`` cells at z = 0.

    One cell for each element; no approximation, in the geometry or in the ``fields``, which
    become point data.  Cell data: ``patch`` (from 0), ``face`` (CAD face number), ``name``
    (index into the field data ``names``).  Raises ``DisplayError`` without OpenGL.
    """
    pyvista = load_pyvista()
    fields = fields or {}
    pieces = [_pieces(boundary, i, fields) for i in range(len(boundary.patches))]
    cells = [piece for group in pieces for piece in group]
    columns = np.concatenate([_in_vtk_order(c.points, c.degrees) for c in cells])
    weights = np.concatenate([_in_vtk_order(c.weights, c.degrees) for c in cells])
    types = pyvista.CellType
    kind = types.BEZIER_QUADRILATERAL if boundary.dimension == 3 else types.BEZIER_CURVE
    kinds = np.full(len(cells), kind, dtype=np.uint8)
    grid = pyvista.UnstructuredGrid(_connectivity(cells), kinds, columns[:, :3].copy())
    _set_attribute(grid.GetPointData(), "RationalWeights", weights)
    degrees = np.array([(*c.degrees, 1, 1)[:3] for c in cells], dtype=float)
    _set_attribute(grid.GetCellData(), "HigherOrderDegrees", degrees)
    _add_fields(grid, fields, columns[:, 3:])
    add_numbers(grid, boundary, np.repeat(range(len(pieces)), [len(group) for group in pieces]))
    return grid


def _set_attribute(data: Any, name: str, values: Array) -> None:
    """Store an array that VTK finds by its role; pyvista would make it the active scalars as
    well, and VTK's tessellation then loses the weights without a word."""
    from vtkmodules.util.numpy_support import numpy_to_vtk

    array = numpy_to_vtk(values, deep=True)
    array.SetName(name)
    getattr(data, f"Set{name}")(array)


def _pieces(boundary: Boundary, index: int, fields: Mapping[str, Coefficients]) -> list[Nurbs]:
    """Bézier pieces of a patch whose control points are (x, y, z, field components ...)."""
    surface = boundary.patches[index].surface
    flat = np.zeros((*surface.weights.shape, 3 - boundary.dimension))
    values = [np.moveaxis(f.patch_coefficients(index), 0, -1) for f in fields.values()]
    extended = np.concatenate([surface.points, flat, *values], axis=-1)
    spline = Nurbs(surface.degrees, surface.knots, extended, surface.weights)
    # VTK's surface filter misreads cells of two different degrees; raising one is exact
    return spline.elevated((max(spline.degrees),) * len(spline.degrees)).bezier_pieces()


@cache
def _vtk_order(degrees: tuple[int, ...]) -> NDArray[np.int64]:
    """Place in VTK's numbering of the control point (i, j), j fastest: vertices, edges, inside;
    on a curve the ends, then the points between them."""
    if len(degrees) == 1:
        return np.array([0, *range(2, degrees[0] + 1), 1])
    from vtkmodules.vtkCommonDataModel import vtkHigherOrderQuadrilateral

    return np.array(
        [
            vtkHigherOrderQuadrilateral.PointIndexFromIJK(i, j, degrees)
            for i in range(degrees[0] + 1)
            for j in range(degrees[1] + 1)
        ]
    )


def _in_vtk_order(values: Array, degrees: tuple[int, ...]) -> Array:
    flat = values.reshape(-1, *values.shape[len(degrees) :])
    ordered = np.empty_like(flat)
    ordered[_vtk_order(degrees)] = flat
    return ordered


def _connectivity(cells: list[Nurbs]) -> NDArray[np.int64]:
    sizes = [c.weights.size for c in cells]
    starts = np.concatenate([[0], np.cumsum(sizes)])
    return np.concatenate(
        [[size, *range(start, start + size)] for start, size in zip(starts, sizes, strict=False)]
    )


def _add_fields(grid: Any, fields: Mapping[str, Coefficients], columns: Array) -> None:
    first = 0
    for name, field in fields.items():
        count = field.patch_coefficients(0).shape[0]
        values = columns[:, first : first + count]
        if count == 2:  # as ParaView knows vectors
            values = np.pad(values, ((0, 0), (0, 1)))
        grid.point_data[name] = values[:, 0].copy() if count == 1 else values.copy()
        first += count
