"""The closed surfaces that a boundary consists of: containers, and bodies in the fluid."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from cadbem.boundary import Boundary
from cadbem.errors import ConditionError
from cadbem.problems.rims import edges_of, open_edges
from cadbem.spline.basis import Array
from cadbem.spline.project import closest_point

SAME_CORNER = 1e-6  # share of the boundary's size within which corners count as one
OPEN = 1e-3  # |∫ n dS| over area from which a surface counts as open
FLAT = 0.8  # the same, from which it is a plate
JOINED = 0.5  # share of a surface's edges that others share, from which it is nearly closed
MOST_PLACES = 4  # that a message names


@dataclass(frozen=True, eq=False)
class Surface:
    """Patches (indices) that hang together; open, or closed around fluid, or around a body.

    ``volume`` of the fluid inside: negative for a body, 0 for an open surface (a thin plate), whose
    ``rim`` are points (dim,) on its open edges.  ``nearly_closed``: most edges are shared, and it
    is far from flat.
    """

    patches: tuple[int, ...]
    volume: float
    rim: tuple[Array, ...] = ()
    nearly_closed: bool = False

    @property
    def holds_fluid(self) -> bool:
        """Whether the fluid is inside."""
        return self.volume > 0

    @property
    def is_body(self) -> bool:
        """Whether the fluid is outside."""
        return self.volume < 0


def closed_surfaces(boundary: Boundary) -> list[Surface]:
    """The connected surfaces of a boundary.

    Patches are connected by a common corner, or where a corner of one lies on an edge of another.
    """
    ends = list(product((0, -1), repeat=boundary.dimension - 1))
    corners = np.array([p.surface.points[i] for p in boundary.patches for i in ends])
    near = SAME_CORNER * float(np.linalg.norm(np.ptp(boundary.bounds(), axis=0)))
    pairs = cKDTree(corners).query_pairs(near, output_type="ndarray") // len(ends)
    label = _components(len(boundary.patches), pairs)
    if boundary.dimension == 3 and label.max() > 0:
        hanging = _hanging(boundary, corners, label, near)
        label = _components(len(label), np.concatenate([pairs, hanging]))
    groups = range(label.max() + 1)
    size = near / SAME_CORNER
    return [_surface(boundary, tuple(np.nonzero(label == k)[0].tolist()), size) for k in groups]


def _components(count: int, pairs: NDArray[np.int64]) -> NDArray[np.int32]:
    """The number of the component of each of ``count`` patches that pairs (n, 2) connect."""
    graph = coo_array((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(count, count))
    return connected_components(graph, directed=False)[1]


def _hanging(
    boundary: Boundary, corners: Array, label: NDArray[np.int32], near: float
) -> NDArray[np.int64]:
    """Pairs (n, 2) of patches of different components, a corner of one on an edge of the other."""
    each = len(corners) // len(label)
    pairs = []
    for number, patch in enumerate(boundary.patches):
        others = np.repeat(label != label[number], each)
        for edge in patch.surface.edges():
            low, high = edge.points.min(axis=0) - near, edge.points.max(axis=0) + near
            inside = ((corners >= low) & (corners <= high)).all(axis=1) & others
            for k in np.nonzero(inside)[0]:
                if closest_point(edge, corners[k])[1] <= near:
                    pairs.append((number, int(k) // each))
    return np.array(pairs, dtype=np.int64).reshape(-1, 2)


def _surface(boundary: Boundary, indices: tuple[int, ...], size: float) -> Surface:
    part = Boundary(tuple(boundary.patches[i] for i in indices))
    points, weights = part.quadrature()
    flatness = float(np.linalg.norm(points.normal @ weights) / weights.sum())
    edges = edges_of(part.patches)
    rim = tuple(edge.probed[0] for edge in open_edges(edges, size)) if edges else ()
    if not rim and flatness <= OPEN:
        return Surface(indices, part.volume())
    nearly_closed = flatness < FLAT and len(rim) <= JOINED * len(edges)
    return Surface(indices, 0.0, rim, nearly_closed)


def check_closed(boundary: Boundary, surfaces: Sequence[Surface], remedy: str) -> None:
    """Raises ``ConditionError`` for a surface that is nearly closed, with its open edges."""
    for surface in surfaces:
        if surface.nearly_closed:
            places = ["(" + ", ".join(f"{x:.4g}" for x in p) + ")" for p in surface.rim]
            more = f" and {len(places) - MOST_PLACES} more" if len(places) > MOST_PLACES else ""
            where = f"edges are open at {', '.join(places[:MOST_PLACES])}{more}"
            raise ConditionError(
                f"{boundary.source or 'the boundary'} is nearly closed: "
                f"{where if places else 'its faces do not point the same way'}; {remedy}"
            )


def point_inside(boundary: Boundary, body: Surface) -> Array:
    """A point (dim,) inside a body: the middle of its box or, if that is outside, one below the
    surface."""
    part = Boundary(tuple(boundary.patches[i] for i in body.patches))
    points, weights = part.quadrature()
    size = abs(body.volume) / float(weights.sum())
    middles = [p.middle() for p in part.patches]
    below = [(m.position - share * size * m.normal)[:, 0] for share in (1.0, 0.5) for m in middles]
    candidates = [part.bounds().mean(axis=0), *below]

    def solid_angle(point: Array) -> float:
        r = points.position - point[:, None]
        distance = np.linalg.norm(r, axis=0)
        return float((r * points.normal).sum(axis=0) / distance**boundary.dimension @ weights)

    around = 2 * (boundary.dimension - 1) * np.pi
    return max(candidates, key=lambda point: -abs(solid_angle(point) - around))
