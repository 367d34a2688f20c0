"""Velocity and pressure at sample points throughout the fluid, for pictures without a mesh."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import Delaunay

from cadbem.boundary import Boundary
from cadbem.post.fields.cells import PatchField
from cadbem.post.style.display import load_pyvista
from cadbem.problems.enclosure import Enclosure
from cadbem.progress import progress
from cadbem.quadrature import Quadrature
from cadbem.space import Space
from cadbem.spline.basis import Array

SHOWN = Quadrature(1e-4)  # finer than colours can show
PORTION = 2000  # points asked for at once: those near walls take memory
FINENESS = 1.5  # points in the volume over the area, in each direction, at least
MOST = 12000  # points that thin fluid may ask for
CLEAR = 0.35  # spacings that points keep off the boundary, on which values are known
JITTER = 0.15  # spacings by which points leave their lattice, for cells of good shape
INSET = 1e-3  # share of a patch: where values at its edges are taken, as poles have no normal


class FlowSolution(Protocol):
    """The part of a solution that is sampled."""

    @property
    def space(self) -> Space: ...

    @property
    def velocity(self) -> PatchField: ...

    def velocity_at(self, points: Array, quadrature: Quadrature) -> Array: ...

    def pressure_at(self, points: Array, quadrature: Quadrature) -> Array: ...

    def surface_pressure(self, patch: int, *parameters: Array) -> Array: ...


@dataclass(frozen=True, eq=False)
class Sample:
    """``points`` (dim, N) in the fluid and on its boundary, ``cells`` (dim + 1, M) between them,
    triangles or tetrahedra, ``velocity`` (dim, N) and ``pressure`` (N,)."""

    points: Array
    cells: NDArray[np.int64]
    velocity: Array
    pressure: Array

    def grid(self) -> Any:
        """A ``pyvista.UnstructuredGrid`` as ``volume_grid`` makes it."""
        pyvista = load_pyvista()
        cells = {pyvista.CellType.TETRA: self.cells.T}
        grid = pyvista.UnstructuredGrid(cells, self.points.T.copy())
        grid.point_data["velocity"] = self.velocity.T
        grid.point_data["pressure"] = self.pressure
        return grid


def sample_flow(solution: FlowSolution, count: int) -> Sample:
    """A flow at about ``count`` points evenly spread in the fluid that the boundary encloses, and
    at as dense ones on the boundary; at more of them where fluid is thin beside its extent."""
    boundary = solution.space.boundary
    thickness = boundary.volume() / boundary.area()  # a quarter of a square channel's width
    thin = boundary.volume() * (FINENESS / thickness) ** boundary.dimension
    spacing = (boundary.volume() / max(count, min(thin, MOST))) ** (1 / boundary.dimension)
    rim, velocity, pressure = _on_boundary(solution, spacing)
    enclosure = Enclosure(boundary)
    inner = _lattice(boundary, spacing)
    inner = inner[:, enclosure.clearance(inner).distance > CLEAR * spacing]
    points = np.hstack([rim, inner])
    cells = _cells(enclosure, points)
    return Sample(
        points,
        cells,
        np.hstack([velocity, in_portions(solution.velocity_at, inner, SHOWN, "velocity")]),
        np.hstack([pressure, in_portions(solution.pressure_at, inner, SHOWN, "pressure")]),
    )


def in_portions(
    function: Callable[[Array, Quadrature], Array],
    points: Array,
    quadrature: Quadrature,
    name: str,
) -> Array:
    """Values (..., M) of a function of points (dim, M), computed part by part."""
    starts = range(0, max(1, points.shape[1]), PORTION)
    parts = [
        function(points[:, start : start + PORTION], quadrature) for start in progress(starts, name)
    ]
    return np.concatenate(parts, axis=-1)


def _lattice(boundary: Boundary, spacing: float) -> Array:
    """Points (dim, M) about a spacing apart, in and around the boundary's bounds."""
    low, high = boundary.bounds()
    axes = [np.arange(a + 0.5 * spacing, b, spacing) for a, b in zip(low, high, strict=True)]
    points = np.stack([g.ravel() for g in np.meshgrid(*axes, indexing="ij")])
    return points + spacing * np.random.default_rng(0).uniform(-JITTER, JITTER, points.shape)


def _on_boundary(solution: FlowSolution, spacing: float) -> tuple[Array, Array, Array]:
    """Points (dim, N) on all patches about a spacing apart, velocity (dim, N), pressure (N,);
    where patches meet, the mean of theirs."""
    columns = []
    for index, patch in enumerate(solution.space.boundary.patches):
        lines = [
            np.linspace(*ends, 1 + int(np.ceil(width / spacing)))
            for ends, width in zip(patch.surface.domain, _widths(patch.surface), strict=True)
        ]
        exact = [g.ravel() for g in np.meshgrid(*lines, indexing="ij")]
        inner = [
            np.clip(g, low + INSET * (high - low), high - INSET * (high - low))
            for g, (low, high) in zip(exact, patch.surface.domain, strict=True)
        ]
        values = solution.velocity.on_patch(index, *inner)
        pressure = solution.surface_pressure(index, *inner)
        columns.append(np.vstack([patch.surface.evaluate(*exact), values, pressure]))
    every = np.hstack(columns)
    dimension = solution.space.boundary.dimension
    keys = np.round(every[:dimension] / (1e-3 * spacing)).astype(np.int64)
    _, place, owners = np.unique(keys, axis=1, return_index=True, return_inverse=True)
    counts = np.bincount(owners)
    mean = np.stack([np.bincount(owners, row) / counts for row in every[dimension:]])
    return every[:dimension, place], mean[:-1], mean[-1]


def _widths(surface: Any) -> list[float]:
    """The greatest length of a patch in each direction, along lines of its control points."""
    points = surface.points
    lengths = []
    for along in range(points.ndim - 1):
        steps = np.linalg.norm(np.diff(points, axis=along), axis=-1)
        lengths.append(float(steps.sum(axis=along).max()))
    return lengths


def _cells(enclosure: Enclosure, points: Array) -> NDArray[np.int64]:
    """Simplices between points, without those outside the fluid."""
    cells = Delaunay(points.T).simplices.T
    corners = points[:, cells]
    edges = corners[:, 1:] - corners[:, :1]
    measure = abs(np.linalg.det(np.moveaxis(edges, -1, 0)))
    keep = measure > 1e-6 * measure.mean()
    keep[keep] = enclosure.inside(corners[..., keep].mean(axis=1))
    return cells[:, keep].astype(np.int64)
