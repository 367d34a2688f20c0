"""The topology of patches: corners, edges that two of them share, and closed shells."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from cadbem.boundary import Boundary
from cadbem.spline.basis import Array
from cadbem.spline.nurbs import Nurbs
from cadbem.spline.project import closest_point

SAME = 1e-6  # share of the boundary's size within which corners and edges are the same
LOOP = (0, 3, 2, 1)  # the sides of `Nurbs.edges` in the order in which they follow each other
PROBES = (0.25, 0.5, 0.75)  # where along an edge it is compared with another


@dataclass(frozen=True, eq=False)
class Piece:
    """A piece of a patch's border between two corners, and its ends (2, 2) in parameters."""

    curve: Nurbs
    parameters: Array

    def reversed(self) -> Piece:
        return Piece(self.curve.reversed(), self.parameters[::-1])


@dataclass(frozen=True, eq=False)
class Edge:
    """A curve between two corners, by number."""

    curve: Nurbs
    start: int
    end: int


@dataclass(frozen=True)
class Side:
    """One pass along an edge: with its curve (sign 1) or against it (-1)."""

    edge: int
    sign: int


@dataclass(frozen=True, eq=False)
class Shells:
    """Corners (N, 3), edges, and for each patch its border in pieces and as sides of one loop.

    Both run clockwise seen from where the patch's normal x_u × x_v points: counter-clockwise seen
    from outside if the fluid is inside. A pole, where the border stays in a point, is a piece but
    no side. Where corners of other patches lie on a border it is cut.
    """

    boundary: Boundary
    corners: Array
    edges: tuple[Edge, ...]
    borders: tuple[tuple[Piece, ...], ...]
    loops: tuple[tuple[Side, ...], ...]

    def parts(self) -> list[tuple[int, ...]]:
        """Patches (indices) that hang together by edges."""
        pairs = [(i, s.edge) for i, loop in enumerate(self.loops) for s in loop]
        groups = _groups(pairs, len(self.loops), len(self.edges))
        return [tuple(np.flatnonzero(groups == k).tolist()) for k in dict.fromkeys(groups)]

    def is_closed(self, part: Sequence[int]) -> bool:
        """Whether each edge is passed twice, once in each direction."""
        sides = [side for i in part for side in self.loops[i]]
        passes, turns = Counter(s.edge for s in sides), Counter[int]()
        for side in sides:
            turns[side.edge] += side.sign
        return set(passes.values()) == {2} and not any(turns.values())

    def volume(self, part: Sequence[int]) -> float:
        """Volume inside a closed part: positive if the fluid is there, negative around a body."""
        patches = tuple(self.boundary.patches[i] for i in part)
        return replace(self.boundary, patches=patches).volume()


def find_shells(boundary: Boundary) -> Shells:
    """Corners and edges of the patches, the same for all patches that meet there.

    Two patches share an edge if it is the same curve up to `SAME`, whatever their parameters.
    """
    near = SAME * float(np.linalg.norm(np.ptp(boundary.bounds(), axis=0)))
    whole = [_border(patch.surface) for patch in boundary.patches]
    corners = _distinct(np.array([p.curve.points[0] for border in whole for p in border]), near)
    tree = cKDTree(corners)
    borders = [
        tuple(part for piece in border for part in _cut(piece, tree, near)) for border in whole
    ]
    edges: list[Edge] = []
    known: dict[frozenset[int], list[int]] = {}
    loops = []
    for border in borders:
        curves = [piece.curve for piece in border if not _is_point(piece.curve, near)]
        loops.append(tuple(_side(curve, edges, known, tree, near) for curve in curves))
    return Shells(boundary, corners, tuple(edges), tuple(borders), tuple(loops))


