"""Plane curves joined to closed rings, and rings to regions."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from cadbem.boundary import Boundary, Patch
from cadbem.spline.basis import Array
from cadbem.spline.nurbs import Nurbs

Ring = tuple[Patch, ...]
SAMPLES = 33  # points on a curve, for asking what lies inside


def rings(patches: list[Patch], near: float) -> tuple[list[Ring], float, Array | None]:
    """Closed rings of curves that follow each other, the largest distance of ends that meet, and
    an end (2,) that has no other one `near`."""
    ends = np.array([patch.surface.points[[0, -1]] for patch in patches])
    left = set(range(len(patches)))
    found: list[Ring] = []
    gap = 0.0
    while left:
        index, backwards = min(left), 0
        start, ring = ends[index, 0], []
        while True:
            left.remove(index)
            patch = patches[index]
            turned = replace(patch, surface=patch.surface.reversed())
            ring.append(turned if backwards else patch)
            end = ends[index, 1 - backwards]
            following = [2 * k + side for k in left for side in (0, 1)]
            gaps = np.linalg.norm(ends.reshape(-1, 2)[following] - end, axis=1)
            closing = float(np.linalg.norm(end - start))
            if closing <= min(near, gaps.min(initial=np.inf)):
                gap = max(gap, closing)
                break
            if gaps.min(initial=np.inf) > near:
                return found, gap, end
            gap = max(gap, float(gaps.min()))
            index, backwards = divmod(following[int(np.argmin(gaps))], 2)
        found.append(tuple(ring))
    return found, gap, None


def regions(loops: list[Ring]) -> list[Ring]:
    """Rings with the holes in them, the fluid to the right of each curve; the largest first."""
    borders = [_polygon(ring) for ring in loops]
    inside = np.array(
        [[i != j and crossings(outer, border[:, 0]) % 2 == 1 for j, outer in enumerate(borders)]
         for i, border in enumerate(borders)]
    ).reshape(len(loops), -1)  # fmt: skip
    depths = inside.sum(axis=1)
    found = []
    for i in np.flatnonzero(depths % 2 == 0):
        holes = np.flatnonzero(inside[:, i] & (depths == depths[i] + 1))
        turned = [_turned(loops[i], 1), *(_turned(loops[j], -1) for j in holes)]
        found.append(tuple(patch for ring in turned for patch in ring))
    return sorted(found, key=lambda ring: -Boundary(ring).volume())


def _turned(ring: Ring, sign: int) -> Ring:
    """A ring run through so that it encloses a positive or negative area of fluid."""
    if Boundary(ring).volume() * sign > 0:
        return ring
    return Boundary(ring).turned().patches[::-1]


def _polygon(ring: Ring) -> Array:
    """Points (2, n) along the ring, the first once more at the end."""
    parts = [polyline(patch.surface) for patch in ring]
    return np.concatenate([*parts, parts[0][:, :1]], axis=1)


def polyline(curve: Nurbs) -> Array:
    """Points (2, n) along a plane curve, ends included."""
    breaks = curve.breaks(0)
    inside = np.linspace(breaks[:-1], breaks[1:], SAMPLES, endpoint=False).T.ravel()
    return curve.evaluate(np.append(inside, breaks[-1]))


def crossings(points: Array, place: Array) -> int:
    """The number of times that a ray from a point (2,) along x meets the line through points (2,
    n)."""
    arms = points - place[:, None]
    a, b = arms[:, :-1], arms[:, 1:]
    crosses = (a[1] > 0) != (b[1] > 0)
    a, b = a[:, crosses], b[:, crosses]
    return int((a[0] - a[1] * (b[0] - a[0]) / (b[1] - a[1]) > 0).sum())
