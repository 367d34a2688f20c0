"""Rules on the unit circle and sphere for integrals over closed splines seen from their own points.

A smooth window η around the target splits an integral in two.  What is left outside it is as smooth
as the surface, and an even grid integrates it: the trapezoidal rule in angles, Fejér's rule in the
colatitude.  The part inside takes polar coordinates around the target, in which the Jacobian takes
away the singularity; on the circle, a rule for logarithms on either side.  (Bruno and Kunyansky
2001, with the error function as the window.)  Written as one list of nodes for each target,

    ∫ f = Σ_grid w f - Σ_grid η w f + Σ_polar η v f,

the first sum is the same for all targets.  All nodes are fixed in the parameters; targets in a row
of equal colatitude share theirs up to a turn.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache
from math import ceil, log, pi, sqrt

import numpy as np
from numpy.typing import NDArray
from scipy.special import erfc

from cadbem.quadrature.gauss import Array, gauss_on_breaks, gauss_unit, log_unit

Index = NDArray[np.int64]


@dataclass(frozen=True)
class PolarRule:
    """Windowed polar integration; ``tolerance`` relative to the kernel's own integral.

    ``refinement``: nodes of the grid per collocation point and direction; even, so that no node
    is a target.  For shapes that are stretched unevenly it should be higher: see ``suited``.
    """

    tolerance: float = 1e-5
    refinement: int = 2

    def __post_init__(self) -> None:
        if not 1e-12 <= self.tolerance <= 1e-2 or self.refinement < 2 or self.refinement % 2:
            raise ValueError(
                f"PolarRule({self.tolerance}, {self.refinement}): tolerances from 1e-12 to 1e-2 "
                "and even refinements are possible"
            )

    def suited(self, stretch: float) -> PolarRule:
        """The rule for a map from the sphere that stretches one direction more than another by
        such a ratio: twice as fine from 2.5, three times from 5."""
        return replace(self, refinement=self.refinement * min(1 + int(stretch / 2.5), 3))


@dataclass(frozen=True)
class SingularitySubtraction:
    """The thesis's variant: Gauss rules of an ``order`` on all elements, nothing near the target.

    Only Eq. 4.3 and 4.4 soften the singularity, so it converges slowly, and fails for large
    viscosity ratios; for comparison.  The order is even, so that no node is a target.
    """

    order: int = 4

    def __post_init__(self) -> None:
        if self.order not in range(2, 65, 2):
            raise ValueError(
                f"SingularitySubtraction({self.order}): even orders from 2 to 64 are possible"
            )

    def suited(self, stretch: float) -> SingularitySubtraction:
        """The same rule for all shapes, as in the thesis."""
        return self


SelfRule = PolarRule | SingularitySubtraction


@dataclass(frozen=True, eq=False)
class NearNodes:
    """Nodes around the targets of one row, relative to the first target in the row.

    ``parameters`` (p, K) and ``weights`` (K,) of the polar part; ``rows``, ``columns`` (K',) of
    grid nodes, with ``corrections`` (K',) to their weights.
    """

    parameters: Array
    weights: Array
    rows: Index
    columns: Index
    corrections: Array


@dataclass(frozen=True, eq=False)
class ClosedRule:
    """A grid on the circle or sphere (``axes``; ``weights`` (nodes,) for its own length or area),
    and the nodes near the targets in each row; none for singularity subtraction."""

    axes: list[Array]
    weights: Array
    near: list[NearNodes]


@lru_cache(maxsize=32)
def closed_rule(rule: SelfRule, shape: tuple[int, ...]) -> ClosedRule:
    """The rule for (n,) collocation points on the circle, or (rows, columns) on the sphere."""
    if isinstance(rule, SingularitySubtraction):
        return _gauss_grid(rule.order, shape)
    grid = tuple(rule.refinement * n for n in shape)
    digits = -log(rule.tolerance)
    steepness = sqrt(digits)  # erfc(s) falls like exp(-s²)
    spacings = digits / (pi / 2)  # the grid resolves the window's spectrum exp(-(πS/2s)²)
    if len(shape) == 1:
        return _circle(shape[0], grid[0], spacings, steepness)
    return _sphere(shape, grid, spacings, steepness)


def fejer_weights(count: int) -> Array:
    """Weights of ∫ f(θ) sin θ dθ over 0 ... π at θ_j = (j + 1/2) π / count (Fejér's first rule)."""
    theta = (np.arange(count) + 0.5) * pi / count
    k = np.arange(1, count // 2 + 1)
    return 2 / count * (1 - 2 * (np.cos(2 * np.outer(theta, k)) / (4 * k**2 - 1)).sum(axis=1))


def _window(share: Array, steepness: float) -> Array:
    """From 1 to 0 over 0 ... 1."""
    inside = np.clip(share, 0.0, 1.0)
    return np.where(share < 1, 0.5 * erfc(steepness * (2 * inside - 1)), 0.0)


def _gauss_grid(order: int, shape: tuple[int, ...]) -> ClosedRule:
    if len(shape) == 1:
        nodes, weights = gauss_on_breaks(order, np.linspace(0, 2 * pi, shape[0] + 1))
        return ClosedRule([nodes], weights, [])
    theta, row_weights = gauss_on_breaks(order, np.linspace(0, pi, shape[0] + 1))
    phi, column_weights = gauss_on_breaks(order, np.linspace(0, 2 * pi, shape[1] + 1))
    weights = np.outer(row_weights * np.sin(theta), column_weights).ravel()
    return ClosedRule([theta, phi], weights, [])


def _circle(count: int, nodes: int, spacings: float, steepness: float) -> ClosedRule:
    step = 2 * pi / nodes
    radius = min(spacings * step, pi)
    axis = step * np.arange(0.5, nodes)
    target = pi / count
    unit, weights = log_unit(2 * ceil(steepness**2) + 8)
    weights = weights * radius * _window(unit, steepness)
    parameters = np.concatenate([target - radius * unit, target + radius * unit])
    away = np.abs((axis - target + pi) % (2 * pi) - pi)
    inside = np.nonzero(away < radius)[0]
    near = NearNodes(
        parameters[None],
        np.concatenate([weights, weights]),
        np.zeros_like(inside),
        inside,
        -step * _window(away[inside] / radius, steepness),
    )
    return ClosedRule([axis], np.full(nodes, step), [near])


def _sphere(
    shape: tuple[int, ...],
    grid: tuple[int, ...],
    spacings: float,
    steepness: float,
) -> ClosedRule:
    theta = (np.arange(grid[0]) + 0.5) * pi / grid[0]
    phi = (np.arange(grid[1]) + 0.5) * 2 * pi / grid[1]
    weights = np.outer(fejer_weights(grid[0]), np.full(grid[1], 2 * pi / grid[1]))
    radius = min(spacings * max(pi / grid[0], 2 * pi / grid[1]), pi)
    polar = _polar_disc(radius, spacings, steepness)
    near = []
    for j in range(shape[0]):
        first = (j + 0.5) * pi / shape[0]
        away = _distance(first, pi / shape[1], theta[:, None], phi[None])
        rows, columns = np.nonzero(away < radius)
        corrections = -weights[rows, columns] * _window(away[rows, columns] / radius, steepness)
        parameters = _around(first, pi / shape[1], polar[0], polar[1])
        near.append(NearNodes(parameters, polar[2], rows, columns, corrections))
    return ClosedRule([theta, phi], weights.ravel(), near)


def _polar_disc(radius: float, spacings: float, steepness: float) -> tuple[Array, Array, Array]:
    """Distances, directions and weights around a point of the sphere, window included."""
    around = ceil(3.5 * spacings)
    unit, unit_weights = gauss_unit(min(ceil(1.5 * spacings), 64))
    weights = radius * unit_weights * np.sin(radius * unit) * _window(unit, steepness)
    directions = (np.arange(around) + 0.5) * 2 * pi / around
    reach, angle = np.meshgrid(radius * unit, directions, indexing="ij")
    return reach.ravel(), angle.ravel(), np.repeat(weights * 2 * pi / around, around)


def _distance(theta: float, phi: float, other_theta: Array, other_phi: Array) -> Array:
    """Angles between a point of the sphere and others (haversine formula)."""
    half = (
        np.sin((other_theta - theta) / 2) ** 2
        + np.sin(theta) * np.sin(other_theta) * np.sin((other_phi - phi) / 2) ** 2
    )
    return 2 * np.arcsin(np.sqrt(np.clip(half, 0.0, 1.0)))


def _around(theta: float, phi: float, reach: Array, angle: Array) -> Array:
    """Colatitude and longitude (2, K) of points at a distance and direction from a point."""
    up = np.cos(reach) * np.cos(theta) - np.sin(reach) * np.sin(theta) * np.cos(angle)
    south = np.cos(reach) * np.sin(theta) + np.sin(reach) * np.cos(theta) * np.cos(angle)
    east = np.sin(reach) * np.sin(angle)
    return np.stack([np.arctan2(np.hypot(south, east), up), phi + np.arctan2(east, south)])
