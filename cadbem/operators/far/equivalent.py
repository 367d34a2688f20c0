"""Equivalent sources: the far field of a body, by fewer Stokeslets than its surface has nodes.

Outside a ball that holds all nodes of a body, its velocity is that of Stokeslets on a smaller
sphere, chosen such that their velocity is the same at points around the ball, and of one point
source, the net flux through the surface (as in kernel-independent fast multipole methods: Ying,
Biros and Zorin 2004).  In units of the ball's radius all this is the same for all bodies.

Incoming flow is the transposed problem: as G(x, y) is symmetric, the velocity of far sources inside
a ball is that of Stokeslets on the outer points, with the transposed matrix applied to the velocity
at the inner ones.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from math import ceil, exp

import numpy as np
from scipy.linalg import pinv

from cadbem.checks import within
from cadbem.kernels.stokes import stokes_kernels
from cadbem.kernels.stokes_sums import stokes_sums
from cadbem.spline.basis import Array

INNER = 0.9  # radius of the sphere of Stokeslets; that of the ball is 1
SPARE = 1.2  # Stokeslets for each harmonic that they are to represent
CHECKS = 1.5  # points at which velocities are compared, for each Stokeslet
RANK = 1e-12  # share of the largest singular value below which others are left out
REACHES = (2.5, 4.5, 9.0)  # distances from the centre from which an expansion is to hold


@dataclass(frozen=True, eq=False)
class Ball:
    """A ``centre`` (dim,) and a ``radius``."""

    centre: Array
    radius: float

    def unit(self, points: Array) -> Array:
        """Points (dim, M) in units of the radius, from the centre."""
        return (points - self.centre[:, None]) / self.radius

    def world(self, points: Array) -> Array:
        """The inverse of ``unit``."""
        return self.centre[:, None] + self.radius * points


def ball_around(points: Array) -> Ball:
    """A ball that holds points (dim, M), around the middle of their extent."""
    centre = (points.min(axis=1) + points.max(axis=1)) / 2
    return Ball(centre, float(np.linalg.norm(points - centre[:, None], axis=0).max()))


@dataclass(frozen=True, eq=False)
class Sources:
    """Nodes at ``position`` (dim, K) with Stokeslets ``single`` (dim, K), and with stresslets of
    ``area`` vectors and densities ``double`` (dim, K), if any; quadrature weights included."""

    position: Array
    single: Array | None = None
    area: Array | None = None
    double: Array | None = None

    def add_to(self, targets: Array, out: Array) -> None:
        """Add Σ G q + Σ u·T·a at targets (dim, M) to ``out`` (dim, M)."""
        sums = stokes_sums(len(self.position))
        targets, position = map(np.ascontiguousarray, (targets, self.position))
        if self.single is not None:
            sums.single(targets, position, np.ascontiguousarray(self.single), out)
        if self.double is not None:
            area, double = map(np.ascontiguousarray, (self.area, self.double))
            sums.double(targets, np.zeros_like(targets), position, area, double, out)

    def in_units_of(self, ball: Ball) -> Sources:
        """In units of a ball's radius R, in which equivalent Stokeslets are the same: G q loses a
        factor 1 / R (or a constant log R q in 2D), T one more, which the area vectors take."""
        area = None if self.area is None else self.area / ball.radius
        return replace(self, position=ball.unit(self.position), area=area)

    @property
    def flux(self) -> float:
        """Σ u·a, to which the net flux is proportional."""
        if self.double is None or self.area is None:
            return 0.0
        return float((self.area * self.double).sum())


def point_sources(centres: Array, fluxes: Array) -> Sources:
    """Points (dim, B) with net ``fluxes`` (B,), as stresslets along each axis."""
    dim, count = centres.shape
    axes = np.tile(np.eye(dim), count)
    return Sources(np.repeat(centres, dim, axis=1), None, axes, axes * np.repeat(fluxes / dim, dim))


@dataclass(frozen=True)
class Expansion:
    """Equivalent sources that resolve harmonics up to an ``order``, for distances from ``reach``
    on, in radii of the ball."""

    dimension: int
    order: int
    reach: float

    @cached_property
    def inner(self) -> Array:
        """Places (dim, E) of the Stokeslets in the unit ball."""
        harmonics = (self.order + 1) ** 2 if self.dimension == 3 else 2 * self.order + 1
        return INNER * even_directions(self.dimension, ceil(SPARE * harmonics))

    @cached_property
    def outer(self) -> Array:
        """Points (dim, C) at the reach at which velocities are compared."""
        count = ceil(CHECKS * self.inner.shape[1])
        return self.reach * even_directions(self.dimension, count)

    @cached_property
    def _matrix(self) -> Array:
        """From velocities at the outer points to Stokeslets, both flat: (dim E, dim C).

        Stokeslets along the normals have almost no velocity outside, and are left out."""
        matrix = _stokeslets(self.outer, self.inner)
        normal = self.inner.ravel() / np.linalg.norm(self.inner)
        return pinv(matrix - np.outer(matrix @ normal, normal), rtol=RANK)

    def outgoing(self, velocity: Array) -> Array:
        """Stokeslets (dim, E) at the inner points of a velocity (dim, C) at the outer ones."""
        return (self._matrix @ velocity.ravel()).reshape(self.inner.shape)

    def incoming(self, velocity: Array) -> Array:
        """Stokeslets (dim, C) at the outer points of a velocity (dim, E) at the inner ones."""
        return (velocity.ravel() @ self._matrix).reshape(self.outer.shape)

    def lowered(self, finer: Expansion, strengths: Array) -> Array:
        """Stokeslets (dim, E) that replace those of a ``finer`` expansion."""
        return (_lowering(self, finer) @ strengths.ravel()).reshape(self.inner.shape)

    def equivalent(self, unit: Sources) -> Array:
        """Stokeslets (dim, E) of nodes in the unit ball, without their net flux."""
        velocity = np.zeros_like(self.outer)
        unit.add_to(self.outer, velocity)
        if unit.flux:
            origin = np.zeros((self.dimension, 1))
            point_sources(origin, np.array([-unit.flux])).add_to(self.outer, velocity)
        return self.outgoing(velocity)


@lru_cache(maxsize=32)
def _lowering(coarse: Expansion, fine: Expansion) -> Array:
    return coarse._matrix @ _stokeslets(coarse.outer, fine.inner)


@dataclass(frozen=True)
class FarField:
    """Equivalent sources for distant bodies, with an error of about ``tolerance`` for each body,
    relative to the velocity that it induces on its own surface.

    Densities of an order above p are missed.  Their velocity falls like (R / r)^(p + 2), and they
    are the weaker the higher the order, like e^(-p / 3) (measured on droplets that nearly touch).
    """

    tolerance: float = 1e-6

    def __post_init__(self) -> None:
        within("FarField's tolerance", self.tolerance, 1e-9, 1e-2)

    def expansions(self, dimension: int) -> tuple[Expansion, ...]:
        """From the finest, which holds from the nearest distance on, to the coarsest."""
        return far_expansions(dimension, self.tolerance)


@lru_cache(maxsize=8)
def far_expansions(dimension: int, tolerance: float) -> tuple[Expansion, ...]:
    """The lowest orders that hold from each of ``REACHES`` on."""

    def reach(order: int) -> float:
        return (exp(-order / 3) / tolerance) ** (1 / (order + 2))

    orders = [next(p for p in range(2, 40) if reach(p) <= wanted) for wanted in REACHES]
    return tuple(Expansion(dimension, p, reach(p)) for p in orders)


def even_directions(dimension: int, count: int) -> Array:
    """Unit vectors (dim, count), evenly spread: on a spiral of golden angles in 3D."""
    k = np.arange(count) + 0.5
    if dimension == 2:
        return np.stack([np.cos(2 * np.pi * k / count), np.sin(2 * np.pi * k / count)])
    height, turn = 1 - 2 * k / count, np.pi * (1 + np.sqrt(5)) * k
    radius = np.sqrt(1 - height**2)
    return np.stack([radius * np.cos(turn), radius * np.sin(turn), height])


def _stokeslets(targets: Array, sources: Array) -> Array:
    """G as a matrix (dim T, dim N) between flat arrays."""
    kernel, _ = stokes_kernels(len(targets))
    room = np.empty(kernel.entries * targets.shape[1] * sources.shape[1])
    table = kernel.block(targets, sources, np.zeros_like(sources), room)
    return np.block([[table[entry] for entry in row] for row in kernel.single])