def _border(surface: Nurbs) -> list[Piece]:
    (u0, u1), (v0, v1) = surface.domain
    corners = np.array([(u1, v0), (u0, v0), (u0, v1), (u1, v1), (u1, v0)])
    curves = [surface.edges()[k] for k in LOOP]
    return [Piece(curve, corners[k : k + 2]) for k, curve in enumerate(curves)]


def _distinct(points: Array, near: float) -> Array:
    """The first of all points that are the same."""
    pairs = cKDTree(points).query_pairs(near, output_type="ndarray")
    graph = coo_array((np.ones(len(pairs)), pairs.T), shape=(len(points), len(points)))
    _, groups = connected_components(graph, directed=False)
    return points[np.unique(groups, return_index=True)[1]]


def _cut(piece: Piece, tree: cKDTree, near: float) -> list[Piece]:
    """The border cut where corners lie on it."""
    curve, (low, high) = piece.curve, piece.curve.domain[0]
    middle = curve.points.mean(axis=0)
    reach = np.linalg.norm(curve.points - middle, axis=1).max() + near
    cuts = []
    for corner in tree.data[tree.query_ball_point(middle, reach)]:
        if np.linalg.norm(curve.points[[0, -1]] - corner, axis=1).min() > near:
            parameters, distance = closest_point(curve, corner)
            cuts += [float(parameters[0])] if distance < near else []
    ends = [low, *sorted(cuts), high]
    if _is_point(curve, near) or not cuts:
        return [piece]
    start, step = piece.parameters[0], np.diff(piece.parameters, axis=0) / (high - low)
    return [
        Piece(curve.restricted((a, b)), start + np.array([[a - low], [b - low]]) * step)
        for a, b in pairwise(ends)
    ]


def _is_point(curve: Nurbs, near: float) -> bool:
    return bool(np.ptp(curve.points, axis=0).max() < 2 * near)


def _side(
    curve: Nurbs,
    edges: list[Edge],
    known: dict[frozenset[int], list[int]],
    tree: cKDTree,
    near: float,
) -> Side:
    """The pass along a known edge that is the same curve, or along a new one."""
    start, end = (int(k) for k in tree.query(curve.points[[0, -1]])[1])
    alike = known.setdefault(frozenset((start, end)), [])
    for number in alike:
        sign = _direction(curve, edges[number].curve, near)
        if sign:
            return Side(number, sign)
    alike.append(len(edges))
    edges.append(Edge(curve, start, end))
    return Side(len(edges) - 1, 1)


def _direction(curve: Nurbs, other: Nurbs, near: float) -> int:
    """1 if both run along the same points, -1 if one runs backwards, 0 if they part."""
    for sign, turned in ((1, curve), (-1, curve.reversed())):
        if _has_same_net(turned, other, near):
            return sign
    low, high = curve.domain[0]
    points = [curve.evaluate(low + share * (high - low)) for share in PROBES]
    found = [closest_point(other, point) for point in points]
    if max(distance for _, distance in found) > near:
        return 0
    return 1 if found[0][0] < found[-1][0] else -1


def _has_same_net(curve: Nurbs, other: Nurbs, near: float) -> bool:
    if curve.degrees != other.degrees or curve.weights.shape != other.weights.shape:
        return False
    knots = [(c.knots[0] - c.knots[0][0]) / np.ptp(c.knots[0]) for c in (curve, other)]
    weights = [c.weights / c.weights[0] for c in (curve, other)]
    return (
        float(np.abs(curve.points - other.points).max()) < near
        and np.allclose(knots[0], knots[1], rtol=0, atol=SAME)
        and np.allclose(weights[0], weights[1], rtol=SAME, atol=0)
    )


def _groups(pairs: list[tuple[int, int]], rows: int, columns: int) -> Array:
    """Number of the connected group of each row of a graph between rows and columns."""
    first, second = np.array(pairs).reshape(-1, 2).T
    size = rows + columns
    graph = coo_array((np.ones(len(first)), (first, rows + second)), shape=(size, size))
    return connected_components(graph, directed=False)[1][:rows]
