"""Edges at which tractions are not smooth.

Where the fluid's angle is above 180 degrees they are infinite.  Where two faces join smoothly, but
the curvature across the edge jumps by κ, as between a straight channel and a bend, a shear flow
along the wall meets an offset κx²/2 on one side: tractions are continuous, and change like
κ x log|x| at the distance x from the edge.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from cadbem.boundary import Boundary
from cadbem.elements.shape import Side, side_parameters
from cadbem.points import SurfacePoints, surface_points
from cadbem.spline.basis import Array
from cadbem.spline.nurbs import Nurbs
from cadbem.spline.project import closest_point

SAMPLES = 16  # an edge
SHARPEST = np.sin(np.deg2rad(10.0))  # of the angle beyond 180 degrees that counts
NEIGHBOURS = 24  # nearest samples among which an edge's neighbours are sought
SMOOTH = 0.999  # cosine of the angle between faces that join smoothly
OFF = 0.1  # how far an edge may run beside its neighbour's samples, over their spacing
TOUCHING = 1e-6  # share of the boundary's size within which a patch holds a point


@dataclass(frozen=True, eq=False)
class Singular:
    """``sides``: which sides of each patch are re-entrant edges; ``corners``: parameters (p,) of
    points of each patch at which a re-entrant edge of other patches ends; ``bends``: by how much
    the curvature jumps across sides at which a patch joins others smoothly."""

    sides: tuple[frozenset[Side], ...]
    corners: tuple[tuple[Array, ...], ...]
    bends: tuple[dict[Side, float], ...]


@dataclass(frozen=True, eq=False)
class _Edges:
    """Samples of all patches' edges: ``position``, ``normal``, ``inward``, ``along`` (dim, N) (all
    but the first of unit length), their ``spacing``, the ``curvature`` of the patch in the
    direction inward and the number of the ``patch`` (N,)."""

    position: Array
    normal: Array
    inward: Array
    along: Array
    spacing: Array
    curvature: Array
    patch: Array
    sides: list[tuple[int, Side]]

    @property
    def count(self) -> int:
        """Samples a side."""
        return len(self.patch) // max(len(self.sides), 1)


def singular_parts(boundary: Boundary) -> Singular:
    """Where such edges lie on a boundary's patches."""
    edges = _sampled(boundary)
    form = len(edges.sides), edges.count
    flags, jumps = _reentrant(edges).reshape(form), _curvature_jumps(edges).reshape(form)
    sides: list[set[Side]] = [set() for _ in boundary.patches]
    bends: list[dict[Side, float]] = [{} for _ in boundary.patches]
    ends: list[Array] = []
    for (patch, side), flag, jump in zip(edges.sides, flags, jumps, strict=True):
        bends[patch][side] = float(jump.max())
        if flag.mean() > 0.75:
            sides[patch].add(side)
            ends += _ends(boundary.patches[patch].surface, side)
    corners = _corners(boundary, sides, ends)
    return Singular(tuple(map(frozenset, sides)), corners, tuple(bends))


