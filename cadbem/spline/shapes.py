"""Exact shapes: boxes for now."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from cadbem.spline.nurbs import Nurbs


def parallelogram(corner: ArrayLike, first: ArrayLike, second: ArrayLike) -> Nurbs:
    """Bilinear patch from a corner along two vectors (3,); its normal is first × second."""
    o, a, b = (np.asarray(v, dtype=float) for v in (corner, first, second))
    knots = np.array([0.0, 0.0, 1.0, 1.0])
    points = np.array([[o, o + b], [o + a, o + a + b]])
    return Nurbs((1, 1), (knots, knots), points, np.ones((2, 2)))


def box(
    low: Sequence[float] = (0.0, 0.0, 0.0), high: Sequence[float] = (1.0, 1.0, 1.0)
) -> tuple[Nurbs, ...]:
    """The six sides of a box, normals inwards: low and high x, low and high y, low and high z."""
    start, end = np.asarray(low, dtype=float), np.asarray(high, dtype=float)
    edges = np.diag(end - start)
    sides = []
    for axis in range(3):
        first, second = edges[(axis + 1) % 3], edges[(axis + 2) % 3]
        sides.append(parallelogram(start, first, second))
        sides.append(parallelogram(end, -second, -first))
    return tuple(sides)
