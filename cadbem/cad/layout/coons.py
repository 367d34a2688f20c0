"""Planar regions as NURBS patches whose edges are the given curves exactly.

A Coons patch formed on homogeneous control points (Farin, *Curves and Surfaces for CAGD*,
section 22) is rational, has the four curves as its edges, and lies in the plane of the curves.
"""

from __future__ import annotations

import numpy as np

from cadbem.spline.basis import Array, greville, multiplicities
from cadbem.spline.nurbs import Nurbs

SLIVER = 1e-2  # share of a side between joints of opposite sides that are taken for one


def coons_patch(curves: list[Nurbs]) -> Nurbs:
    """The patch inside four curves that follow each other round the loop.

    Raises ValueError if a weight comes out non-positive (edges too strongly curved).
    """
    edges = [_with_unit_end_weights(curve) for curve in curves]
    bottom, top = _compatible(edges[0], edges[2].reversed())
    right, left = _compatible(edges[1], edges[3].reversed())
    xi = greville(bottom.degrees[0], bottom.knots[0])[:, None, None]
    eta = greville(left.degrees[0], left.knots[0])[None, :, None]
    south, north = bottom.homogeneous[:, None], top.homogeneous[:, None]
    west, east = left.homogeneous[None], right.homogeneous[None]
    between = (1 - eta) * south + eta * north + (1 - xi) * west + xi * east
    corners = (1 - eta) * ((1 - xi) * south[:1] + xi * south[-1:]) + eta * (
        (1 - xi) * north[:1] + xi * north[-1:]
    )
    degrees = (bottom.degrees[0], left.degrees[0])
    control = between - corners
    if control[..., -1].min() <= 0:
        raise ValueError("weights vanish inside the Coons patch")
    return Nurbs.from_homogeneous(degrees, (bottom.knots[0], left.knots[0]), control)


def segment(start: Array, end: Array) -> Nurbs:
    """The straight line between two points."""
    return Nurbs((1,), (np.array([0.0, 0.0, 1.0, 1.0]),), np.array([start, end]), np.ones(2))


def joined(first: Nurbs, second: Nurbs) -> Nurbs:
    """One curve along two that follow each other, its parameter about the length."""
    degree = max(first.degrees[0], second.degrees[0])
    first, second = first.elevated((degree,)), second.elevated((degree,))
    lengths = [np.linalg.norm(np.diff(c.points, axis=0), axis=1).sum() for c in (first, second)]
    scaled = []
    for curve, length in zip((first, second), lengths, strict=True):
        low, high = curve.domain[0]
        scaled.append((curve.knots[0] - low) * (length / (high - low)))
    knots = np.concatenate([scaled[0][:-1], scaled[1][degree + 1 :] + lengths[0]])
    factor = first.weights[-1] / second.weights[0]
    points = np.concatenate([first.points, second.points[1:]])
    weights = np.concatenate([first.weights, factor * second.weights[1:]])
    return Nurbs((degree,), (knots,), points, weights)


def _with_unit_end_weights(curve: Nurbs) -> Nurbs:
    """Domain [0, 1] and weight 1 at both ends, by a linear rational change of parameter.

    With t = c s / (1 + (c - 1) s) the control point of knots s_1 ... s_p is multiplied by
    Π (1 + (c - 1) s_j), as its blossom says.
    """
    degree, knots = curve.degrees[0], curve.knots[0]
    knots = (knots - knots[0]) / (knots[-1] - knots[0])
    homogeneous = curve.homogeneous / curve.weights[0]
    ratio = homogeneous[-1, -1]
    if abs(ratio - 1) > 1e-14:
        factor = ratio ** (-1 / degree)
        knots = knots / (factor - (factor - 1) * knots)
        scales = [
            np.prod(1 + (factor - 1) * knots[i + 1 : i + degree + 1])
            for i in range(len(homogeneous))
        ]
        homogeneous = homogeneous * np.array(scales)[:, None]
    return Nurbs.from_homogeneous((degree,), (knots,), homogeneous)


def _compatible(first: Nurbs, second: Nurbs) -> tuple[Nurbs, Nurbs]:
    """Two curves on the same degree and knots."""
    degree = max(first.degrees[0], second.degrees[0])
    first, second = first.elevated((degree,)), second.elevated((degree,))
    second = _snapped_to(second, first)
    return _enriched(first, second), _enriched(second, first)


def _snapped_to(curve: Nurbs, other: Nurbs) -> Nurbs:
    """Joints close to one of the other curve's moved there, together with the knots between: each
    piece keeps its shape, and no sliver comes to lie between two joints. Domains are [0, 1]."""
    own, wanted = (_joints(c) for c in (curve, other))
    knots = np.interp(curve.knots[0], own, snapped(own, wanted))
    close = other.knots[0][np.argmin(np.abs(knots[:, None] - other.knots[0]), axis=1)]
    knots = np.where(np.abs(close - knots) < 1e-9, close, knots)  # the same up to rounding
    return Nurbs(curve.degrees, (knots,), curve.points, curve.weights)


def snapped(own: Array, wanted: Array) -> Array:
    """Rising shares of a side moved to nearly equal ones of the opposite side, unless two meet."""
    nearest = wanted[np.argmin(np.abs(own[:, None] - wanted), axis=1)]
    target = np.where(np.abs(nearest - own) < SLIVER, nearest, own)
    return own if (np.diff(target) <= 0).any() else target


def _joints(curve: Nurbs) -> Array:
    """Ends of a curve, and knots between at which its pieces only meet."""
    values, counts = multiplicities(curve.knots[0])
    return values[counts >= curve.degrees[0]]


def _enriched(curve: Nurbs, other: Nurbs) -> Nurbs:
    own = dict(zip(*multiplicities(curve.knots[0]), strict=True))
    missing = [
        value
        for value, count in zip(*multiplicities(other.knots[0]), strict=True)
        for _ in range(count - own.get(value, 0))
    ]
    return curve.inserted((missing,))
