"""Mesh quality of closed splines, and its repair without changing the shape."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from cadbem.checks import not_negative, positive, whole
from cadbem.closed_points import ClosedPoints, collocation_grid
from cadbem.spline.basis import Array
from cadbem.spline.closed import ClosedBasis, ClosedSpline, unit_measure

TURN_LIMIT = 75.0  # degrees between neighbouring normals from which a shape is not resolved
STABLE = 0.3  # largest share of the way to its neighbours that a point goes in a pseudo-step


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


def unresolved(points: ClosedPoints) -> str:
    """Why a shape cannot be trusted any more, or nothing."""
    turn = turning(points)
    if turn.max() <= TURN_LIMIT:
        return ""
    place = ", ".join(f"{x:.3g}" for x in points.position[:, int(turn.argmax())])
    return (
        f"the surface turns by {turn.max():.0f} degrees between neighbouring points near "
        f"({place}): a neck or a tip thinner than the points resolve; take more points to go on"
    )


def neighbours(basis: ClosedBasis, values: Array) -> list[Array]:
    """Values (..., *shape) at the neighbours of each collocation point, one array a direction."""
    full = basis.doubled(values)
    axes = range(-len(basis.shape), 0)
    shifted = [np.roll(full, step, axis=axis) for axis in axes for step in (1, -1)]
    return [s[..., : basis.shape[0], :] if len(basis.shape) == 2 else s for s in shifted]


@dataclass(frozen=True)
class RelaxMesh:
    """The thesis's mesh relaxation (Eq. 3.14 and 4.6), on the surface and without poles.

    Points get ``steps`` pseudo-steps of length ``pseudo_step`` with the tangential velocity

        w_i = N^(3/2) / (1 + λ) (I - n n) Σ_j p_j (x_j - x_i),  p = (even + curved |κ|^(3/2)) S

    over their neighbours j, S the element's size and κ the mean curvature: ``even`` (C_r1) evens
    out distances, ``curved`` (C_r2) draws points to where curvature is high.  On a sphere's grid
    the crowded points at the poles would seek more room, and could find it only in a singular
    map; so S is the area of an evenly spread point, stretched like the surface there, and the
    terms of the sum get the weights that make it a Laplacian on the unit sphere when p is even.

    The moved points are looked up on the surface by their parameters, so that only the
    parametrisation changes; how much the shape does is up to the spline's resolution.  A
    pseudo-step too long to be stable is shortened.
    """

    even: float = 1e-4
    curved: float = 2e-4
    steps: int = 1
    pseudo_step: float = 1.0

    def __post_init__(self) -> None:
        not_negative("RelaxMesh's even", self.even)
        not_negative("RelaxMesh's curved", self.curved)
        whole("RelaxMesh's steps", self.steps)
        positive("RelaxMesh's pseudo_step", self.pseudo_step)
        positive("the sum of RelaxMesh's even and curved", self.even + self.curved)

    def relaxed(self, spline: ClosedSpline, viscosity_ratio: float = 1.0) -> ClosedSpline:
        """The same shape with its points moved."""
        for _ in range(self.steps):
            spline = self._step(spline, viscosity_ratio)
        return spline

    def _step(self, spline: ClosedSpline, viscosity_ratio: float) -> ClosedSpline:
        basis = spline.basis
        points = collocation_grid(basis).points(spline)
        mean = np.abs(points.curvature) / (basis.dimension - 1)
        cell = unit_measure(basis.dimension) / basis.count
        pull = (self.even + self.curved * mean**1.5) * points.jacobian * cell
        position = points.position.reshape(-1, *basis.shape)
        beside, pulls = neighbours(basis, position), neighbours(basis, pull.reshape(basis.shape))
        force, fastest = np.zeros_like(position), np.zeros(basis.shape)
        for there, strength, share in zip(beside, pulls, _shares(basis), strict=True):
            force += strength * share * (there - position)
            fastest += strength * share
        scale = self.pseudo_step * basis.count**1.5 / (1 + viscosity_ratio)
        scale = min(scale, STABLE / float(fastest.max()))
        along = scale * force.reshape(len(position), -1)
        drift = np.einsum("acn,cn->an", points.duals, along)
        moved = spline.evaluate(basis.parameters() + drift)
        return replace(spline, coefficients=basis.fit(moved.reshape(-1, *basis.shape)))


def _shares(basis: ClosedBasis) -> list[Array]:
    """Weights of the differences to each of ``neighbours`` in a Laplacian: 1 on the circle, and
    on the sphere those of ∂_θ (sin θ ∂_θ) / sin θ + ∂_φ² / sin² θ, times an even cell's area."""
    if basis.dimension == 2:
        return [np.ones(1)] * 2
    (rows, columns), theta = basis.shape, basis.axes()[0][:, None]
    south, east, area = np.pi / rows, 2 * np.pi / columns, 4 * np.pi / basis.count
    meridian = [np.sin(theta + side * south / 2) / np.sin(theta) for side in (-1, 1)]
    return [area / south**2 * m for m in meridian] + [area / (east * np.sin(theta)) ** 2] * 2
