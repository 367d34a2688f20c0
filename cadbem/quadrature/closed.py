"""Rules on the unit circle and sphere for integrals over closed splines at their own points.

A smooth window η around the target splits an integral in two.  What is left outside it is as smooth
as the surface, and an even grid integrates it: the trapezoidal rule in angles, Fejér's rule in the
colatitude.  The part inside takes polar coordinates around the target, in which the Jacobian takes
away the singularity; on the circle, a rule for logarithms on either side.  (Bruno and Kunyansky
2001, with the error function as the window.)  Written as one list of nodes for each target,

    ∫ f = Σ_grid w f - Σ_grid η w f + Σ_polar η v f,

the first sum is the same for all targets.  All nodes are fixed in the parameters; targets in a row
of equal colatitude share theirs up to a turn.  Targets near the surface are served alike, with
polar coordinates around their nearest point.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache
from math import asinh, ceil, log, pi, sqrt

import numpy as np
from numpy.typing import NDArray
from scipy.special import erfc

from cadbem.checks import whole, within
from cadbem.errors import InputError
from cadbem.quadrature.gauss import MAX_ORDER, Array, gauss_on_breaks, gauss_unit, log_unit

Index = NDArray[np.int64]


@dataclass(frozen=True)
class PolarRule:
    """Windowed polar integration; ``tolerance`` relative to the kernel's own integral.

    ``refinement``: nodes of the grid per collocation point, in the direction in which these are
    closest together on the unit sphere; even, so that no node is a target.  For shapes that are
    stretched unevenly it should be higher: see ``suited``.
    """

    tolerance: float = 1e-5
    refinement: int = 2

    def __post_init__(self) -> None:
        within("PolarRule's tolerance", self.tolerance, 1e-12, 1e-2)
        if whole("PolarRule's refinement", self.refinement, 2) % 2:
            raise InputError(f"PolarRule's refinement is {self.refinement}; give an even number")

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
        if whole("SingularitySubtraction's order", self.order, 2, 64) % 2:
            raise InputError(f"SingularitySubtraction's order is {self.order}; give an even number")

    def suited(self, stretch: float) -> SingularitySubtraction:
        """The same rule for all shapes, as in the thesis."""
        return self


SelfRule = PolarRule | SingularitySubtraction


@dataclass(frozen=True, eq=False)
class NearNodes:
    """Nodes around one point, and where the grid's weights change there.

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
    """A grid on the circle or sphere, and what is needed near a target.

    ``axes`` of the grid and ``weights`` (*grid) for its own length or area; the window reaches
    over ``spacings`` of the grid (none for singularity subtraction) with a ``steepness``.
    """

    axes: list[Array]
    weights: Array
    spacings: float
    steepness: float

    @property
    def radius(self) -> float:
        """Of the window, as an angle."""
        step = max(float(axis[1] - axis[0]) for axis in self.axes)
        return min(self.spacings * step, pi)

    def near(self, centre: Array, distance: float = 0.0) -> NearNodes:
        """Nodes for a target whose nearest point has the parameters ``centre`` (p,).

        ``distance`` of the target in angles of the circle or sphere, 0 if it is a surface point.
        """
        away = self._away(centre)
        places = [np.ascontiguousarray(p) for p in np.nonzero(away < self.radius)]
        share = away[*places] / self.radius
        corrections = -self.weights[*places] * _window(share, self.steepness)
        parameters, weights = self._polar(centre, distance)
        rows = np.zeros_like(places[0]) if len(places) == 1 else places[0]
        return NearNodes(parameters, weights, rows, places[-1], corrections)

    def _away(self, centre: Array) -> Array:
        """Angles (*grid) between the centre and the grid's nodes."""
        if len(self.axes) == 1:
            return np.abs((self.axes[0] - centre[0] + pi) % (2 * pi) - pi)
        return _angle(centre[0], centre[1], self.axes[0][:, None], self.axes[1])

    def _polar(self, centre: Array, distance: float) -> tuple[Array, Array]:
        """Parameters (p, K) and weights (K,) in the window."""
        reach, weights = self._radial(distance)
        weights = weights * _window(reach / self.radius, self.steepness)
        if len(self.axes) == 1:
            sides = np.concatenate([centre[0] - reach, centre[0] + reach])
            return sides[None], np.concatenate([weights, weights])
        around = ceil(3.5 * self.spacings)
        directions = (np.arange(around) + 0.5) * 2 * pi / around
        reaches, angles = (g.ravel() for g in np.meshgrid(reach, directions, indexing="ij"))
        weights = np.repeat(weights * np.sin(reach) * 2 * pi / around, around)
        return _around(centre[0], centre[1], reaches, angles), weights

    def _radial(self, distance: float) -> tuple[Array, Array]:
        """Nodes and weights over 0 ... radius: for logarithms on a curve, else ordinary ones,
        crowded like ρ = d sinh t for a target at a distance d."""
        if distance == 0.0 and len(self.axes) == 1:
            unit, weights = log_unit(2 * ceil(self.steepness**2) + 8)
            return self.radius * unit, self.radius * weights
        order, top = 1.5 * self.spacings, 0.0
        if distance > 0.0:
            top = asinh(self.radius / distance)
            order += 1.5 * top
        unit, weights = gauss_unit(min(ceil(order), MAX_ORDER))
        if distance == 0.0:
            return self.radius * unit, self.radius * weights
        return distance * np.sinh(top * unit), top * weights * distance * np.cosh(top * unit)


