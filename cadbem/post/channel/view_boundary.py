"""Pictures of a boundary: its faces, names and numbers, and its collocation points."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from cadbem.boundary import Boundary
from cadbem.points import SurfacePoints
from cadbem.post.fields.cells import edge_lines, face_edges, tessellated
from cadbem.post.plane.plane_boundary import draw_plane_boundary
from cadbem.post.scene.face_labels import VisibleFaces, add_labels, look, roomiest
from cadbem.post.scene.glass import add_lines, lifted
from cadbem.post.scene.openings import opening_names
from cadbem.post.style.display import load_pyvista
from cadbem.post.style.layout import (
    Size,
    View,
    add_axes,
    aim,
    back_view,
    check_size,
    corner_view,
    panel,
    plan_view,
    sheet,
)
from cadbem.post.style.legend import draw_legend
from cadbem.post.style.style import (
    BACKGROUND,
    DEFECT,
    FONT,
    INK,
    SMALL,
    TINTS,
    WALL,
    add_text,
    colours_of,
    scaled,
    size_label,
)
from cadbem.spline.basis import Array

FAULT = "#6b0f10"  # lines on red faces
GLANCE = (480, 360)  # pixels of the pictures that decide where to look from
MOST = 4  # views from outside
CROWD = 30  # labels in a panel from which on letters shrink


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
    """Picture of the faces in the colours of their names, with the numbers that ``named`` takes.

    Two views from opposite corners, more where faces hide behind others, and one through the walls
    for those not seen from outside.  Faces without a name have a tint each; thin lines divide a
    face into patches.  In a plane edges have their numbers.
    ``defects`` maps numbers of faces to polylines (3, N) on them: these are red, the others grey.
    Those without patches are drawn by ``skins``, triangles (M, 3 corners, 3) by number, or by
    their polylines alone.  Raises ``DisplayError`` where pictures cannot be drawn.
    """
    check_size(size)
    if boundary.patches and boundary.dimension == 2:
        return draw_plane_boundary(boundary, path, size)
    surface = _surface(boundary, skins or {})
    lines = {face: list(curves) for face, curves in (defects or {}).items()}
    extent = np.concatenate([surface.points.T, *sum(lines.values(), [])], axis=1)
    views, hidden = choose_views(surface, extent)
    panels = [(view, False) for view in views] + [(views[0], True)] * bool(hidden)
    edges = edge_lines(boundary, 16), face_edges(boundary, 16)
    with sheet(path, size, len(panels), views[0].aspect(extent)) as plotter:
        for i, (view, through) in enumerate(panels):
            panel(plotter, i)
            lift = lifted(view, extent)
            shown = _only(surface, hidden) if through else surface
            if through:
                _add_glass(plotter, surface)
            _add_faces(plotter, boundary, shown, list(lines))
            _add_edges(plotter, edges, lift, through)
            _add_defects(plotter, surface, lines, 2 * lift)
            aim(plotter, view, extent)
            _add_numbers(plotter, boundary, look(shown, view, extent, _pixels(plotter)), lines)
            add_axes(plotter)
        draw_legend(plotter, _legend(boundary, list(lines)), _note(boundary, extent))
    return Path(path)


def draw_collocation(
    space: CollocatedSpace, path: str | Path, *, size: Size = (1800, 1200)
) -> Path:
    """Picture of the elements on the boundary and of the collocation points on them."""
    check_size(size)
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
    """Pixels across a collocation point: fewer when they neighbours."""
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


def choose_views(surface: Any, extent: Array) -> tuple[list[View], list[int]]:
    """Views from corners, two or up to four where these show more faces, and the faces that they
    all hide."""
    every = plan_view(extent, hidden=1)
    views = [corner_view(extent), back_view(extent)]
    others = [every.turned(a, e) for a in (28, 118, 208, 298) for e in (32, -32)]
    hidden = _faces(surface) - {0}
    for view in views:
        hidden -= _visible_faces(surface, view, extent)
    visible = [_visible_faces(surface, v, extent) for v in others] if hidden else []
    while hidden and len(views) < MOST:
        best = max(range(len(others)), key=lambda k: len(visible[k] & hidden))
        if not visible[best] & hidden:
            break
        views.append(others[best])
        hidden -= visible[best]
    return views, sorted(hidden)


def _visible_faces(surface: Any, view: View, extent: Array) -> set[int]:
    return set(roomiest(look(surface, view, extent, GLANCE)))


def _only(surface: Any, faces: Sequence[int]) -> Any:
    cells = np.flatnonzero(np.isin(surface.cell_data["face"], faces))
    return surface.extract_cells(cells).extract_surface(algorithm="dataset_surface")


def _add_edges(plotter: Any, edges: tuple[Any, Any], lift: Array, through: bool) -> None:
    """Thin lines on the edges of patches, thick ones on those of faces; behind glass the latter."""
    if not through:
        add_lines(plotter, edges[0], lift, width=0.7)
    add_lines(plotter, edges[1], lift, width=1 if through else 2.5)


def _add_glass(plotter: Any, surface: Any) -> None:
    """All faces as glass, for what is behind them."""
    plotter.add_mesh(surface, color=WALL, opacity=0.15, lighting=False, culling="back")
    add_text(plotter, "hidden from outside:", (0.03, 0.9), scaled(plotter, SMALL))


def _pixels(plotter: Any) -> Size:
    width, height = plotter.renderer.GetSize()
    return int(width), int(height)


def _add_faces(plotter: Any, boundary: Boundary, surface: Any, faulty: list[int]) -> None:
    if not surface.n_cells:
        return
    colours = _colours(boundary, faulty)
    names, faces = surface.cell_data["name"], surface.cell_data["face"]
    broken = np.isin(faces, faulty)
    for i, name in enumerate(boundary.names):
        here = (names == i) & ~broken
        tints = TINTS if not name and not faulty else (colours[name],)
        for k, tint in enumerate(tints):
            _add_part(plotter, surface, here & (faces % len(tints) == k), tint)
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
            _add_number(plotter, middle, face)


def _add_number(plotter: Any, middle: Array, face: int) -> None:
    plotter.add_point_labels(
        middle[None],
        [str(face)],
        font_family=FONT,
        font_size=scaled(plotter, SMALL),
        bold=False,
        text_color=DEFECT,
        shape=None,
        background_color=BACKGROUND,
        background_opacity=0.75,
        show_points=False,
        always_visible=True,
        justification_horizontal="center",
        justification_vertical="center",
    )


def _add_numbers(
    plotter: Any, boundary: Boundary, visible: VisibleFaces, faulty: Mapping[int, list[Array]]
) -> None:
    """Numbers on the faces that a view shows, with the names of those that are not walls."""
    spots = roomiest(visible)
    labels = {face: str(face) for face in spots}
    ports = opening_names(boundary)
    for patch in boundary.patches:
        if patch.name in ports and not faulty:
            labels |= {patch.face: f"{patch.face} {patch.name}"} if patch.face in labels else {}
    colours = {face: DEFECT if face in faulty else INK for face in labels}
    shrunk = SMALL * np.clip(np.sqrt(CROWD / max(1, len(labels))), 0.65, 1.0)
    add_labels(plotter, visible, spots, labels, colours, scaled(plotter, shrunk))


def _faces(surface: Any) -> set[int]:
    return set(surface.cell_data["face"].tolist()) if surface.n_cells else set()


def _colours(boundary: Boundary, faulty: list[int]) -> dict[str, str]:
    """Colours of names; next to defective faces all others are grey."""
    return dict.fromkeys(boundary.names, WALL) if faulty else colours_of(boundary.names)


def _legend(boundary: Boundary, faulty: list[int]) -> dict[str, str]:
    if not faulty:
        return {name: colour for name, colour in colours_of(boundary.names).items() if name}
    sound = {patch.face for patch in boundary.patches} - set(faulty)
    others = {f"sound ({len(sound)})": WALL} if sound else {}
    return {f"defective ({len(faulty)})": DEFECT} | others


def _note(boundary: Boundary, extent: Array) -> str:
    unnamed = len({patch.face for patch in boundary.patches if not patch.name})
    count = f"{unnamed} face{'s' * (unnamed > 1)} without a name; " if unnamed else ""
    return count + size_label(extent, boundary.unit)
