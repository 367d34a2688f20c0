"""Largest and smallest distance of a closed curve or surface from a point, to full precision.

The surface is a smooth image of the unit circle or sphere, also over the poles, where its
parameters are not.  The search therefore moves a unit vector: Newton's method in its tangent plane
with differences of the distance, from many local extremes on a grid at once.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache

import numpy as np

from cadbem.closed_points import ClosedGrid
from cadbem.spline.basis import Array
from cadbem.spline.closed import ClosedBasis, ClosedSpline, unit_parameters, unit_point
from cadbem.suspension.interface.mesh import neighbours

CANDIDATES = 24  # local extremes on the grid that are followed up
REFINEMENT = 4  # grid points per collocation point and direction
STEP = 1e-4  # of differences, in radians: rounding leaves 1e-12 in slopes and 1e-8 in bends
FLATTEST = 1e-6  # bend, relative to the distance squared, below which a direction counts as flat
ENOUGH = 1e-13  # gain of height expected from a step that is the last; Newton's next is far less
NOISE = 1e-14  # loss of height that a step may make by rounding
ITERATIONS = 20

Height = Callable[[Array], Array]


def extreme_distances(spline: ClosedSpline, centre: Array) -> tuple[float, float, Array]:
    """Largest and smallest distance from ``centre`` (dim,), and unit vectors (2, dim) to there.

    Where several points are as far, the one at the largest x is taken.
    """
    arms = np.stack([_furthest(spline, centre, sign) for sign in (1.0, -1.0)])
    lengths = np.linalg.norm(arms, axis=1)
    return float(lengths[0]), float(lengths[1]), arms / lengths[:, None]


def _furthest(spline: ClosedSpline, centre: Array, sign: float) -> Array:
    """From the centre to the point where sign × distance is largest (dim,)."""
    unit = _starts(spline, centre, sign)
    scale = float((_arms(spline, centre, unit) ** 2).sum(axis=0).mean())

    def height(at: Array) -> Array:
        return sign / scale * (_arms(spline, centre, at) ** 2).sum(axis=0)

    now = height(unit)
    reach = np.full(unit.shape[1], np.pi / (REFINEMENT * min(spline.basis.shape)))
    for _ in range(ITERATIONS):
        step, gain = _uphill(height, unit)
        length = np.linalg.norm(step, axis=0)
        step = step * np.minimum(1.0, reach / np.maximum(length, 1e-300))
        moved = _normalised(unit + step)
        then = height(moved)
        better = then > now - NOISE
        unit, now = np.where(better, moved, unit), np.where(better, then, now)
        reach = np.where(better, reach, np.minimum(reach, length) / 4)
        if gain.max() < ENOUGH:
            break
    arms = _arms(spline, centre, unit)
    best = arms[:, now > now.max() - 10 * NOISE]
    return best[:, int(best[0].argmax())]


def _arms(spline: ClosedSpline, centre: Array, unit: Array) -> Array:
    """From the centre to the images (dim, K) of unit vectors (dim, K)."""
    return spline.evaluate(unit_parameters(unit)) - centre[:, None]


def _normalised(vectors: Array) -> Array:
    return vectors / np.linalg.norm(vectors, axis=0)


@lru_cache(maxsize=8)
def _start_grid(basis: ClosedBasis) -> ClosedGrid:
    return ClosedGrid(basis, basis.refined(REFINEMENT).axes())


def _starts(spline: ClosedSpline, centre: Array, sign: float) -> Array:
    """The highest local extremes on a grid, as unit vectors (dim, K)."""
    fine = spline.basis.refined(REFINEMENT)
    arms = _start_grid(spline.basis).values(spline.coefficients) - centre[:, None]
    height = sign * (arms**2).sum(axis=0).reshape(fine.shape)
    around = np.stack(neighbours(fine, height)).max(axis=0)
    peaks = np.flatnonzero(height >= around)
    order = np.argsort(-height.ravel()[peaks])[:CANDIDATES]
    return unit_point(*fine.parameters()[:, peaks[order]])


def _uphill(height: Height, unit: Array) -> tuple[Array, Array]:
    """Newton's step (dim, K) towards a maximum, in the tangent planes of unit vectors, and the
    gain (K,) expected from it.

    The sign of bends does not count, so that saddles repel.
    """
    frame = _tangent_frame(unit)
    slope, bend = _differences(height, unit, frame)
    values, vectors = np.linalg.eigh(bend)
    along = np.einsum("kab,ka->kb", vectors, slope)
    step = along / np.maximum(np.abs(values), FLATTEST)
    return np.einsum("adk,kab,kb->dk", frame, vectors, step), 0.5 * (along * step).sum(axis=1)


def _tangent_frame(unit: Array) -> Array:
    """Orthonormal vectors (dim - 1, dim, K) across unit vectors (dim, K)."""
    if len(unit) == 2:
        return np.stack([-unit[1], unit[0]])[None]
    aside = np.eye(3)[:, np.abs(unit).argmin(axis=0)]
    first = _normalised(np.cross(unit, aside, axis=0))
    return np.stack([first, np.cross(unit, first, axis=0)])


def _differences(height: Height, unit: Array, frame: Array) -> tuple[Array, Array]:
    """Slopes (K, p) and bends (K, p, p) of a function, from the polynomial of degree two that
    fits it best on 3^p points."""
    p, count = len(frame), unit.shape[1]
    offsets = np.stack([g.ravel() for g in np.meshgrid(*[np.arange(-1.0, 2.0)] * p)])
    spread = unit[:, None] + STEP * np.einsum("am,adk->dmk", offsets, frame)
    around = height(_normalised(spread.reshape(len(unit), -1))).reshape(-1, count)
    pairs = [(a, b) for a in range(p) for b in range(a, p)]
    products = [offsets[a] * offsets[b] for a, b in pairs]
    powers = np.stack([np.ones(3**p), *offsets, *products], axis=1)
    fit = np.linalg.pinv(powers) @ around
    bend = np.zeros((count, p, p))
    for (a, b), value in zip(pairs, fit[p + 1 :], strict=True):
        bend[:, a, b] += value / STEP**2
        bend[:, b, a] += value / STEP**2
    return fit[1 : p + 1].T / STEP, bend
