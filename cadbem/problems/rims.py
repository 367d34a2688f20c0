"""The edges at which surfaces end: those of a patch that no other edge lies beside."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from cadbem.boundary import Patch
from cadbem.spline.basis import Array
from cadbem.spline.nurbs import Nurbs
from cadbem.spline.project import closest_point

PROBE = 0.37  # where along an edge it is asked what lies beside it: not a corner of smaller patches
BESIDE = 1e-3  # share of an edge's length within which another one lies beside it


@dataclass(frozen=True, eq=False)
class Edge:
    """An edge of the patch with an ``index``: its ``curve``, its ``length`` (0: a pole, or the end
    of a plane curve), and the point (dim,) at which it is ``probed``, from either end."""

    index: int
    curve: Nurbs
    length: float
    probed: tuple[Array, Array]


def edges_of(patches: Sequence[Patch]) -> list[Edge]:
    """The edges of all patches that are no poles."""
    edges = [_edge(i, curve) for i, patch in enumerate(patches) for curve in patch.surface.edges()]
    return [edge for edge in edges if edge.length or edge.curve.degrees == (0,)]


def open_edges(edges: Sequence[Edge], size: float) -> list[Edge]:
    """Those of the edges that no other one lies beside; ``size`` is that of the whole boundary."""
    tree = cKDTree([point for edge in edges for point in edge.probed])
    low = np.array([edge.curve.points.reshape(-1, tree.m).min(axis=0) for edge in edges])
    high = np.array([edge.curve.points.reshape(-1, tree.m).max(axis=0) for edge in edges])
    found = []
    for k, edge in enumerate(edges):
        point, near = edge.probed[0], BESIDE * (edge.length or size)
        if any(other // 2 != k for other in tree.query_ball_point(point, near)):
            continue  # edges of equal patches lie beside each other point by point
        around = ((low <= point + near) & (high >= point - near)).all(axis=1)
        others = [edges[int(j)].curve for j in np.nonzero(around)[0] if j != k]
        if not any(_distance(other, point) <= near for other in others):
            found.append(edge)
    return found


def _edge(index: int, curve: Nurbs) -> Edge:
    (start, end), points = curve.domain[0], curve.points.reshape(-1, curve.dimension)
    probed = [curve.evaluate(start + t * (end - start)).ravel() for t in (PROBE, 1 - PROBE)]
    length = float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())
    scale = float(np.abs(points).max())
    return Edge(index, curve, length if length > 1e-9 * scale else 0.0, (probed[0], probed[1]))


def _distance(curve: Nurbs, point: Array) -> float:
    if curve.degrees == (0,):
        return float(np.linalg.norm(curve.points.ravel() - point))
    return closest_point(curve, point)[1]
