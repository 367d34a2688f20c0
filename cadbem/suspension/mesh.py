"""Mesh quality of closed splines, and its repair without changing the shape."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from cadbem.closed_points import ClosedGrid, ClosedPoints
from cadbem.spline.basis import Array
from cadbem.spline.closed import ClosedBasis, ClosedSpline

STABLE = 0.5  # share of the way to its neighbours' mean that a point may go in a pseudo-step


def stretches(points: ClosedPoints) -> tuple[Array, Array]:
    """Smallest and largest stretch (N,) of the unit circle or sphere at each point."""
    if len(points.tangents) == 1:
        return points.jacobian, points.jacobian
    south, east = points.tangents[0], points.tangents[1] / points.grid.measure
    e, f, g = (south**2).sum(axis=0), (south * east).sum(axis=0), (east**2).sum(axis=0)
    middle, radius = (e + g) / 2, np.hypot((e - g) / 2, f)
    return np.sqrt(np.maximum(middle - radius, 0.0)), np.sqrt(middle + radius)


def turning(points: ClosedPoints) -> Array:
    """Largest angle (N,) in degrees between a collocation point's normal and its neighbours'."""
    basis = points.grid.basis
    normal = points.normal.reshape(-1, *basis.shape)
    worst = np.ones(basis.shape)
    for beside in neighbours(basis, normal):
        worst = np.minimum(worst, (normal * beside).sum(axis=0))
    return np.degrees(np.arccos(np.clip(worst.ravel(), -1.0, 1.0)))


def neighbours(basis: ClosedBasis, values: Array) -> list[Array]:
    """Values (..., *shape) at the neighbours of each collocation point, one array a direction."""
    full = basis.doubled(values)
    axes = range(-len(basis.shape), 0)
    shifted = [np.roll(full, step, axis=axis) for axis in axes for step in (1, -1)]
    return [s[..., : basis.shape[0], :] if len(basis.shape) == 2 else s for s in shifted]


@dataclass(frozen=True)
class RelaxMesh:
    """The thesis's mesh relaxation (Eq. 3.14 and 4.6), on the surface.

    Points get ``steps`` pseudo-steps of length ``pseudo_step`` with the tangential velocity

        w_i = N^(3/2) / (1 + λ) (I - n n) Σ_j (even + curved |κ_j|^(3/2)) S_j (x_j - x_i)

    over their neighbours j, S_j the element's size and κ the mean curvature: ``even`` (C_r1)
    evens out distances, ``curved`` (C_r2) draws points to where curvature is high.  The moved
    points are looked up on the surface by their parameters, so that only the parametrisation
    changes; how much the shape does is up to the spline's resolution.  A pseudo-step too long to
    be stable is shortened.
    """

    even: float = 1e-4
    curved: float = 2e-4
    steps: int = 1
    pseudo_step: float = 1.0

    def relaxed(self, spline: ClosedSpline, viscosity_ratio: float = 1.0) -> ClosedSpline:
        """The same shape with its points moved."""
        for _ in range(self.steps):
            spline = self._step(spline, viscosity_ratio)
        return spline

    def _step(self, spline: ClosedSpline, viscosity_ratio: float) -> ClosedSpline:
        basis = spline.basis
        points = ClosedGrid(basis, basis.axes()).points(spline)
        cell = np.prod([length / n for n, length in zip(basis.shape, basis.lengths, strict=True)])
        size = points.jacobian * points.grid.measure * cell
        mean = np.abs(points.curvature) / (basis.dimension - 1)
        pull = ((self.even + self.curved * mean**1.5) * size).reshape(basis.shape)
        position = points.position.reshape(-1, *basis.shape)
        beside, strengths = neighbours(basis, position), neighbours(basis, pull)
        pairs = list(zip(strengths, beside, strict=True))
        force = np.sum([strength * (there - position) for strength, there in pairs], axis=0)
        scale = self.pseudo_step * basis.count**1.5 / (1 + viscosity_ratio)
        scale = min(scale, STABLE / float(np.sum(strengths, axis=0).max()))
        drift = np.einsum(
            "acn,cn->an", points.duals, scale * np.reshape(force, (len(position), -1))
        )
        moved = spline.evaluate(basis.parameters() + drift)
        return replace(spline, coefficients=basis.fit(moved.reshape(position.shape)))