@lru_cache(maxsize=32)
def closed_rule(rule: SelfRule, shape: tuple[int, ...]) -> ClosedRule:
    """The rule for (n,) collocation points on the circle, or (rows, columns) on the sphere."""
    if isinstance(rule, SingularitySubtraction):
        return _gauss_grid(rule.order, shape)
    grid = _even_grid(rule.refinement, shape)
    digits = -log(rule.tolerance)
    # erfc(s) falls like exp(-s²); the grid resolves the window's spectrum exp(-(πS/2s)²)
    window = {"steepness": sqrt(digits), "spacings": digits / (pi / 2)}
    phi = 2 * pi / grid[-1] * np.arange(0.5, grid[-1])
    theta = [pi / n * np.arange(0.5, n) for n in grid[:-1]]
    return ClosedRule([*theta, phi], even_weights(tuple(grid)), **window)


def _even_grid(refinement: int, shape: tuple[int, ...]) -> list[int]:
    """Nodes in each direction: ``refinement`` for a collocation point where these are as far apart
    in both directions, and otherwise as many as make the nodes so.

    The polar nodes in a window are as far apart as the grid's, in all directions; a direction with
    closer collocation points than nodes would be integrated blindly, and its short waves grow.
    """
    turns = [2 * shape[0], shape[1]] if len(shape) == 2 else list(shape)
    finest = max(turns)
    evens = [2 * max(round(refinement * finest / turn / 2), refinement // 2) for turn in turns]
    return [even * n for even, n in zip(evens, shape, strict=True)]


def even_weights(shape: tuple[int, ...]) -> Array:
    """Weights (*shape) of evenly spaced points for the unit circle's length or sphere's area."""
    even = np.full(shape[-1], 2 * pi / shape[-1])
    return even if len(shape) == 1 else np.outer(fejer_weights(shape[0]), even)


def _gauss_grid(order: int, shape: tuple[int, ...]) -> ClosedRule:
    phi, weights = gauss_on_breaks(order, np.linspace(0, 2 * pi, shape[-1] + 1))
    if len(shape) == 1:
        return ClosedRule([phi], weights, 0.0, 1.0)
    theta, row_weights = gauss_on_breaks(order, np.linspace(0, pi, shape[0] + 1))
    return ClosedRule([theta, phi], np.outer(row_weights * np.sin(theta), weights), 0.0, 1.0)


def fejer_weights(count: int) -> Array:
    """Weights of ∫ f(θ) sin θ dθ over 0 ... π at θ_j = (j + 1/2) π / count (Fejér's first rule)."""
    theta = (np.arange(count) + 0.5) * pi / count
    k = np.arange(1, count // 2 + 1)
    return 2 / count * (1 - 2 * (np.cos(2 * np.outer(theta, k)) / (4 * k**2 - 1)).sum(axis=1))


def _window(share: Array, steepness: float) -> Array:
    """From 1 to 0 over 0 ... 1."""
    inside = np.clip(share, 0.0, 1.0)
    return np.where(share < 1, 0.5 * erfc(steepness * (2 * inside - 1)), 0.0)


def _angle(theta: float, phi: float, other_theta: Array, other_phi: Array) -> Array:
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
