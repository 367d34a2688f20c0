"""Pictures and files of closed splines: droplets in space, outlines in a plane."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from cadbem.boundary import Boundary, Patch
from cadbem.closed_points import ClosedGrid
from cadbem.errors import ShapeError
from cadbem.post.fields.bezier import bezier_grid
from cadbem.post.fields.body_fields import BodyField, control_values
from cadbem.post.files.export import prepared, write_vtu
from cadbem.post.scene.glass import add_lines, lifted
from cadbem.post.style.display import load_pyvista
from cadbem.post.style.layout import (
    Size,
    add_axes,
    aim,
    check_size,
    flow_views,
    panel,
    sheet,
    strip,
)
from cadbem.post.style.style import (
    INK,
    PALETTE,
    SMALL,
    add_text,
    colour_bar,
    colour_limits,
    light_colours,
    scaled,
    size_label,
)
from cadbem.spline.basis import Array
from cadbem.spline.closed import ClosedBasis, ClosedSpline

DENSITY = 6  # flat cells a direction in each element; even, for knots to be corners
NEAR_POLE = 1e-3  # of an element: where normals and curvatures of a pole are taken
AXES_ROOM = (0.1, 0.0)  # share of a panel kept free for the axes and at the top


def draw_droplets(
    path: str | Path,
    splines: Sequence[ClosedSpline],
    *,
    fields: Sequence[Array] | None = None,
    label: str = "mean curvature",
    mesh: bool = True,
    points: bool = False,
    size: Size = (1800, 1000),
) -> Path:
    """Picture of closed surfaces along y, the flow's plane, and from a corner.

    Colours show the mean curvature c / 2 or, given ``fields``, scalar coefficients (*shape) for
    each surface, called ``label``.  ``mesh`` draws the knot lines, ``points`` the collocation
    points.  Raises ``ShapeError`` for plane curves, ``DisplayError`` where nothing can be drawn.
    """
    check_size(size)
    given = [None] * len(splines) if fields is None else fields
    surfaces = [tessellated_droplet(s, f) for s, f in zip(splines, given, strict=True)]
    extent = np.concatenate([s.points for s in surfaces]).T
    values = np.concatenate([s.point_data["value"] for s in surfaces])
    limits = colour_limits(values.min(), values.max())
    views = flow_views()
    with sheet(path, size, len(views), views[0].aspect(extent)) as plotter:
        for i, view in enumerate(views):
            panel(plotter, i)
            lift = lifted(view, extent)
            for spline, surface in zip(splines, surfaces, strict=True):
                actor = _add_surface(plotter, surface, limits)
                if mesh:
                    add_lines(plotter, knot_lines(spline), lift, width=1)
                if points:
                    _add_points(plotter, spline.points().T + 2 * lift)
            aim(plotter, view, extent, AXES_ROOM)
            add_axes(plotter)
        strip(plotter)
        colour_bar(plotter, actor, label, 0.4, 0.5)
        add_text(plotter, size_label(extent, ""), (0.02, 0.72), scaled(plotter, SMALL))
    return Path(path)


def draw_outlines(path: str | Path, series: Mapping[str, Sequence[ClosedSpline]]) -> Path:
    """Plane droplets at several times on common axes: ``series`` maps labels, such as "t = 2", to
    the droplets there; marks show the knots.  Raises ``ShapeError`` for surfaces."""
    from matplotlib.figure import Figure

    axes = (figure := Figure(figsize=(7.0, 7.0))).subplots()
    for k, (label, splines) in enumerate(series.items()):
        colour = PALETTE[k % len(PALETTE)]
        for i, spline in enumerate(splines):
            _require(spline, 2)
            t = np.linspace(0, 2 * np.pi, 40 * spline.basis.count + 1)
            axes.plot(*spline.evaluate(t[None]), color=colour, label=None if i else label)
            marks = spline.evaluate(knots(spline.basis)[0][None])
            axes.plot(*marks, color=colour, linestyle="none", marker="o", markersize=3)
    axes.set(xlabel="x", ylabel="y", aspect="equal")
    axes.grid(alpha=0.3)
    axes.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), frameon=False, title="marks: knots")
    target = prepared(path)
    figure.savefig(target, dpi=150, bbox_inches="tight")
    return target


def write_droplets(
    path: str | Path,
    splines: Sequence[ClosedSpline],
    fields: Mapping[str, Sequence[Array]] | None = None,
) -> Path:
    """Closed surfaces as exact Bézier cells in a ``.vtu`` file for ParaView.

    ``fields`` maps names to coefficients for each surface, (*shape) or (components, *shape).
    Raises ``ShapeError`` for plane curves, ``CadbemError`` for another ending.
    """
    for spline in splines:
        _require(spline, 3)
    boundary = Boundary(tuple(Patch(s.patch(), "droplet", i + 1) for i, s in enumerate(splines)))
    columns = {
        name: BodyField(
            boundary, [control_values(s, c)[0] for s, c in zip(splines, values, strict=True)]
        )
        for name, values in (fields or {}).items()
    }
    return write_vtu(path, bezier_grid(boundary, columns))


def knots(basis: ClosedBasis) -> list[Array]:
    """Knots in each direction, without poles; that at 0 = 2π counts as one."""
    ends = slice(basis.degree % 2, -1)
    lines = basis.breaks()
    return [lines[0][ends]] if basis.dimension == 2 else [lines[0][1:-1], lines[1][ends]]


def knot_lines(spline: ClosedSpline) -> Any:
    """Lines of constant parameters at the knots of a surface, in ``pyvista.PolyData``."""
    pyvista = load_pyvista()
    rows, columns = knots(spline.basis)
    colatitude, longitude = _lattice(spline.basis)
    curves = [np.stack([0 * longitude + row, longitude]) for row in rows]
    curves += [np.stack([colatitude, 0 * colatitude + column]) for column in columns]
    lines = [pyvista.MultipleLines(spline.evaluate(c).T) for c in curves]
    return pyvista.merge(lines, merge_points=False)


def _lattice(basis: ClosedBasis) -> list[Array]:
    """Parameters of the corners of cells; knots are among them."""
    pairs = zip(basis.lengths, basis.shape, strict=True)
    return [np.linspace(0, length, DENSITY * n + 1) for length, n in pairs]


def tessellated_droplet(spline: ClosedSpline, field: Array | None = None) -> Any:
    """Quadrilaterals on a closed surface as ``pyvista.PolyData``, ``DENSITY`` a direction an
    element, with corners on the surface, unit ``Normals`` outwards and the point data ``value``:
    a field with coefficients (*shape), the length of one with (dim, *shape), or the mean
    curvature c / 2."""
    _require(spline, 3)
    theta, phi = _lattice(spline.basis)
    rim = NEAR_POLE * np.pi / spline.basis.shape[0]
    grid = ClosedGrid(spline.basis, [np.clip(theta, rim, np.pi - rim), phi])
    near = grid.points(spline)
    exact = ClosedGrid(spline.basis, [theta, phi])
    index = np.arange(theta.size * phi.size).reshape(theta.size, phi.size)
    corners = [index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]]
    cells = np.stack([np.full_like(corners[0], 4), *corners], axis=-1)
    surface = load_pyvista().PolyData(exact.values(spline.coefficients).T, cells.ravel())
    value = near.curvature / 2 if field is None else exact.values(field)
    surface.point_data["value"] = value if value.ndim == 1 else np.linalg.norm(value, axis=0)
    surface.point_data["Normals"] = near.normal.T
    return surface


def _require(spline: ClosedSpline, dimension: int) -> None:
    if spline.dimension != dimension:
        raise ShapeError(
            f"a droplet in {spline.dimension}D cannot be shown like this: draw_outlines is for "
            "2D, draw_droplets and write_droplets are for 3D"
        )


def _add_surface(plotter: Any, surface: Any, limits: tuple[float, float]) -> Any:
    return plotter.add_mesh(
        surface.copy(deep=False),
        scalars="value",
        cmap=light_colours(),
        clim=limits,
        ambient=0.6,
        diffuse=0.4,
        smooth_shading=True,
        show_scalar_bar=False,
    )


def _add_points(plotter: Any, points: Array) -> None:
    plotter.add_mesh(
        load_pyvista().PolyData(points),
        color=INK,
        point_size=scaled(plotter, 8),
        render_points_as_spheres=True,
    )
