"""Exact shapes: boxes, cylinders, spheres and ellipsoids.

Normals of boxes and cylinders point inwards, those of bodies outwards: into the fluid that one
expects there.  Wherever the fluid is on the other side, ``inwards`` turns a body's normals.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product
from math import comb

import numpy as np
from numpy.typing import ArrayLike

from cadbem.checks import finite, positive, positive_array, shaped, whole
from cadbem.errors import InputError
from cadbem.spline.basis import Array
from cadbem.spline.nurbs import Nurbs

Vector = Sequence[float] | Array
Origin = (0.0, 0.0, 0.0)
HALF = np.sqrt(0.5)
ARC = np.array([[1, 0, 1], [HALF, HALF, HALF], [0, 1, 1]])  # quarter circle: (w x, w y, w)


def parallelogram(corner: ArrayLike, first: ArrayLike, second: ArrayLike) -> Nurbs:
    """Bilinear patch from a corner along two vectors (3,); its normal is first × second."""
    o, a, b = (np.asarray(v, dtype=float) for v in (corner, first, second))
    knots = np.array([0.0, 0.0, 1.0, 1.0])
    points = np.array([[o, o + b], [o + a, o + a + b]])
    return Nurbs((1, 1), (knots, knots), points, np.ones((2, 2)))


def box(low: Vector = Origin, high: Vector = (1.0, 1.0, 1.0)) -> tuple[Nurbs, ...]:
    """The six sides of a box, normals inwards: low and high x, low and high y, low and high z."""
    start, end = shaped("low", low, 3), shaped("high", high, 3)
    positive_array("high - low", end - start, 3)
    edges = np.diag(end - start)
    sides = []
    for axis in range(3):
        first, second = edges[(axis + 1) % 3], edges[(axis + 2) % 3]
        sides.append(parallelogram(start, first, second))
        sides.append(parallelogram(end, -second, -first))
    return tuple(sides)


def cylinder(radius: float = 1.0, length: float = 1.0, start: Vector = Origin) -> tuple[Nurbs, ...]:
    """The round side of a cylinder along x from ``start``, in four quarters; normals inwards."""
    positive("radius", radius)
    positive("length", length)
    shaped("start", start, 3)
    net = np.zeros((2, 3, 4))
    net[:, :, 1], net[:, :, 2], net[:, :, 3] = ARC[:, 0], ARC[:, 1], ARC[:, 2]
    net[1, :, 0] = ARC[:, 2]
    quarter = _bezier(net)
    size = np.diag([length, radius, radius])
    return tuple(quarter.transformed(size @ _turn(0, k), start) for k in range(4))


def sphere(
    radius: float = 1.0, centre: Vector = Origin, *, inwards: bool = False
) -> tuple[Nurbs, ...]:
    """A sphere without poles: six biquartic patches, the faces of a blown-up cube."""
    positive("radius", radius)
    return ellipsoid((radius,) * 3, centre, inwards=inwards)


def ellipsoid(
    semi_axes: Vector, centre: Vector = Origin, *, inwards: bool = False
) -> tuple[Nurbs, ...]:
    """An ellipsoid as affine image of the six patches of ``sphere``; semi-axes along x, y, z."""
    face = _cube_face()
    turns = [_turn(0, k) for k in range(4)] + [_turn(1, 1), _turn(1, 3)]
    return _placed([face.transformed(t) for t in turns], semi_axes, centre, inwards)


def sphere_octants(
    radius: float = 1.0, centre: Vector = Origin, *, inwards: bool = False
) -> tuple[Nurbs, ...]:
    """A sphere of eight biquadratic patches; one edge of each shrinks to a pole on the z axis."""
    positive("radius", radius)
    octant = _bezier(_revolved(ARC, ARC))
    patches = []
    for k, south in product(range(4), (False, True)):
        patch = octant.transformed(_turn(2, k))
        # the mirror image has its normals inwards, hence the exchange of parameters
        mirrored = patch.transformed(np.diag([1.0, 1.0, -1.0])).swapped()
        patches.append(mirrored if south else patch)
    return _placed(patches, (radius,) * 3, centre, inwards)


def sphere_with_poles(
    radius: float = 1.0, centre: Vector = Origin, *, inwards: bool = False
) -> tuple[Nurbs, ...]:
    """A sphere as one patch: four arcs around the z axis from a seam to itself, two from pole
    to pole."""
    positive("radius", radius)
    quarters = [ARC @ _turn(2, k).T for k in range(4)]
    around = np.concatenate([q[:2] for q in quarters] + [ARC[:1]])
    meridian = np.concatenate([np.flip(ARC[1:] * [1, -1, 1], 0), ARC])
    knots = [np.repeat(np.arange(n + 1.0), [3] + [2] * (n - 1) + [3]) for n in (4, 2)]
    patch = Nurbs.from_homogeneous((2, 2), tuple(knots), _revolved(around, meridian))
    return _placed([patch], (radius,) * 3, centre, inwards)


def plate(
    middle: float, side: float, *, degree: int = 3, spans: int = 4, rings: int = 9
) -> tuple[Nurbs, ...]:
    """The square |x|, |y| < side / 2 in the plane z = 0, normal up, with elements that are small
    in its ``middle`` and grow outwards.

    A square of side ``middle`` with ``spans`` elements a side, and four trapezoids around it
    with ``rings`` elements outwards, whose lengths are a geometric series.
    """
    positive("middle", middle)
    if not finite("side", side) > middle:
        raise InputError(f"side is {side}; give a finite number above the middle's {middle}")
    for name, value in (("degree", degree), ("spans", spans), ("rings", rings)):
        whole(name, value)
    growth, across = side / middle, np.linspace(0, 1, spans + 1)[1:-1]
    outwards = (growth ** (np.arange(1, rings) / rings) - 1) / (growth - 1)
    square = parallelogram((-middle / 2, -middle / 2, 0), (middle, 0, 0), (0, middle, 0))
    patches = [square.elevated((degree, degree)).inserted([across, across])]
    start, end = square.points[0, 0], square.points[0, 1]
    for k in range(4):
        # going out and then along x = -middle / 2 downwards, or a turn of that, keeps normals up
        net = np.array([[end, start], [growth * end, growth * start]]) @ _turn(2, k).T
        trapezoid = Nurbs((1, 1), square.knots, net, np.ones((2, 2)))
        patches.append(trapezoid.elevated((degree, degree)).inserted([outwards, across]))
    return tuple(patches)


def _revolved(around: Array, meridian: Array) -> Array:
    """Homogeneous net of points (x, y, w) of a circle times (r, z, w) of a half circle."""
    x, y, w = around.T[:, :, None]
    r, z, v = meridian.T[:, None, :]
    return np.stack([x * r, y * r, w * z, w * v], axis=-1)


def _cube_face() -> Nurbs:
    """The face of the unit sphere around +z over |x|, |y| <= z (Cobb 1988).

    Seen from the south pole (stereographic projection) its great circles are arcs of radius √2
    about (∓1, 0) and (0, ∓1) that span 30 degrees, so that the face is a rational biquadratic
    patch (X, Y, W) of the plane.  Back on the sphere, (2XW, 2YW, W² - X² - Y², W² + X² + Y²)
    is biquartic, and lies on the sphere wherever the middle control point is.
    """
    corner, cosine = 1 / (1 + np.sqrt(3)), (np.sqrt(6) + np.sqrt(2)) / 4
    side = np.sqrt(2) - cosine
    plane = np.zeros((3, 3, 3))
    plane[..., 2] = [[1, cosine, 1], [cosine, cosine**2, cosine], [1, cosine, 1]]
    for i, j in product((0, 2), repeat=2):
        plane[i, j, :2] = corner * (i - 1), corner * (j - 1)
    for i in (0, 2):
        plane[i, 1, 0] = plane[1, i, 1] = side * (i - 1)
    x, y, w = np.moveaxis(plane, -1, 0)
    square = _product(x, x) + _product(y, y)
    parts = [2 * _product(x, w), 2 * _product(y, w), _product(w, w) - square]
    return _bezier(np.stack([*parts, _product(w, w) + square], axis=-1))


def _product(f: Array, g: Array) -> Array:
    """Bézier coefficients of the product of two biquadratic polynomials."""
    result = np.zeros((5, 5))
    scale = np.array([[comb(2, i) * comb(2, j) for j in range(3)] for i in range(3)])
    for i, j in product(range(3), repeat=2):
        result[i : i + 3, j : j + 3] += scale[i, j] * f[i, j] * scale * g
    return result / [[comb(4, i) * comb(4, j) for j in range(5)] for i in range(5)]


def _bezier(homogeneous: Array) -> Nurbs:
    degrees = homogeneous.shape[0] - 1, homogeneous.shape[1] - 1
    knots = tuple(np.repeat([0.0, 1.0], p + 1) for p in degrees)
    return Nurbs.from_homogeneous(degrees, knots, homogeneous)


def _turn(axis: int, quarters: int) -> Array:
    """Rotation by quarters of a turn about an axis, exact."""
    a, b = (axis + 1) % 3, (axis + 2) % 3
    cosine, sine = ((1, 0), (0, 1), (-1, 0), (0, -1))[quarters]
    matrix = np.eye(3)
    matrix[a, a] = matrix[b, b] = cosine
    matrix[b, a], matrix[a, b] = sine, -sine
    return matrix


def _placed(
    patches: Sequence[Nurbs], semi_axes: Vector, centre: Vector, inwards: bool
) -> tuple[Nurbs, ...]:
    """Patches of the unit sphere, normals outwards, stretched, moved and turned."""
    size = np.diag(positive_array("semi_axes", semi_axes, 3))
    middle = shaped("centre", centre, 3)
    placed = [p.transformed(size, middle) for p in patches]
    return tuple(p.swapped() for p in placed) if inwards else tuple(placed)
