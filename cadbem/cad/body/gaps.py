"""Gaps: the distances of patches from the edges that their faces share."""

from __future__ import annotations

import numpy as np

from cadbem.boundary import Patch
from cadbem.spline.basis import Array
from cadbem.spline.nurbs import Nurbs


def largest_distance(points: Array, patches: list[Patch]) -> float:
    """Largest distance from points (3, k) to the nearest border of the patches."""
    borders = [border for patch in patches for border in _borders(patch.surface)]
    return float(np.min([_distances(points, border) for border in borders], axis=0).max())


def _borders(surface: Nurbs) -> list[Nurbs]:
    """The four edge curves of a patch; those that are a point are left out."""
    curves = []
    for turned in (surface, surface.swapped()):
        for row in (0, -1):
            points, weights = turned.points[row], turned.weights[row]
            if np.ptp(points, axis=0).max() > 1e-12 * np.ptp(surface.points):
                curves.append(Nurbs(turned.degrees[1:], turned.knots[1:], points, weights))
    return curves


def _distances(points: Array, curve: Nurbs) -> Array:
    """Distance of each point from the curve: nearest sample, then Newton's method."""
    low, high = curve.domain[0]
    samples = np.linspace(low, high, 33)
    squares = ((points[:, :, None] - curve.evaluate(samples)[:, None]) ** 2).sum(axis=0)
    t = samples[squares.argmin(axis=1)]
    for _ in range(6):
        derivatives = curve.derivatives(2, t)
        offset, speed = derivatives[(0,)] - points, derivatives[(1,)]
        slope = (speed**2).sum(axis=0) + (offset * derivatives[(2,)]).sum(axis=0)
        step = (offset * speed).sum(axis=0) / np.where(slope > 0, slope, np.inf)
        t = np.clip(t - step, low, high)
    return np.linalg.norm(curve.evaluate(t) - points, axis=0)
