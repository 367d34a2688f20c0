"""Patches cut into small flat cells for drawing, with the fields that live on them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial import cKDTree

from cadbem.boundary import Boundary, Patch
from cadbem.points import surface_points
from cadbem.post.style.display import load_pyvista
from cadbem.spline.basis import Array
from cadbem.spline.nurbs import Nurbs


class PatchField(Protocol):
    """A field on the patches of a boundary: values (dim, *shape) at parameters of a patch."""

    def on_patch(self, index: int, u: ArrayLike, v: ArrayLike) -> Array: ...


def tessellated(
    boundary: Boundary,
    density: int = 8,
    fields: Mapping[str, PatchField] | None = None,
    patches: Sequence[int] | None = None,
) -> Any:
    """Quadrilaterals on the patches as ``pyvista.PolyData``, ``density`` a direction an element.

    Their corners lie on the exact surface.  Point data: ``Normals`` (unit, into the fluid) and
    the ``fields``; cell data: ``patch``, ``face``, ``name`` as in ``bezier_grid``.  Only the
    listed ``patches``, or all.  Raises ``DisplayError`` where VTK cannot be used.
    """
    pyvista = load_pyvista()
    fields = fields or {}
    chosen = range(len(boundary.patches)) if patches is None else patches
    columns: dict[str, list[Array]] = {key: [] for key in ("points", "Normals", *fields)}
    quads: list[NDArray[np.int64]] = []
    start = 0
    for i in chosen:
        u, v = _lattice(boundary.patches[i], density)
        surface = boundary.patches[i].surface
        columns["points"].append(surface.evaluate(u.ravel(), v.ravel()).T)
        columns["Normals"].append(_normals(surface, u.ravel(), v.ravel()).T)
        for key, field in fields.items():
            columns[key].append(field.on_patch(i, u.ravel(), v.ravel()).T)
        quads.append(_quadrilaterals(u.shape, start))
        start += u.size
    mesh = pyvista.PolyData(np.concatenate(columns.pop("points")), np.concatenate(quads).ravel())
    for key, values in columns.items():
        mesh.point_data[key] = np.squeeze(np.concatenate(values))
    add_numbers(mesh, boundary, np.repeat(list(chosen), [len(q) for q in quads]))
    return mesh


def add_numbers(mesh: Any, boundary: Boundary, patch_of_cell: NDArray[np.int64]) -> None:
    """Cell data ``patch``, ``face`` and ``name`` of cells that lie on the patches given."""
    faces = np.array([p.face for p in boundary.patches])
    names = np.array([boundary.names.index(p.name) for p in boundary.patches])
    mesh.cell_data["patch"] = patch_of_cell
    mesh.cell_data["face"] = faces[patch_of_cell]
    mesh.cell_data["name"] = names[patch_of_cell]
    # VTK's files know no other letters
    mesh.field_data["names"] = [n.encode("ascii", "replace").decode() for n in boundary.names]


def wall_stresses(traction: Array, normal: Array) -> tuple[Array, Array]:
    """Pressure (N,) and wall shear stress (N,) from tractions and unit normals (dim, N).

    With f = σ·n, n into the fluid: no slip makes n·(∇u)·n vanish on a wall, so p = -f·n there;
    the shear stress is the length of the rest, f - (f·n) n.
    """
    pull = (traction * normal).sum(axis=0)
    return -pull, np.linalg.norm(traction - pull * normal, axis=0)


def edge_lines(boundary: Boundary, density: int = 8, *, elements: bool = False) -> Any:
    """Edges of the patches, or of all their ``elements``, as polylines in ``pyvista.PolyData``."""
    return _polylines([c for p in boundary.patches for c in _curves(p, density, elements)])


def sharp_edges(boundary: Boundary, density: int = 8, angle: float = 30.0) -> Any:
    """The edges of patches at which the surface turns by more than an ``angle`` in degrees,
    or ends; judged in the middle of each edge."""
    sharp = []
    for curve, _, own, others, surface in _edges(boundary, density):
        normals = surface.point_data["Normals"]
        turns = normals[others] @ normals[own].mean(axis=0) < np.cos(np.radians(angle))
        if turns.all():
            sharp.append(curve)
    return _polylines(sharp)


def face_edges(boundary: Boundary, density: int = 8) -> Any:
    """The edges of patches at which a CAD face ends; judged in the middle of each edge."""
    ends = []
    for curve, patch, _, others, surface in _edges(boundary, density):
        cells = surface.point_data["face"][others]
        if (cells != boundary.patches[patch].face).all():
            ends.append(curve)
    return _polylines(ends)


def _edges(boundary: Boundary, density: int) -> Iterator[tuple[Array, int, Array, Array, Any]]:
    """Edges (n, 3) of patches with the number of the patch, and the points of a tessellation
    that are near the middle: numbers of its own ones, of those of others, and all of it."""
    if not boundary.patches:
        return
    surface = tessellated(boundary, density)
    patch_of_point = np.empty(surface.n_points, dtype=int)
    patch_of_point[surface.faces.reshape(-1, 5)[:, 1:]] = surface.cell_data["patch"][:, None]
    surface.point_data["face"] = np.array([p.face for p in boundary.patches])[patch_of_point]
    tree = cKDTree(surface.points)
    for index, patch in enumerate(boundary.patches):
        for curve in _curves(patch, density, elements=False):
            middle = curve[len(curve) // 2]
            step = np.linalg.norm(np.diff(curve, axis=0), axis=1).max()
            near = np.array(tree.query_ball_point(middle, 0.6 * step), dtype=int)
            own = patch_of_point[near] == index
            yield curve, index, near[own], near[~own], surface


def _polylines(curves: Sequence[Array]) -> Any:
    pyvista = load_pyvista()
    if not curves:
        return pyvista.PolyData()
    starts = np.cumsum([0, *map(len, curves)])
    lines = [[len(c), *range(i, i + len(c))] for c, i in zip(curves, starts, strict=False)]
    return pyvista.PolyData(np.concatenate(curves), lines=np.concatenate(lines))


def _curves(patch: Patch, density: int, elements: bool) -> list[Array]:
    surface = patch.surface
    curves = []
    for along in (0, 1):
        samples = between(surface.breaks(along), density)
        across = surface.breaks(1 - along) if elements else surface.domain[1 - along]
        for value in across:
            parameters = [samples, np.full_like(samples, value)]
            curves.append(surface.evaluate(*parameters[:: 1 - 2 * along]).T)
    return curves


def _lattice(patch: Patch, density: int) -> tuple[Array, Array]:
    u, v = (between(patch.surface.breaks(d), density) for d in (0, 1))
    grids = np.meshgrid(u, v, indexing="ij")
    return grids[0], grids[1]


def _normals(surface: Nurbs, u: Array, v: Array) -> Array:
    """Unit normals (3, N); at a pole, where there is none, that of a point close by."""
    points = surface_points(surface, u, v)
    flat = points.jacobian < 1e-9 * points.jacobian.max()
    normal = points.normal.copy()
    if flat.any():
        inner = []
        for parameter, (low, high) in zip((u, v), surface.domain, strict=True):
            middle = 0.5 * (low + high)
            inner.append(middle + (1 - 1e-4) * (parameter[flat] - middle))
        normal[:, flat] = surface_points(surface, *inner).normal
    return normal


def between(breaks: Array, density: int) -> Array:
    """Breaks with ``density - 1`` equidistant values in each span."""
    steps = np.arange(density * (len(breaks) - 1) + 1) / density
    return np.interp(steps, np.arange(len(breaks)), breaks)


def _quadrilaterals(shape: tuple[int, ...], start: int) -> NDArray[np.int64]:
    """Rows (4, a, b, c, d) of a lattice's cells, turning from u to v as the normal wants."""
    index = start + np.arange(shape[0] * shape[1]).reshape(shape)
    corners = [index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]]
    return np.stack([np.full(corners[0].size, 4), *[c.ravel() for c in corners]], axis=1)
