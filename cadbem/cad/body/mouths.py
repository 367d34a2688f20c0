"""Mouths of rooms in a solid: rings of edges round which a wall goes into the material.

A hole in a face is a mouth if the faces beyond its edges lie behind it; a stub's base, whose wall
rises, is none. Plane faces that continue each other count as one. A full circle of edges between
other faces is a mouth if a bore begins behind it and the face around goes outwards without
rising, as at the tip of a needle. A mouth is capped by a face of its own: a plane one, or, where
its edges lie in no plane, a piece of the surface that it is a hole in.
"""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from cadbem.cad.body.edge_rings import EdgeRing, Pass, circles, holes
from cadbem.cad.faces.evaluate import KernelSurface
from cadbem.cad.faces.face_geometry import (
    edge_points,
    parameter_box,
    parameter_curves,
    plane_of,
    points_on,
    real_uses,
    size_of,
)
from cadbem.cad.faces.wraps import filled, parameter_loop
from cadbem.cad.kernel.brep import BrepFace, EdgeUse
from cadbem.cad.kernel.brep_geometry import PLANE, SurfaceRecord
from cadbem.spline.basis import Array

SAME = 1e-6  # distance, per size of the model, within which planes and corners are the same
INWARDS = -0.5  # cosine between a bore's normal and the way from its axis below which it is a bore


@dataclass(frozen=True, eq=False)
class Mouth:
    """A ring of edges: indices of the faces around it and of those beyond, the face that caps it
    (normal out of the material, number 0), its middle (3,) and its diameter, mm."""

    hosts: frozenset[int]
    walls: frozenset[int]
    keys: frozenset[tuple]
    cap: BrepFace
    middle: Array
    diameter: float

    def holds(self, point: Array) -> bool:
        """Whether a point (3,) lies in the ball round the mouth."""
        return float(np.linalg.norm(point - self.middle)) <= 0.5 * self.diameter * (1 + SAME)


def find_mouths(faces: Sequence[BrepFace]) -> list[Mouth]:
    """All mouths in the faces of solids, whose normals point out of the material."""
    at_edge = faces_at_edges(faces)
    near = SAME * size_of(*faces)
    found = (_hole(faces, *hole, at_edge, near) for hole in holes(faces, at_edge, near))
    mouths = [mouth for mouth in found if mouth is not None]
    known = {key for mouth in mouths for key in mouth.keys}
    for ring in circles(faces, at_edge, near):
        mouth = None if ring.keys & known else _bore(faces, ring, at_edge, near)
        mouths += [mouth] if mouth is not None else []
    return mouths


def rings_round(faces: Sequence[BrepFace], point: Array) -> list[Mouth]:
    """All full circles of edges that hold a point (3,), as mouths, the nearest first."""
    at_edge = faces_at_edges(faces)
    near = SAME * size_of(*faces)
    found = [
        _capped(faces, ring, _sides(faces, ring, at_edge)[0], at_edge, near)
        for ring in circles(faces, at_edge, near)
    ]
    around = [mouth for mouth in found if mouth is not None and mouth.holds(point)]
    return sorted(around, key=lambda mouth: float(np.linalg.norm(mouth.middle - point)))


def faces_at_edges(faces: Sequence[BrepFace]) -> dict[tuple, list[int]]:
    """Indices of the faces at each edge, by its key; one twice at its seam."""
    at_edge: dict[tuple, list[int]] = defaultdict(list)
    for index, face in enumerate(faces):
        for use in real_uses(face):
            at_edge[use.key].append(index)
    return at_edge


def _hole(
    faces: Sequence[BrepFace],
    group: frozenset[int],
    ring: EdgeRing,
    at_edge: dict[tuple, list[int]],
    near: float,
) -> Mouth | None:
    """A hole in a group of faces, if the faces beyond go into the material."""
    walls = _around(ring, at_edge) - group
    normal = _normal(faces[ring.passes[0].face], ring.passes[0].use)
    if not walls or normal is None:
        return None
    beyond = np.concatenate([edge_points(faces[k]) for k in walls])
    if (beyond - ring.points.mean(axis=0)).mean(axis=0) @ normal >= 0:  # a stub stands there
        return None
    return _capped(faces, ring, group, at_edge, near)


def _bore(
    faces: Sequence[BrepFace], ring: EdgeRing, at_edge: dict[tuple, list[int]], near: float
) -> Mouth | None:
    """A circle between a bore and faces that go outwards from its end, and do not rise."""
    for hosts in _sides(faces, ring, at_edge):
        walls = _around(ring, at_edge) - hosts
        if not hosts or not walls or not _is_bore(faces, ring, walls):
            continue
        axis = ring.normal
        beyond = _rims(faces, walls) - ring.middle
        axis = axis if float(beyond.mean(axis=0) @ axis) < 0 else -axis
        outer = _rims(faces, hosts) - ring.middle
        rise = outer @ axis
        wide = np.linalg.norm(outer - np.multiply.outer(rise, axis), axis=1)
        if rise.max() < near and wide.max() > 0.5 * ring.diameter + near:
            return _capped(faces, ring, hosts, at_edge, near)
    return None


