"""Lengths of patches, and the width of the channel beside them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cadbem.boundary import Boundary, Patch
from cadbem.points import surface_points
from cadbem.spline.basis import Array
from cadbem.spline.nurbs import Nurbs

Side = tuple[int, int]  # a direction of the parameters, and its first (0) or last (1) end

LINES = 9  # samples a direction in which lengths and turns are measured
CLOUD = 8.0  # samples a typical patch length, for widths
FEWEST, MOST = 6, 40  # samples a direction of a patch
MEMORY = 4_000_000  # pairs of samples at once


def inner(surface: Nurbs, direction: int, count: int) -> Array:
    """The middles (count,) of equal parts of a direction's parameters."""
    low, high = surface.domain[direction]
    return low + (high - low) * (np.arange(count) + 0.5) / count


def side_parameters(surface: Nurbs, side: Side, count: int) -> list[Array]:
    """Parameters (count,) in each direction of points inside a side."""
    direction, end = side
    return [
        np.full(count, ends[end]) if d == direction else inner(surface, d, count)
        for d, ends in enumerate(surface.domain)
    ]


def lengths(surface: Nurbs) -> list[float]:
    """The longest line along each direction."""
    grid = [np.linspace(*ends, LINES) for ends in surface.domain]
    points = surface.evaluate(*np.meshgrid(*grid, indexing="ij"))
    return [
        float(np.linalg.norm(np.diff(points, axis=1 + d), axis=0).sum(axis=d).max())
        for d in range(len(grid))
    ]


def turning(surface: Nurbs, direction: int) -> float:
    """The largest angle (radians) by which the lines along a direction turn."""
    grid = [np.linspace(*ends, LINES) for ends in surface.domain]
    points = surface.evaluate(*np.meshgrid(*grid, indexing="ij"))
    chords = np.moveaxis(np.diff(points, axis=1 + direction), 1 + direction, -1)
    size = np.linalg.norm(chords, axis=0)
    unit = chords / np.where(size > 1e-9 * max(float(size.max()), 1e-300), size, np.inf)
    cosine = np.clip((unit[..., 1:] * unit[..., :-1]).sum(axis=0), -1.0, 1.0)
    angles = np.where((size[..., 1:] > 0) & (size[..., :-1] > 0), np.arccos(cosine), 0.0)
    # the chords of n - 1 parts turn by n - 2 of n - 1 parts of the whole
    return float(angles.sum(axis=-1).max()) * (LINES - 1) / (LINES - 2)


@dataclass(frozen=True, eq=False)
class Widths:
    """The width of the fluid beside points of a boundary, from samples of all of it.

    The width at a point is the diameter of the largest ball that touches the boundary there and
    holds no sample: min |y - x|² / (y - x)·n over samples y.
    """

    cloud: Array  # (dim, N)

    @classmethod
    def of(cls, boundary: Boundary) -> Widths:
        """From some hundred samples a patch."""
        sizes = [lengths(p.surface) for p in boundary.patches]
        typical = float(np.median([min(s) for s in sizes]))
        parts = []
        for patch, size in zip(boundary.patches, sizes, strict=True):
            counts = np.clip(np.ceil(CLOUD * np.array(size) / typical), FEWEST, MOST).astype(int)
            axes = [inner(patch.surface, d, n) for d, n in enumerate(counts)]
            grid = np.meshgrid(*axes, indexing="ij")
            parts.append(patch.surface.evaluate(*grid).reshape(boundary.dimension, -1))
        return cls(np.concatenate(parts, axis=1))

    def at(self, position: Array, normal: Array) -> Array:
        """Widths (M,) at points (dim, M) with normals into the fluid; inf where there is no end."""
        result = np.empty(position.shape[1])
        chunk = max(1, MEMORY // self.cloud.shape[1])
        for low in range(0, len(result), chunk):
            part = slice(low, low + chunk)
            away = self.cloud[:, None] - position[:, part, None]
            ahead = np.einsum("cmn,cm->mn", away, normal[:, part])
            square = (away**2).sum(axis=0)
            far = ahead > 1e-2 * np.sqrt(square)
            ball = np.where(far, square / np.where(far, ahead, 1.0), np.inf)
            result[part] = ball.min(axis=1)
        return result

    def along(self, patch: Patch, direction: int, count: int) -> Array:
        """Widths (count,) beside lines across a direction: the largest on each."""
        surface = patch.surface
        axes = [inner(surface, d, count if d == direction else 5) for d in
                range(len(surface.degrees))]  # fmt: skip
        grid = np.meshgrid(*axes, indexing="ij")
        points = surface_points(surface, *[g.ravel() for g in grid])
        values = self.at(points.position, points.normal).reshape(grid[0].shape)
        return np.moveaxis(values, direction, 0).reshape(count, -1).max(axis=1)
