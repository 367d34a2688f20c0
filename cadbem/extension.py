"""Channels that are lengthened by a straight piece at a flat opening."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from cadbem.boundary import Boundary, Patch
from cadbem.checks import positive
from cadbem.errors import SelectionError
from cadbem.points import area_vector
from cadbem.spline.basis import Array
from cadbem.spline.nurbs import Nurbs
from cadbem.spline.project import closest_point

FLAT = 1e-9  # how far an opening may leave its plane, and its normal turn, relative to 1
TOUCHING = 1e-6  # share of the boundary's size within which edges count as common
LINEAR = np.array([0.0, 0.0, 1.0, 1.0])
PROBE = 0.37  # where along an edge it is asked what lies at its other side


def extended(boundary: Boundary, name: str, length: float) -> Boundary:
    """The boundary with a straight piece of channel, ``length`` long, at a flat opening.

    The patches of ``name`` move outwards, and from the opening's rim grow new walls, each a
    continuation of the wall (its name and face) that meets the opening there; they are straight
    along the new piece, so raise degrees and refine afterwards.  Raises ``SelectionError`` for an
    unknown name, an opening that is not flat or has no walls around it, a length not positive.
    """
    positive("length", length)
    opening = [p for p in boundary.patches if p.name == name]
    others = [p for p in boundary.patches if p.name != name]
    if not opening:
        there = ", ".join(f"'{n}'" for n in boundary.names)
        raise SelectionError(f"no face is named '{name}'; the names are {there}")
    shift = -length * _normal(name, opening)
    near = TOUCHING * float(np.linalg.norm(np.ptp(boundary.bounds(), axis=0)))
    walls = []
    for patch, edge in _rim(opening, near):
        beside = _neighbour(name, edge, others, near)
        walls.append(replace(beside, surface=_extruded(edge, shift, patch)))
    moved = {
        id(p): replace(p, surface=p.surface.transformed(np.eye(boundary.dimension), shift))
        for p in opening
    }
    patches = [moved.get(id(p), p) for p in boundary.patches]
    return replace(boundary, patches=(*patches, *walls))


def _normal(name: str, opening: list[Patch]) -> Array:
    """The normal (dim,) that all points of an opening share."""
    points, weights = Boundary(tuple(opening)).quadrature()
    normal, centre = points.normal[:, 0], points.position[:, :1]
    off = normal @ (points.position - centre)
    size = np.linalg.norm(points.position - centre, axis=0).max()
    turned = np.abs(points.normal - normal[:, None]).max()
    if turned > FLAT or np.abs(off).max() > FLAT * size:
        raise SelectionError(
            f"'{name}' is not flat, and only flat openings can be moved; name one flat opening only"
        )
    mean = points.normal @ weights
    return mean / np.linalg.norm(mean)


def _rim(opening: list[Patch], near: float) -> list[tuple[Patch, Nurbs]]:
    """The opening's edges that no two of its patches share, each with its patch."""
    edges = [(p, edge) for p in opening for edge in p.surface.edges()]
    rim = []
    for patch, edge in edges:
        shared = any(_touches(edge, e, near) for p, e in edges if p is not patch)
        if not shared and not _is_point(edge, near):
            rim.append((patch, edge))
    return rim


def _neighbour(name: str, edge: Nurbs, others: list[Patch], near: float) -> Patch:
    """The patch at the other side of an edge of an opening."""
    for patch in others:
        if any(_touches(edge, e, near) for e in patch.surface.edges()):
            return patch
    place = np.array2string(_probe(edge), precision=4, separator=", ")
    raise SelectionError(
        f"'{name}' has no wall at {place}; name an opening that has walls all around"
    )


def _probe(edge: Nurbs) -> Array:
    """A point (dim,) of an edge that is not in its middle."""
    low, high = edge.domain[0]
    return edge.evaluate(low + PROBE * (high - low))


def _touches(edge: Nurbs, other: Nurbs, near: float) -> bool:
    """Whether another edge passes where this one is probed."""
    point = _probe(edge)
    if other.degrees == (0,):
        return float(np.linalg.norm(_probe(other) - point)) < near
    return closest_point(other, point)[1] < near


def _is_point(edge: Nurbs, near: float) -> bool:
    """Whether an edge of a surface has shrunk to a point."""
    return edge.degrees != (0,) and float(np.ptp(edge.points, axis=0).max()) < near


def _extruded(edge: Nurbs, shift: Array, patch: Patch) -> Nurbs:
    """The wall that an edge of an opening's patch leaves behind, its normal inwards."""
    ends = np.stack([edge.points, edge.points + shift])
    weights = np.stack([edge.weights, edge.weights])
    if edge.degrees != (0,):
        return Nurbs((1, *edge.degrees), (LINEAR, *edge.knots), ends, weights)
    curve = Nurbs((1,), (LINEAR,), ends[:, 0], weights[:, 0])
    inwards = patch.middle().position[:, 0] - edge.points[0]
    to_the_right = area_vector(shift)
    return curve if to_the_right @ inwards > 0 else curve.reversed()
