"""How droplets relax, nearly: the matrix of linearly implicit steps.

A droplet's fastest rates are those at which its own tension or bending smooths its shape; whatever
else moves it is slow beside them.  So the matrix takes each droplet's displacement to the motion
that it would cause on a sphere (a circle in a plane) of the same volume at rest in unbounded fluid.
In closed form that is a rate for each degree of spherical harmonics (Lamb's solution); what counts
here are the rates of the splines, whose short waves differ.  They are found by differences on the
round shape.  Displacements of one column's points are enough: turns by a column map the points onto
themselves, so all matrices are circulant in the columns, and a Fourier transform leaves small ones.

With e normal velocities of the points and P e the motion that belongs to them, and V the derivative
of normal velocities by displacements of the points, which counts in the directions of the normal
and of the parameters,

    A = P V,    (I - s A)^-1 = I + s P (I - s M)^-1 V,    M = V P.

V and M are those of the round shape, P and the directions those of the shape as it is.
"""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import cast

import numpy as np
from numpy.typing import NDArray

from cadbem.operators.closed.layers import ClosedLayers
from cadbem.quadrature.closed import SelfRule
from cadbem.spline.basis import Array
from cadbem.spline.closed import ClosedBasis, closed_spline, unit_measure
from cadbem.suspension.bodies.body import Body, Placed
from cadbem.suspension.bodies.droplet import Droplet, PlacedDroplet
from cadbem.suspension.interface.laws import InterfaceLaw
from cadbem.suspension.interface.motion import Motion
from cadbem.suspension.multibody.multibody import velocity_responses
from cadbem.suspension.surroundings.flows import at_rest
from cadbem.suspension.surroundings.free_flow import FreeFlow
from cadbem.suspension.time.checkpoint import coordinates, ends
from cadbem.suspension.time.rosenbrock import Damping
from cadbem.suspension.time.state import State

Waves = NDArray[np.complex128]
DIFFERENCE = 1e-5  # displacements for differences, in radii
MOST_POINTS = 500  # of a droplet whose matrix is worked out
ROUND = 1e-6  # deformation, in sizes, below which a droplet is as round as rounding lets it be


@dataclass(frozen=True, eq=False)
class RoundRelaxation:
    """The matrices V (modes, rows, dim rows) and M (modes, rows, rows) of a round droplet, for
    displacements with the wave m along the columns: see the top of this file."""

    speeds: Waves
    rates: Waves

    def damped(self, displacement: Array, scale: float) -> Array:
        """s (I - s M)^-1 V (N,) of displacements (dim, N) along the directions, s the ``scale``."""
        rows, columns = self.rates.shape[1], displacement.shape[1] // self.rates.shape[1]
        waves = np.fft.rfft(displacement.reshape(-1, columns), axis=-1).T[..., None]
        matrices = np.eye(rows) - scale * self.rates
        found = scale * np.linalg.solve(matrices, self.speeds @ waves)
        return np.fft.irfft(found[..., 0].T, n=columns, axis=-1).ravel()


@lru_cache(maxsize=64)
def round_relaxation(
    basis: ClosedBasis, interface: Hashable, viscosity_ratio: float, size: float,
    viscosity: float, rule: SelfRule, motion: Motion,
) -> RoundRelaxation:  # fmt: skip
    """That of a round droplet of a ``size`` (see ``Body``) in unbounded fluid."""
    dim, columns = basis.dimension, basis.shape[-1]
    radius = size * (dim / unit_measure(dim)) ** (1 / dim)
    shape = closed_spline(basis, lambda unit: radius * unit)
    droplet = Droplet(shape, cast(InterfaceLaw, interface), viscosity_ratio)
    layers, rows = droplet.placed(rule).layers, basis.count // columns
    flow, frame = FreeFlow(at_rest(dim), viscosity), directions(layers)
    start = _normal_speed(droplet, flow, rule)
    speeds = np.empty((rows, dim, rows, columns))
    for place in np.ndindex(dim, rows):
        single = np.zeros((dim, basis.count))
        single[place[0], place[1] * columns] = DIFFERENCE * radius
        change = basis.fit(np.einsum("an,acn->cn", single, frame).reshape(-1, *basis.shape))
        moved = droplet.at(shape.coefficients + change)
        speed = (_normal_speed(moved, flow, rule) - start) / (DIFFERENCE * radius)
        speeds[:, *place] = speed.reshape(rows, columns)
    waves = np.fft.rfft(speeds.reshape(rows, dim * rows, columns), axis=-1).transpose(2, 0, 1)
    return RoundRelaxation(waves, waves @ _motions(layers, motion))


def _motions(layers: ClosedLayers, motion: Motion) -> Waves:
    """P (modes, dim rows, rows) of a round droplet, as displacements along the directions."""
    basis = layers.operator.basis
    columns, rows = basis.shape[-1], basis.count // basis.shape[-1]
    found = np.empty((basis.dimension * rows, rows, columns))
    for row in range(rows):
        single = np.zeros(basis.count)
        single[row * columns] = 1.0
        change = along(layers, moving(layers, single, motion))
        found[:, row] = change.reshape(-1, columns)
    return np.fft.rfft(found, axis=-1).transpose(2, 0, 1)


