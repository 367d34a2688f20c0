"""Measures of droplets: shape, motion, energies, quality of the mesh."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from cadbem.closed_points import ClosedPoints
from cadbem.spline.basis import Array
from cadbem.spline.closed import ClosedSpline
from cadbem.suspension.interface.extremes import extreme_distances
from cadbem.suspension.interface.laws import Jump
from cadbem.suspension.interface.volume import centre, exact_grid, volume
from cadbem.suspension.surroundings.flows import BackgroundFlow


@dataclass(frozen=True, eq=False)
class Measures:
    """Measures of a droplet at one time; its 'volume' is an area, its 'area' a length in 2D.

    Shape: ``volume``, ``area``, ``centre`` of volume (dim,); ``longest`` and ``shortest`` distance
    of the surface from the centre and their ``directions`` (2, dim); Taylor's ``deformation`` made
    of them; ``inclination`` of the longest one to the x axis in degrees; ``semi_axes`` (dim,), the
    longest first, of the ellipsoid with the same second moments, their directions ``axes``
    (dim, dim), row by row, and the ``inertia_deformation`` made of the first and last.

    Mesh: ``smallest_angle`` between parameter lines in degrees (90 in 2D), ``size_ratio`` of the
    largest to the smallest stretching of area, or length, of the unit sphere or circle.

    Motion: ``velocity`` of the centre (dim,).  ``power``, the rate at which the interface stores
    energy, and ``dissipation``, the viscous dissipation beyond that of the undisturbed flow.
    """

    volume: float
    area: float
    centre: Array
    longest: float
    shortest: float
    directions: Array
    deformation: float
    inclination: float
    semi_axes: Array
    axes: Array
    inertia_deformation: float
    smallest_angle: float
    size_ratio: float
    velocity: Array
    power: float
    dissipation: float


def measure(
    spline: ClosedSpline,
    velocity: Array,
    jump: Jump,
    flow: BackgroundFlow | None,
    viscosity: float = 1.0,
    viscosity_ratio: float = 1.0,
) -> Measures:
    """All measures of a droplet whose interface has a ``velocity``, coefficients (dim, *shape), and
    a traction ``jump``, in a background ``flow`` of fluid with a ``viscosity``.

    Without a ``flow``, as in a channel, the dissipation is not known, and not a number."""
    body = _Body(spline)
    longest, shortest, directions = extreme_distances(spline, body.centre)
    semi_axes, axes = body.inertia
    power, work = _powers(body, velocity, jump, flow, viscosity, viscosity_ratio)
    return Measures(
        volume=body.volume,
        area=float(body.weights.sum()),
        centre=body.centre,
        longest=longest,
        shortest=shortest,
        directions=directions,
        deformation=_contrast(longest, shortest),
        inclination=_angle_to_x(directions[0]),
        semi_axes=semi_axes,
        axes=axes,
        inertia_deformation=_contrast(*semi_axes[[0, -1]]),
        smallest_angle=smallest_angle(body.points),
        size_ratio=float(body.points.jacobian.max() / body.points.jacobian.min()),
        velocity=_centre_velocity(body, velocity),
        power=power,
        dissipation=work - power,
    )


def area(spline: ClosedSpline) -> float:
    """Area of a surface, length of a plane curve."""
    return float(_Body(spline).weights.sum())


def taylor_deformation(spline: ClosedSpline) -> float:
    """(L - B) / (L + B) of the largest and smallest distance from the centre (Eq. 3.17)."""
    return _contrast(*extreme_distances(spline, _Body(spline).centre)[:2])


def inclination(spline: ClosedSpline) -> float:
    """Angle in degrees, 0 ... 90, between the line of the largest distance and the x axis."""
    return _angle_to_x(extreme_distances(spline, _Body(spline).centre)[2][0])


def inertia_axes(spline: ClosedSpline) -> tuple[Array, Array]:
    """Semi-axes (dim,), the longest first, and directions (dim, dim), row by row, of the
    ellipsoid with the same second moments of volume."""
    return _Body(spline).inertia


def inertia_deformation(spline: ClosedSpline) -> float:
    """(L - B) / (L + B) of the longest and shortest of ``inertia_axes``."""
    return _contrast(*inertia_axes(spline)[0][[0, -1]])


def centre_velocity(spline: ClosedSpline, velocity: Array) -> Array:
    """Velocity (dim,) of the centre of volume of a droplet whose interface has a ``velocity``,
    coefficients (dim, *shape): ∫ u dV = ∮ y (u·n) dS, over the volume."""
    return _centre_velocity(_Body(spline), velocity)


def smallest_angle(points: ClosedPoints) -> float:
    """Smallest angle in degrees between parameter lines at points of a surface; 90 in 2D."""
    if len(points.tangents) == 1:
        return 90.0
    lengths = np.linalg.norm(points.tangents, axis=1)
    sine = points.jacobian * points.grid.measure / (lengths[0] * lengths[1])
    return float(np.degrees(np.arcsin(min(sine.min(), 1.0))))


@dataclass(frozen=True, eq=False)
class _Body:
    """A closed spline at quadrature points, and integrals over what it encloses."""

    spline: ClosedSpline

    @cached_property
    def points(self) -> ClosedPoints:
        """Gauss points in all elements."""
        return exact_grid(self.spline.basis)[0].points(self.spline)

    @cached_property
    def weights(self) -> Array:
        """Weights (N,) that integrate over the surface."""
        rule = exact_grid(self.spline.basis)[1]
        return rule * self.points.grid.measure * self.points.jacobian

    @cached_property
    def area(self) -> Array:
        """Normals with their weights (dim, N)."""
        return self.points.normal * self.weights

    @cached_property
    def volume(self) -> float:
        """Enclosed volume."""
        return volume(self.spline)

    @cached_property
    def centre(self) -> Array:
        """Centre of volume (dim,)."""
        return centre(self.spline)

    @cached_property
    def arm(self) -> Array:
        """Positions relative to the centre (dim, N)."""
        return self.points.position - self.centre[:, None]

    @cached_property
    def inertia(self) -> tuple[Array, Array]:
        """See ``inertia_axes``.  With y from the centre, ∫ y y dV = ∮ y y (y·n) dS / (dim + 2),
        which is a_k² ω Π a / (dim + 2) for an ellipsoid; ω = π, 4π/3 is the unit ball's volume.
        """
        dim, ball = self.spline.dimension, np.pi if self.spline.dimension == 2 else 4 * np.pi / 3
        shares = (self.arm * self.area).sum(axis=0) / ball
        moments, columns = np.linalg.eigh((self.arm * shares) @ self.arm.T)
        product = moments.prod() ** (1 / (dim + 2))
        return np.sqrt(moments[::-1] / product), columns.T[::-1]


def _contrast(longest: float, shortest: float) -> float:
    return float((longest - shortest) / (longest + shortest))


def _angle_to_x(direction: Array) -> float:
    return float(np.degrees(np.arctan2(np.linalg.norm(direction[1:]), abs(direction[0]))))


def _centre_velocity(body: _Body, velocity: Array) -> Array:
    """Mean over the volume, ∫ u dV = ∮ y (u·n) dS, or what moves the centre if u has a flux."""
    flux = (body.points.grid.values(velocity) * body.area).sum(axis=0)
    return body.arm @ flux / body.volume


def _powers(
    body: _Body,
    velocity: Array,
    jump: Jump,
    flow: BackgroundFlow | None,
    viscosity: float,
    viscosity_ratio: float,
) -> tuple[float, float]:
    """Power ∮ Δf·u dS that the interface takes up, and the extra work that walls do far away.

    There u = u∞.  With stresses σ outside and σ∞ undisturbed, the reciprocal theorem outside moves
    the extra work from the walls to the interface, ∮ (u∞·σ·n - u·σ∞·n) dS.  Then σ·n = σ_in·n + Δf,
    and inside, where λ σ∞ is a stress of the same fluid, ∮ u∞·σ_in·n dS = λ ∮ u·σ∞·n dS:

        work = ∮ Δf·u∞ dS + (λ - 1) ∮ u·σ∞·n dS.

    In a linear flow this is E:S with Batchelor's stresslet S.  It is dissipated or stored.
    """
    points = body.points
    force, moving = jump(points), points.grid.values(velocity)
    power = float((force * moving).sum(axis=0) @ body.weights)
    if flow is None:
        return power, float("nan")
    work = float((force * flow.velocity(points.position)).sum(axis=0) @ body.weights)
    gradient = flow.gradient(points.position)
    pull = np.einsum("ijn,jn->in", gradient + gradient.swapaxes(0, 1), body.area)
    pull -= flow.pressure(points.position) * body.area
    return power, work + (viscosity_ratio - 1) * viscosity * float((moving * pull).sum())
