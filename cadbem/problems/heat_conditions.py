"""Boundary conditions of heat conduction, as values.

Temperature φ and the heat flux q that flows INTO the body, per area and time.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from cadbem.checks import finite, values_at
from cadbem.errors import ConditionError
from cadbem.problems.mixed import Given, Split
from cadbem.spline.basis import Array

Scalar = float | Callable[[Array], Array]
ONE, ZERO = np.ones((1, 1)), np.zeros((1, 1))


@dataclass(frozen=True)
class Temperature:
    """Temperature given as a number, or as a function of positions (dim, N) -> (N,)."""

    value: Scalar

    def __post_init__(self) -> None:
        _check("Temperature", self.value)


@dataclass(frozen=True)
class HeatFlux:
    """Heat that flows into the body per area, number or function; 0: insulated, or symmetry."""

    value: Scalar = 0.0

    def __post_init__(self) -> None:
        _check("HeatFlux", self.value)


@dataclass(frozen=True)
class SurfaceExchange:
    """Convection and radiation: heat h(φ - φ∞) + εσ(φ⁴ - φ∞⁴) leaves the body per area.

    ``convection`` h, ``radiation`` εσ (emissivity times Stefan-Boltzmann constant), ``ambient``
    φ∞, absolute wherever there is radiation.  Raises ``ConditionError`` for negative values or
    when nothing is exchanged.
    """

    convection: float = 0.0
    radiation: float = 0.0
    ambient: float = 0.0

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            finite(name, value)
        if min(self.convection, self.radiation) < 0 or self.convection + self.radiation == 0:
            raise ConditionError(
                f"{self!r}: convection and radiation must not be negative, nor both zero; "
                "give HeatFlux(0) for an insulated face"
            )
        if self.radiation > 0 and self.ambient < 0:
            raise ConditionError(f"{self!r}: radiation asks for absolute temperatures")

    def loss(self, temperature: Array) -> Array:
        """Heat that leaves the body per area.

        φ|φ|³ stands for φ⁴, so that iterates below zero still cool less than warmer ones.
        """
        quartic = temperature * abs(temperature) ** 3 - self.ambient**4
        return self.convection * (temperature - self.ambient) + self.radiation * quartic

    def loss_slope(self, temperature: Array) -> Array:
        """Derivative of ``loss``."""
        return self.convection + 4 * self.radiation * abs(temperature) ** 3


HeatCondition = Temperature | HeatFlux | SurfaceExchange


def split_heat(condition: HeatCondition, slope: float) -> Split:
    """The known and unknown parts of a condition on a patch.

    Convection mixes φ and q.  Where there is radiation too, q = -slope φ + g with a positive
    ``slope`` of any size, and g remains to be found by Newton's method.
    """
    match condition:
        case Temperature(value):
            return Split(_given("Temperature", value), None, ZERO, ONE)
        case HeatFlux(value):
            return Split(None, _given("HeatFlux", value), ONE, ZERO)
        case SurfaceExchange(convection, 0.0, ambient):
            return Split(None, _given("ambient", convection * ambient), ONE, -convection * ONE)
        case SurfaceExchange():
            return Split(None, None, ONE, -slope * ONE)


def _check(name: str, value: Scalar) -> None:
    if not callable(value):
        finite(name, value)


def _given(name: str, value: Scalar) -> Given:
    if callable(value):
        return lambda points: values_at(name, value(points.position), (points.count,))[None]
    return lambda points: np.full((1, points.count), float(value))
