"""Exact shapes that several tests use."""

import numpy as np

from cadbem.boundary import Boundary, Patch
from cadbem.spline import Nurbs
from cadbem.spline.shapes import box

HALF = np.sqrt(0.5)
LINEAR = np.array([0, 0, 1, 1.0])
QUADRATIC = np.array([0, 0, 0, 1, 1, 1.0])
ARC = np.array([[1, 0], [1, 1], [0, 1.0]])
ARC_WEIGHTS = np.array([1, HALF, 1])


def quarter_cylinder() -> Nurbs:
    """Radius 1 about the y axis, x and z positive, y from 0 to 2."""
    rim = np.insert(ARC, 1, 0.0, axis=1)
    points = np.stack([rim, rim + [0, 2.0, 0]], axis=1)
    return Nurbs((2, 1), (QUADRATIC, LINEAR), points, np.outer(ARC_WEIGHTS, [1, 1]))


def octant(signs=(1, 1, 1)) -> Nurbs:
    """Eighth of the unit sphere, with a pole where one edge shrinks to a point."""
    points = np.empty((3, 3, 3))
    for i, j in np.ndindex(3, 3):
        points[i, j] = [ARC[i, 0] * ARC[j, 0], ARC[i, 1] * ARC[j, 0], ARC[j, 1]]
    surface = Nurbs((2, 2), (QUADRATIC,) * 2, points, np.outer(ARC_WEIGHTS, ARC_WEIGHTS))
    return surface.transformed(np.diag(signs).astype(float))


def unit_square() -> Nurbs:
    """The square 0 < x, y < 1 in the plane z = 0."""
    points = np.array([[[0, 0, 0], [0, 1, 0]], [[1, 0, 0], [1, 1, 0.0]]])
    return Nurbs((1, 1), (LINEAR, LINEAR), points, np.ones((2, 2)))


def channel(low=(-1, -0.5, -0.5), high=(1, 0.5, 0.5)) -> Boundary:
    """A box whose flow goes along x."""
    names = ("inlet", "outlet", "walls", "walls", "walls", "walls")
    sides = zip(box(low, high), names, strict=True)
    return Boundary(tuple(Patch(s, n, i + 1) for i, (s, n) in enumerate(sides)))


def bulged() -> Boundary:
    """A closed surface of six patches that bulge, meeting in sharp edges; normals inwards.

    Each side of the box [-1, 1]³ is raised to degree 2 and its middle control point moved out.
    """
    patches = []
    for i, side in enumerate(box((-1, -1, -1), (1, 1, 1))):
        curved = side.elevated((2, 2))
        points = curved.points.copy()
        points[1, 1] *= 1.7
        surface = Nurbs(curved.degrees, curved.knots, points, curved.weights)
        patches.append(Patch(surface, "", i + 1))
    return Boundary(tuple(patches))