def _sampled(boundary: Boundary) -> _Edges:
    parts, sides = [], []
    for number, patch in enumerate(boundary.patches):
        surface = patch.surface
        for side in product(range(len(surface.degrees)), (0, 1)):
            if _length(surface, side) > 0 or boundary.dimension == 2:
                parts.append(_samples(surface, side))
                sides.append((number, side))
    stacked = [np.concatenate(x, axis=-1) for x in zip(*parts, strict=True)]
    position, normal, inward, along, spacing, curvature = stacked
    owner = np.repeat([number for number, _ in sides], len(spacing) // len(sides))
    return _Edges(position, normal, inward, along, spacing, curvature, owner, sides)


def _length(surface: Nurbs, side: Side) -> float:
    x = surface.evaluate(*side_parameters(surface, side, 5))
    size = float(np.ptp(surface.points.reshape(-1, surface.dimension), axis=0).max())
    length = float(np.linalg.norm(np.diff(x, axis=1), axis=0).sum())
    return length if length > TOUCHING * size else 0.0


def _samples(surface: Nurbs, side: Side) -> tuple[Array, ...]:
    direction, end = side
    count = SAMPLES if len(surface.degrees) == 2 else 1
    parameters = side_parameters(surface, side, count)
    points = surface_points(surface, *parameters)
    across = points.tangents[direction] * (1.0 if end == 0 else -1.0)
    if len(surface.degrees) == 1:
        along, spacing = np.zeros_like(across), np.zeros(1)
    else:
        along = _unit(points.tangents[1 - direction])
        across = across - (across * along).sum(axis=0) * along
        steps = np.linalg.norm(np.diff(points.position, axis=1), axis=0)
        spacing = np.full(count, max(float(steps.max()), 1e-300))
    inward = _unit(across)
    curvature = _curvature(surface, parameters, points, inward)
    return points.position, points.normal, inward, along, spacing, curvature


def _curvature(
    surface: Nurbs, parameters: list[Array], points: SurfacePoints, direction: Array
) -> Array:
    """Normal curvature (N,) in a tangential direction (dim, N): n·x'' along it."""
    second = surface.derivatives(2, *parameters)
    # the direction in steps of the parameters, least squares where the surface is a point
    tangents = np.moveaxis(points.tangents, (0, 1, 2), (2, 1, 0))
    steps = (np.linalg.pinv(tangents) @ direction.T[..., None])[..., 0].T
    bend = np.zeros(direction.shape[1])
    for i, j in product(range(len(steps)), repeat=2):
        key = [0] * len(steps)
        key[i] += 1
        key[j] += 1
        acceleration = second[tuple(key)].reshape(direction.shape)
        bend += steps[i] * steps[j] * (points.normal * acceleration).sum(axis=0)
    return bend


def _unit(vectors: Array) -> Array:
    size = np.linalg.norm(vectors, axis=0)
    return vectors / np.where(size > 0, size, 1.0)


def _neighbours(edges: _Edges) -> Iterator[tuple[NDArray[np.int64], NDArray[np.bool_]]]:
    """For all samples at once, one after the other of those near by (N,), and whether it is on the
    same edge of another patch."""
    k = min(NEIGHBOURS, len(edges.patch))
    _, others = cKDTree(edges.position.T).query(edges.position.T, k=k)
    size = float(np.ptp(edges.position, axis=1).max())
    for j in np.reshape(others, (-1, k)).T:
        way = edges.position - edges.position[:, j]
        on = (way * edges.along[:, j]).sum(axis=0)
        off = np.linalg.norm(way - on * edges.along[:, j], axis=0)
        beside = (off <= OFF * edges.spacing[j] + TOUCHING * size) & (
            abs(on) <= edges.spacing[j] + TOUCHING * size
        )
        yield j, beside & (edges.patch != edges.patch[j])


def _reentrant(edges: _Edges) -> NDArray[np.bool_]:
    """Whether the fluid's angle between a sample's patch and another one there is above 180°."""
    found = np.zeros(len(edges.patch), dtype=bool)
    for j, beside in _neighbours(edges):
        here = (edges.inward[:, j] * edges.normal).sum(axis=0) < -SHARPEST
        there = (edges.inward * edges.normal[:, j]).sum(axis=0) < -SHARPEST
        found |= beside & here & there
    return found


def _curvature_jumps(edges: _Edges) -> Array:
    """By how much the curvature differs beyond each sample, where another patch joins smoothly."""
    least = np.full(len(edges.patch), np.inf)
    for j, beside in _neighbours(edges):
        smooth = (edges.normal * edges.normal[:, j]).sum(axis=0) > SMOOTH
        ahead = (edges.inward * edges.inward[:, j]).sum(axis=0) < -SMOOTH
        jump = abs(edges.curvature - edges.curvature[j])
        least = np.where(beside & smooth & ahead, np.minimum(least, jump), least)
    return np.where(np.isfinite(least), least, 0.0)


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
