"""Edges at which the fluid's angle is above 180 degrees: there tractions are singular."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

import numpy as np
from scipy.spatial import cKDTree

from cadbem.boundary import Boundary
from cadbem.elements.shape import Side, side_parameters
from cadbem.points import surface_points
from cadbem.spline.basis import Array
from cadbem.spline.nurbs import Nurbs
from cadbem.spline.project import closest_point

SAMPLES = 16  # an edge
SHARPEST = np.sin(np.deg2rad(10.0))  # of the angle beyond 180 degrees that counts
NEIGHBOURS = 24  # nearest samples among which an edge's neighbours are sought
OFF = 0.1  # how far an edge may run beside its neighbour's samples, over their spacing
TOUCHING = 1e-6  # share of the boundary's size within which a patch holds a point


@dataclass(frozen=True, eq=False)
class Singular:
    """``sides``: which sides of each patch are re-entrant edges; ``corners``: parameters (p,) of
    points of each patch at which a re-entrant edge of other patches ends."""

    sides: tuple[frozenset[Side], ...]
    corners: tuple[tuple[Array, ...], ...]


@dataclass(frozen=True, eq=False)
class _Edges:
    """Samples of all patches' edges: ``position``, ``normal``, ``inward``, ``along`` (dim, N) (all
    but the first of unit length), their ``spacing`` and the number of the ``patch`` (N,)."""

    position: Array
    normal: Array
    inward: Array
    along: Array
    spacing: Array
    patch: Array
    sides: list[tuple[int, Side]]

    @property
    def count(self) -> int:
        """Samples a side."""
        return len(self.patch) // max(len(self.sides), 1)


def singular_parts(boundary: Boundary) -> Singular:
    """Where re-entrant edges lie on a boundary's patches."""
    edges = _sampled(boundary)
    flags = _reentrant(edges).reshape(len(edges.sides), edges.count)
    sides: list[set[Side]] = [set() for _ in boundary.patches]
    ends: list[Array] = []
    for (patch, side), flag in zip(edges.sides, flags, strict=True):
        if flag.mean() > 0.75:
            sides[patch].add(side)
            ends += _ends(boundary.patches[patch].surface, side)
    return Singular(tuple(map(frozenset, sides)), _corners(boundary, sides, ends))


def _sampled(boundary: Boundary) -> _Edges:
    parts, sides = [], []
    for number, patch in enumerate(boundary.patches):
        surface = patch.surface
        for side in product(range(len(surface.degrees)), (0, 1)):
            if _length(surface, side) > 0 or boundary.dimension == 2:
                parts.append(_samples(surface, side))
                sides.append((number, side))
    stacked = [np.concatenate(x, axis=-1) for x in zip(*parts, strict=True)]
    position, normal, inward, along, spacing = stacked
    owner = np.repeat([number for number, _ in sides], len(spacing) // len(sides))
    return _Edges(position, normal, inward, along, spacing, owner, sides)


def _length(surface: Nurbs, side: Side) -> float:
    x = surface.evaluate(*side_parameters(surface, side, 5))
    size = float(np.ptp(surface.points.reshape(-1, surface.dimension), axis=0).max())
    length = float(np.linalg.norm(np.diff(x, axis=1), axis=0).sum())
    return length if length > TOUCHING * size else 0.0


def _samples(surface: Nurbs, side: Side) -> tuple[Array, Array, Array, Array, Array]:
    direction, end = side
    count = SAMPLES if len(surface.degrees) == 2 else 1
    points = surface_points(surface, *side_parameters(surface, side, count))
    across = points.tangents[direction] * (1.0 if end == 0 else -1.0)
    if len(surface.degrees) == 1:
        along, spacing = np.zeros_like(across), np.zeros(1)
    else:
        along = _unit(points.tangents[1 - direction])
        across = across - (across * along).sum(axis=0) * along
        steps = np.linalg.norm(np.diff(points.position, axis=1), axis=0)
        spacing = np.full(count, max(float(steps.max()), 1e-300))
    return points.position, points.normal, _unit(across), along, spacing


def _unit(vectors: Array) -> Array:
    size = np.linalg.norm(vectors, axis=0)
    return vectors / np.where(size > 0, size, 1.0)


def _reentrant(edges: _Edges) -> np.ndarray:
    """Whether the fluid's angle between a sample's patch and another one there is above 180°."""
    k = min(NEIGHBOURS, len(edges.patch))
    _, others = cKDTree(edges.position.T).query(edges.position.T, k=k)
    found = np.zeros(len(edges.patch), dtype=bool)
    size = float(np.ptp(edges.position, axis=1).max())
    for j in np.reshape(others, (-1, k)).T:
        way = edges.position - edges.position[:, j]
        on = (way * edges.along[:, j]).sum(axis=0)
        off = np.linalg.norm(way - on * edges.along[:, j], axis=0)
        beside = (off <= OFF * edges.spacing[j] + TOUCHING * size) & (
            abs(on) <= edges.spacing[j] + TOUCHING * size
        )
        here = (edges.inward[:, j] * edges.normal).sum(axis=0) < -SHARPEST
        there = (edges.inward * edges.normal[:, j]).sum(axis=0) < -SHARPEST
        found |= beside & here & there & (edges.patch != edges.patch[j])
    return found


def _ends(surface: Nurbs, side: Side) -> list[Array]:
    """The end points (dim,) of a side of a surface; none of a curve."""
    if len(surface.degrees) == 1:
        return []
    direction, end = side
    other = surface.domain[1 - direction]
    result = []
    for value in other:
        place = [0.0, 0.0]
        place[direction], place[1 - direction] = surface.domain[direction][end], value
        result.append(surface.evaluate(*place).reshape(-1))
    return result


def _corners(
    boundary: Boundary, sides: list[set[Side]], ends: list[Array]
) -> tuple[tuple[Array, ...], ...]:
    """For each patch the parameters of ends of re-entrant edges that it touches, but for those on
    its own re-entrant sides."""
    near = TOUCHING * float(np.linalg.norm(np.ptp(boundary.bounds(), axis=0)))
    distinct: list[Array] = []
    for point in ends:
        if all(np.linalg.norm(point - other) > near for other in distinct):
            distinct.append(point)
    result: list[tuple[Array, ...]] = []
    for patch, own in zip(boundary.patches, sides, strict=True):
        net = patch.surface.points.reshape(-1, boundary.dimension)
        low, high = net.min(axis=0) - near, net.max(axis=0) + near
        here = []
        for point in (p for p in distinct if ((p >= low) & (p <= high)).all()):
            place, distance = closest_point(patch.surface, point)
            if distance <= near and not any(_on(patch.surface, side, place) for side in own):
                here.append(place)
        result.append(tuple(here))
    return tuple(result)


def _on(surface: Nurbs, side: Side, place: Array) -> bool:
    low, high = surface.domain[side[0]]
    return abs(place[side[0]] - (low, high)[side[1]]) < 1e-6 * (high - low)
