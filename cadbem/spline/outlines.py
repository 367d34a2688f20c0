"""Exact plane curves: lines, ellipses and rectangles.

The normal of a curve is to the right of its direction.  As with solid shapes, normals of
rectangles point inwards and those of bodies outwards, unless ``inwards`` turns them.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from cadbem.spline.nurbs import Nurbs

HALF = np.sqrt(0.5)
QUARTER = np.array([[1, 0, 1], [HALF, HALF, HALF], [0, 1, 1]])  # (w x, w y, w), radius 1


def line(start: ArrayLike, end: ArrayLike) -> Nurbs:
    """Straight segment between two points (2,)."""
    points = np.array([start, end], dtype=float)
    return Nurbs((1,), (np.array([0.0, 0.0, 1.0, 1.0]),), points, np.ones(2))


def ellipse(
    semi_axes: ArrayLike, centre: ArrayLike = (0.0, 0.0), *, inwards: bool = False
) -> tuple[Nurbs, ...]:
    """Four arcs from (a, 0) on, counter-clockwise, clockwise with normals ``inwards``."""
    arc = Nurbs.from_homogeneous((2,), (np.repeat([0.0, 1.0], 3),), QUARTER)
    size = np.diag(np.asarray(semi_axes, dtype=float))
    cosines = np.array([1.0, 0.0, -1.0, 0.0])
    arcs = []
    for cosine, sine in zip(cosines, np.roll(cosines, 1), strict=True):
        turn = np.array([[cosine, -sine], [sine, cosine]])
        arcs.append(arc.transformed(size @ turn, centre))
    return tuple(a.reversed() for a in reversed(arcs)) if inwards else tuple(arcs)


def circle(
    radius: float = 1.0, centre: ArrayLike = (0.0, 0.0), *, inwards: bool = False
) -> tuple[Nurbs, ...]:
    """Four quarters of a circle, as ``ellipse``."""
    return ellipse((radius, radius), centre, inwards=inwards)


def rectangle(low: ArrayLike = (0.0, 0.0), high: ArrayLike = (1.0, 1.0)) -> tuple[Nurbs, ...]:
    """Four sides, normals inwards: low and high x, low and high y."""
    (left, bottom), (right, top) = np.asarray(low, dtype=float), np.asarray(high, dtype=float)
    return (
        line((left, bottom), (left, top)),
        line((right, top), (right, bottom)),
        line((right, bottom), (left, bottom)),
        line((left, top), (right, top)),
    )