def _is_bore(faces: Sequence[BrepFace], ring: EdgeRing, walls: frozenset[int]) -> bool:
    """Whether normals of the walls, out of the material, point to the middle of the ring."""
    for k in walls:
        for use in real_uses(faces[k]):
            if use.key in ring.keys:
                normal = _normal(faces[k], use)
                arm = _middle(use) - ring.middle
                if normal is None or normal @ arm > INWARDS * np.linalg.norm(arm):
                    return False
    return True


def _rims(faces: Sequence[BrepFace], indices: frozenset[int]) -> Array:
    """Points (n, 3) along edges of faces that are no seams."""
    uses = [use for k in indices for use in real_uses(faces[k])]
    counts = Counter(use.key for use in uses)
    return np.concatenate([points_on(use) for use in uses if counts[use.key] == 1])


def _sides(
    faces: Sequence[BrepFace], ring: EdgeRing, at_edge: dict[tuple, list[int]]
) -> tuple[frozenset[int], frozenset[int]]:
    """The faces on both sides of a circle: those that its axis points to, and the others."""
    first = set()
    for key in ring.keys:
        pair = at_edge[key]
        heights = [float((edge_points(faces[k]) @ ring.normal).mean()) for k in pair]
        first.add(pair[int(np.argmax(heights))])
    return frozenset(first), _around(ring, at_edge) - first


def _around(ring: EdgeRing, at_edge: dict[tuple, list[int]]) -> frozenset[int]:
    return frozenset(k for key in ring.keys for k in at_edge[key])


def _capped(
    faces: Sequence[BrepFace],
    ring: EdgeRing,
    hosts: frozenset[int],
    at_edge: dict[tuple, list[int]],
    near: float,
) -> Mouth | None:
    """The mouth at a ring; None if its edges lie neither in a plane nor in one host."""
    passes = _passes_of(faces, ring, hosts)
    walls = _around(ring, at_edge) - hosts
    if len(passes) != len(ring.keys) or not walls:
        return None
    key = ("cap", *sorted(map(hash, ring.keys)))
    if ring.is_flat(near):
        cap = _plane_cap(faces, passes, ring, key)
    elif len({p.face for p in passes}) == 1:
        lid = _curved_cap(faces[passes[0].face], passes)
        if lid is None:
            return None
        cap = replace(lid, key=key)
    else:
        return None
    return Mouth(hosts, walls, ring.keys, cap, ring.middle, ring.diameter)


def _passes_of(faces: Sequence[BrepFace], ring: EdgeRing, hosts: frozenset[int]) -> list[Pass]:
    """The ring's edges as the hosts pass them, in the order in which they follow each other."""
    of_key = {
        use.key: Pass(k, use) for k in hosts for use in real_uses(faces[k]) if use.key in ring.keys
    }
    passes = [of_key[p.use.key] for p in ring.passes if p.use.key in of_key]
    same = passes and _run(faces, passes[0]) == _run(faces, ring.passes[0])
    return passes if same else passes[::-1]


def _run(faces: Sequence[BrepFace], item: Pass) -> int:
    return item.use.sign * faces[item.face].outward


def _plane_cap(
    faces: Sequence[BrepFace], passes: list[Pass], ring: EdgeRing, key: tuple
) -> BrepFace:
    """A plane face whose border runs against the hosts; its normal continues theirs."""
    around = tuple(replace(p.use, sign=-_run(faces, p)) for p in reversed(passes))
    points = np.concatenate([_in_order(use) for use in around]) - ring.middle
    area = np.cross(points, np.roll(points, -1, axis=0)).sum(axis=0)
    normal = ring.normal * np.sign(area @ ring.normal)
    x = np.cross(normal, np.eye(3)[np.argmin(np.abs(normal))])
    x /= np.linalg.norm(x)
    frame = np.array([ring.middle, normal, x, np.cross(normal, x)])
    return BrepFace(0, 0, SurfaceRecord(PLANE, frame), np.eye(4), 1, (around,), key)


def _curved_cap(host: BrepFace, passes: list[Pass]) -> BrepFace | None:
    """The piece of the host's surface in its hole."""
    around = [item.use for item in (passes if host.outward > 0 else passes[::-1])]
    loop = parameter_loop(host, around)
    return filled(host, loop) if loop is not None else None


def _in_order(use: EdgeUse) -> Array:
    points = points_on(use)
    return points if use.sign > 0 else points[::-1]



def _middle(use: EdgeUse) -> Array:
    points = points_on(use)
    return points[len(points) // 2]


def _normal(host: BrepFace, use: EdgeUse) -> Array | None:
    """The face's normal out of the material, at the middle of one of its edges."""
    if host.surface.kind == PLANE:
        normal = np.cross(*plane_of(host)[1])
    else:
        box = parameter_box(host)
        if box is None:
            return None
        uses = [u for loop in host.loops for u in loop]
        curve = parameter_curves(host)[next(k for k, u in enumerate(uses) if u is use)]
        at = curve.evaluate(np.array([np.mean(curve.domain[0])]))
        surface = KernelSurface(host.surface, *box, host.matrix)
        _, along_u, along_v = surface.frames(*at)
        normal = np.cross(along_u[:, 0], along_v[:, 0])
    return host.outward * normal / np.linalg.norm(normal)
