"""The closed surfaces that a boundary consists of: containers, and bodies in the fluid."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from cadbem.boundary import Boundary
from cadbem.spline.basis import Array

SAME_CORNER = 1e-6  # share of the boundary's size within which corners count as one
OPEN = 1e-3  # |∫ n dS| over area from which a surface counts as open


@dataclass(frozen=True, eq=False)
class Surface:
    """Patches (indices) that hang together; open, or closed around fluid, or around a body.

    ``volume`` of the fluid inside: negative for a body, 0 for an open surface (a thin plate).
    """

    patches: tuple[int, ...]
    volume: float

    @property
    def holds_fluid(self) -> bool:
        """Whether the fluid is inside."""
        return self.volume > 0

    @property
    def is_body(self) -> bool:
        """Whether the fluid is outside."""
        return self.volume < 0


def closed_surfaces(boundary: Boundary) -> list[Surface]:
    """The connected surfaces of a boundary; patches with a common corner are connected."""
    ends = list(product((0, -1), repeat=boundary.dimension - 1))
    corners = np.array([p.surface.points[i] for p in boundary.patches for i in ends])
    size = float(np.linalg.norm(np.ptp(boundary.bounds(), axis=0)))
    pairs = cKDTree(corners).query_pairs(SAME_CORNER * size, output_type="ndarray") // len(ends)
    count = len(boundary.patches)
    graph = coo_array((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(count, count))
    number, label = connected_components(graph, directed=False)
    return [_surface(boundary, tuple(np.nonzero(label == k)[0].tolist())) for k in range(number)]


def _surface(boundary: Boundary, indices: tuple[int, ...]) -> Surface:
    part = Boundary(tuple(boundary.patches[i] for i in indices))
    points, weights = part.quadrature()
    is_open = np.linalg.norm(points.normal @ weights) > OPEN * weights.sum()
    return Surface(indices, 0.0 if is_open else part.volume())


def point_inside(boundary: Boundary, body: Surface) -> Array:
    """A point (dim,) inside a body: the middle of its box or, if that is outside, one below the
    surface."""
    part = Boundary(tuple(boundary.patches[i] for i in body.patches))
    points, weights = part.quadrature()
    size = abs(body.volume) / float(weights.sum())
    middles = [p.middle() for p in part.patches]
    below = [
        (m.position - share * size * m.normal)[:, 0] for share in (1.0, 0.5) for m in middles
    ]
    candidates = [part.bounds().mean(axis=0), *below]

    def solid_angle(point: Array) -> float:
        r = points.position - point[:, None]
        distance = np.linalg.norm(r, axis=0)
        return float((r * points.normal).sum(axis=0) / distance**boundary.dimension @ weights)

    around = 2 * (boundary.dimension - 1) * np.pi
    return max(candidates, key=lambda point: -abs(solid_angle(point) - around))
