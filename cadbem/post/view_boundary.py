"""Pictures of a boundary: its faces, names and numbers, and its collocation points."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from cadbem.boundary import Boundary
from cadbem.points import SurfacePoints
from cadbem.post.display import load_pyvista
from cadbem.post.fields import edge_lines, tessellated
from cadbem.post.layout import Size, View, add_axes, aim, back_view, corner_view, panel, sheet
from cadbem.post.legend import draw_legend
from cadbem.post.scene import add_lines, lifted
from cadbem.post.style import (
    BACKGROUND,
    DEFECT,
    FONT,
    INK,
    SMALL,
    WALL,
    colours_of,
    scaled,
    size_label,
)
from cadbem.spline.basis import Array

FAULT = "#6b0f10"  # lines on red faces


class CollocatedSpace(Protocol):
    """A space with its boundary and its collocation points."""

    @property
    def boundary(self) -> Boundary: ...

    @property
    def collocation(self) -> SurfacePoints: ...


def draw_boundary(
    boundary: Boundary,
    path: str | Path,
    *,
    defects: Mapping[int, Sequence[Array]] | None = None,
    skins: Mapping[int, Array] | None = None,
    size: Size = (1800, 1100),
) -> Path:
    """Picture of the faces in the colours of their names, from two opposite corners.

    Every CAD face carries its number where it can be seen; those that neither view shows are
    listed.  ``defects`` maps numbers of faces to polylines (3, N) on them: these faces are red and
    the others grey.  Those without patches are drawn by ``skins``, triangles (M, 3 corners, 3) by
    number, or by their polylines alone.
    Raises ``DisplayError`` where pictures cannot be drawn.
    """
    surface = _surface(boundary, skins or {})
    lines = {face: list(curves) for face, curves in (defects or {}).items()}
    extent = np.concatenate([surface.points.T, *sum(lines.values(), [])], axis=1)
    views = (corner_view(extent), back_view(extent))
    seen: set[int] = set()
    with sheet(path, size, 2, views[0].aspect(extent)) as plotter:
        for i, view in enumerate(views):
            panel(plotter, i)
            _add_faces(plotter, boundary, surface, list(lines))
            lift = lifted(view, extent)
            add_lines(plotter, edge_lines(boundary, 16), lift)
            _add_defects(plotter, surface, lines, 2 * lift)
            seen |= _add_numbers(plotter, surface, view, list(lines))
            add_axes(plotter)
            aim(plotter, view, extent)
        hidden = sorted(_faces(surface) - seen - {0})
        note = size_label(extent, boundary.unit) + _hidden_note(hidden)
        draw_legend(plotter, _legend(boundary, list(lines)), note)
    return Path(path)


def draw_collocation(
    space: CollocatedSpace, path: str | Path, *, size: Size = (1800, 1200)
) -> Path:
    """Picture of the elements on the boundary and of the collocation points on them."""
    pyvista = load_pyvista()
    boundary = space.boundary
    surface = tessellated(boundary, density=4)
    extent = surface.points.T
    view = corner_view(extent)
    points = space.collocation.position
    lift = lifted(view, extent)
    with sheet(path, size, 1, view.aspect(extent)) as plotter:
        panel(plotter, 0)
        _add_faces(plotter, boundary, surface, [])
        add_lines(plotter, edge_lines(boundary, 4, elements=True), lift)
        plotter.add_mesh(
            pyvista.PolyData(points.T + 2 * lift),
            color=INK,
            point_size=scaled(plotter, _point_size(points.shape[1])),
            render_points_as_spheres=True,
        )
        add_axes(plotter)
        aim(plotter, view, extent)
        note = f"{points.shape[1]} collocation points; {size_label(extent, boundary.unit)}"
        draw_legend(plotter, colours_of(boundary.names), note)
    return Path(path)


def _point_size(count: int) -> float:
    """Pixels across a collocation point: fewer when they crowd."""
    return float(np.clip(400 / np.sqrt(count), 4, 12))


def _surface(boundary: Boundary, skins: Mapping[int, Array]) -> Any:
    """Patches and skins as one mesh with the cell data ``face`` and ``name``, -1 on skins."""
    pyvista = load_pyvista()
    meshes = [tessellated(boundary, density=16)] if boundary.patches else []
    for face, corners in skins.items():
        across, along = np.diff(corners, axis=1).transpose(1, 0, 2)
        normals = np.cross(across, along)
        lengths = np.linalg.norm(normals, axis=1, keepdims=True)
        mesh = pyvista.PolyData.from_regular_faces(
            corners.reshape(-1, 3), np.arange(corners.size // 3).reshape(-1, 3)
        )
        mesh.point_data["Normals"] = np.repeat(normals / np.maximum(lengths, 1e-300), 3, axis=0)
        mesh.cell_data["face"] = np.full(len(corners), face)
        mesh.cell_data["name"] = np.full(len(corners), -1)
        meshes.append(mesh)
    return pyvista.merge(meshes, merge_points=False) if meshes else pyvista.PolyData()


def _add_faces(plotter: Any, boundary: Boundary, surface: Any, faulty: list[int]) -> None:
    if not surface.n_cells:
        return
    colours = _colours(boundary, faulty)
    names, faces = surface.cell_data["name"], surface.cell_data["face"]
    broken = np.isin(faces, faulty)
    for i, name in enumerate(boundary.names):
        _add_part(plotter, surface, (names == i) & ~broken, colours[name])
    _add_part(plotter, surface, broken, DEFECT)


def _add_part(plotter: Any, surface: Any, mask: NDArray[np.bool_], colour: str) -> None:
    if mask.any():
        part = surface.extract_cells(np.flatnonzero(mask))
        plotter.add_mesh(part, color=colour, ambient=0.5, diffuse=0.5, smooth_shading=True)


def _add_defects(plotter: Any, surface: Any, lines: Mapping[int, list[Array]], lift: Array) -> None:
    """Thick lines, dark where the face is red as well; numbers of faces without a surface."""
    pyvista, painted = load_pyvista(), _faces(surface)
    for face, curves in lines.items():
        colour = FAULT if face in painted else DEFECT
        for curve in curves:
            mesh = pyvista.MultipleLines(curve.T + lift)
            plotter.add_mesh(mesh, color=colour, line_width=7, lighting=False)
        if face not in painted:
            middle = np.concatenate(curves, axis=1).mean(axis=1)
            _add_labels(plotter, middle[:, None], [face], DEFECT)


def _add_numbers(plotter: Any, surface: Any, view: View, faulty: list[int]) -> set[int]:
    """Numbers on the faces that the view shows, near their middles; returns those faces."""
    spots = visible_spots(surface, view)
    for colour, wanted in ((DEFECT, spots.keys() & set(faulty)), (INK, spots.keys() - faulty)):
        if wanted:
            places = np.stack([spots[face] for face in wanted], axis=1)
            _add_labels(plotter, places, list(wanted), colour)
    return set(spots)


def _faces(surface: Any) -> set[int]:
    return set(surface.cell_data["face"].tolist()) if surface.n_cells else set()


def _add_labels(plotter: Any, positions: Array, labels: list[int], colour: str) -> None:
    plotter.add_point_labels(
        positions.T,
        [str(label) for label in labels],
        font_family=FONT,
        font_size=scaled(plotter, SMALL),
        bold=False,
        text_color=colour,
        shape=None,
        background_color=BACKGROUND,
        background_opacity=0.75,
        show_points=False,
        always_visible=True,
        justification_horizontal="center",
        justification_vertical="center",
    )


def visible_spots(surface: Any, view: View, candidates: int = 40) -> dict[int, Array]:
    """For each CAD face a point (3,) on it that the viewer sees, nearest to the face's middle."""
    if not surface.n_cells:
        return {}
    triangles = surface.triangulate()
    reach = 2 * surface.length
    centres = surface.cell_centers().points
    outward = -np.asarray(
        surface.compute_normals(
            point_normals=False, auto_orient_normals=False, consistent_normals=False
        ).cell_data["Normals"]
    )
    spots: dict[int, Array] = {}
    for face in sorted(_faces(surface)):
        own = np.flatnonzero(surface.cell_data["face"] == face)
        middle = centres[own].mean(axis=0)
        facing = own[outward[own] @ view.toward > 0.15]
        order = facing[np.argsort(np.linalg.norm(centres[facing] - middle, axis=1))]
        for cell in order[:: max(1, len(order) // candidates)]:
            start = centres[cell] + 1e-4 * reach * outward[cell]
            if not len(triangles.ray_trace(start, start + reach * view.toward)[0]):
                spots[int(face)] = start
                break
    return spots


def _colours(boundary: Boundary, faulty: list[int]) -> dict[str, str]:
    """Colours of names; next to defective faces all others are grey."""
    return dict.fromkeys(boundary.names, WALL) if faulty else colours_of(boundary.names)


def _legend(boundary: Boundary, faulty: list[int]) -> dict[str, str]:
    if not faulty:
        return colours_of(boundary.names)
    sound = {patch.face for patch in boundary.patches} - set(faulty)
    others = {f"sound ({len(sound)})": WALL} if sound else {}
    return {f"defective ({len(faulty)})": DEFECT} | others


def _hidden_note(faces: list[int]) -> str:
    return f"; faces hidden in both views: {', '.join(map(str, faces))}" if faces else ""