def _normal_speed(droplet: Droplet, flow: FreeFlow, rule: SelfRule) -> Array:
    """The normal velocity (N,) of a droplet's points."""
    placed = droplet.placed(rule)
    return along(placed.layers, velocity_responses(flow, [placed])[0].velocity)[0]


def directions(layers: ClosedLayers) -> Array:
    """Unit vectors (dim, dim, N) at the collocation points: the normal, then along parameters."""
    targets = layers.targets
    tangents = targets.tangents / np.linalg.norm(targets.tangents, axis=1)[:, None]
    return np.concatenate([targets.normal[None], tangents])


def along(layers: ClosedLayers, coefficients: Array) -> Array:
    """Components (dim, N) along the ``directions`` of a field with coefficients (dim, *shape)."""
    values = layers.operator.collocation.values(coefficients)
    return np.einsum("cn,acn->an", values, directions(layers))


def moving(layers: ClosedLayers, speeds: Array, motion: Motion) -> Array:
    """P: the coefficients (dim, *shape) of the motion that goes with normal velocities (N,).

    Those that are lost when they become a spline are added once more, as by the motion itself.
    """
    spline = _along_normal(layers, speeds)
    lost = speeds - along(layers, spline)[0]
    return motion(layers, spline) + _along_normal(layers, lost)


def _along_normal(layers: ClosedLayers, speeds: Array) -> Array:
    """Coefficients (dim, *shape) of normal velocities (N,)."""
    basis = layers.operator.basis
    return basis.fit((layers.targets.normal * speeds).reshape(-1, *basis.shape))


@dataclass(frozen=True, eq=False)
class Relaxation:
    """The matrix A at a ``state`` of a run, and how wrong steps with it are in shapes.

    ``starts`` are the bodies at the beginning, whose volumes the round shapes have.
    """

    state: State
    starts: Sequence[Body]
    motion: Motion

    @property
    def known(self) -> bool:
        """Whether it is known how all droplets relax: not those whose law has an unknown, and not
        those with many points, whose matrix would cost more than it saves."""
        return all(
            hasattr(b.interface, "jump_of") and b.shape.basis.count <= MOST_POINTS
            for b in self.state.droplets
        )

    @cached_property
    def _round(self) -> list[RoundRelaxation | None]:
        """That of each droplet, None for other bodies, which do not relax."""
        flow, rule = self.state.flow, self.state.environment.rule
        return [
            round_relaxation(
                b.shape.basis, cast(Hashable, b.interface), b.viscosity_ratio, start.size,
                flow.viscosity, rule, self.motion,
            )
            if isinstance(b, Droplet) else None
            for b, start in zip(self.state.bodies, self.starts, strict=True)
        ]  # fmt: skip

    def damping(self, scale: float) -> Damping:
        """(I - s A)^-1 for arrays of all coordinates, s the ``scale``."""

        def damped(change: Array) -> Array:
            pieces = np.split(change, ends(self.state))
            bodies = zip(self.state.placed, self._round, pieces, strict=True)
            return np.concatenate([self._damped(*body, scale) for body in bodies])

        return damped

    def _damped(
        self, placed: Placed, relaxation: RoundRelaxation | None, change: Array, scale: float
    ) -> Array:
        """The part of one body."""
        if relaxation is None or not isinstance(placed, PlacedDroplet):
            return change
        layers = placed.layers
        field = change.reshape(layers.spline.coefficients.shape)
        speeds = relaxation.damped(along(layers, field), scale)
        return (field + moving(layers, speeds, self.motion)).ravel()

    def error(self, error: Array, after: Array) -> float:
        """Largest normal part of an error of all coordinates, but for displacements of whole
        droplets, relative to how far these are from round, before or ``after`` the step."""
        cuts, worst = ends(self.state), 0.0
        states = (coordinates(self.state), after)
        pieces = zip(*(np.split(a, cuts) for a in (error, *states)), strict=True)
        for placed, (change, *shapes) in zip(self.state.placed, pieces, strict=True):
            if isinstance(placed, PlacedDroplet):
                deformation = max(_out_of_round(placed, shape) for shape in shapes)
                deformation = max(deformation, ROUND * placed.body.size)
                worst = max(worst, _shape_change(placed, change) / deformation)
        return worst


def _shape_change(placed: PlacedDroplet, change: Array) -> float:
    """Largest normal displacement in a change of coefficients, without that of the whole."""
    normal = placed.layers.targets.normal
    field = change.reshape(placed.layers.spline.coefficients.shape)
    displacement = along(placed.layers, field)[0]
    shift = np.linalg.lstsq(normal.T, displacement, rcond=None)[0]
    return float(np.abs(displacement - shift @ normal).max())


def _out_of_round(placed: PlacedDroplet, coefficients: Array) -> float:
    """Difference between the largest and the smallest distance of coefficients from their mean."""
    points = coefficients.reshape(placed.body.dimension, -1)
    distance = np.linalg.norm(points - points.mean(axis=1)[:, None], axis=0)
    return float(np.ptp(distance))
