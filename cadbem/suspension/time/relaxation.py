"""How droplets relax, nearly: the matrix of linearly implicit steps.

A droplet's fastest rates are those at which its own tension or bending smooths its normal
displacements; its points, other bodies and walls move slowly beside them.  So the matrix takes each
droplet's normal displacement to the motion that it would cause on a sphere (a circle in a plane) of
the same volume at rest in unbounded fluid.  In closed form that is a rate for each degree of
spherical harmonics (Lamb's solution); what counts here are the rates of the splines, whose short
waves differ.  They are found by differences on the round shape, once for each droplet: a change of
one column's points is enough, because turns by a column map the points onto themselves, so that all
matrices are circulant in the columns and become small ones by a Fourier transform.

With e normal velocities of the points, P e the motion that belongs to them and Q c = n · c the
normal part of a change c, let V be the derivative of the normal velocity by c, and T the small loss
when normal velocities become splines.  Velocities that are splines have e = T^-1 V c, and

    A = P M (Q P)^-1 Q,    M = T^-1 V P,    (I - s A)^-1 = I + s P (I - s M)^-1 M (Q P)^-1 Q.

P and Q are those of the shape as it is.  Motions that P makes are treated exactly on the round
shape; what a change along the surface does to curvatures is left to the step, as all that is slow.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np

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

DIFFERENCE = 1e-4  # displacements for differences, in radii
LOST = 1e-7  # share of a displacement from which splines carry it
ROUND = 1e-6  # deformation, in sizes, below which a droplet is as round as rounding lets it be


@dataclass(frozen=True, eq=False)
class RoundRelaxation:
    """The matrices M and (Q P)^-1 (modes, rows, rows) of a round droplet: see the top of this
    file.  A normal displacement whose nodal values are wave m along the columns relaxes by M[m].
    """

    rates: Array
    reading: Array

    def damped(self, displacement: Array, scale: float) -> Array:
        """s (I - s M)^-1 M (Q P)^-1 of normal displacements (N,), s the ``scale``."""
        modes, rows = self.rates.shape[:2]
        waves = np.fft.rfft(displacement.reshape(rows, -1), axis=-1).T[..., None]
        speeds = self.rates @ (self.reading @ waves)
        found = scale * np.linalg.solve(np.eye(rows) - scale * self.rates, speeds)
        columns = displacement.size // rows
        return np.fft.irfft(found[..., 0].T, n=columns, axis=-1).ravel()


@lru_cache(maxsize=64)
def round_relaxation(
    basis: ClosedBasis, interface: InterfaceLaw, viscosity_ratio: float, size: float,
    viscosity: float, rule: SelfRule, motion: Motion,
) -> RoundRelaxation:  # fmt: skip
    """That of a round droplet of a ``size`` (see ``Body``) in unbounded fluid."""
    dim, columns = basis.dimension, basis.shape[-1]
    radius = size * (dim / unit_measure(dim)) ** (1 / dim)
    droplet = Droplet(closed_spline(basis, lambda unit: radius * unit), interface, viscosity_ratio)
    layers, rows = droplet.placed(rule).layers, basis.count // columns
    found = np.empty((3, rows, rows, columns))
    for row in range(rows):
        single = np.zeros(basis.count)
        single[row * columns] = 1.0
        spline = _along_normal(layers, single)
        change = motion(layers, spline)
        speed = _change_of_speed(droplet, DIFFERENCE * radius * change, viscosity, rule)
        parts = (
            speed / (DIFFERENCE * radius),
            normal_part(layers, spline),
            normal_part(layers, change),
        )
        found[:, :, row] = np.stack(parts).reshape(3, rows, columns)
    speeds, kept, read = np.fft.rfft(found, axis=-1).transpose(0, 3, 1, 2)
    rates = np.linalg.pinv(kept, rcond=LOST) @ speeds
    return RoundRelaxation(rates, np.linalg.pinv(read, rcond=LOST))


def _change_of_speed(droplet: Droplet, change: Array, viscosity: float, rule: SelfRule) -> Array:
    """Change of the normal speeds (N,) of a droplet at rest with that of its coefficients: half of
    the difference between forth and back."""
    flow, total = FreeFlow(at_rest(droplet.dimension), viscosity), np.zeros(change[0].size)
    for side in (1, -1):
        placed = droplet.at(droplet.shape.coefficients + side * change).placed(rule)
        velocity = velocity_responses(flow, [placed])[0].velocity
        total += side / 2 * normal_part(placed.layers, velocity)
    return total


def normal_part(layers: ClosedLayers, coefficients: Array) -> Array:
    """The normal part (N,) at the collocation points of a field with coefficients (dim, *shape)."""
    values = layers.operator.collocation.values(coefficients)
    return (values * layers.targets.normal).sum(axis=0)


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
        """Whether it is known how all droplets relax: not those whose law has an unknown."""
        return all(hasattr(b.interface, "jump_of") for b in self.state.droplets)

    @cached_property
    def _round(self) -> list[RoundRelaxation | None]:
        """That of each droplet, None for other bodies, which do not relax."""
        flow, rule = self.state.flow, self.state.environment.rule
        return [
            round_relaxation(
                b.shape.basis, b.interface, b.viscosity_ratio, b.size, flow.viscosity, rule,
                self.motion,
            )
            if isinstance(b, Droplet) else None
            for b in self.starts
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
        speeds = relaxation.damped(normal_part(layers, field), scale)
        return (field + self.motion(layers, _along_normal(layers, speeds))).ravel()

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
    along = normal_part(placed.layers, change.reshape(placed.layers.spline.coefficients.shape))
    shift = np.linalg.lstsq(normal.T, along, rcond=None)[0]
    return float(np.abs(along - shift @ normal).max())


def _out_of_round(placed: PlacedDroplet, coefficients: Array) -> float:
    """Difference between the largest and the smallest distance of coefficients from their mean."""
    points = coefficients.reshape(placed.body.dimension, -1)
    distance = np.linalg.norm(points - points.mean(axis=1)[:, None], axis=0)
    return float(np.ptp(distance))
