"""Time stepping of an array of coordinates, with few evaluations of its rate.

Capillary relaxation is stiff with real negative rates, the largest growing with the number of
points.  The default method is therefore a stabilised explicit one, Runge-Kutta-Chebyshev of second
order (Sommeijer, Shampine and Verwer 1997): s stages are stable for steps of about 0.65 s² over the
largest rate.  Rigid particles alone have no such rates; they take the steps of order 5 of Dormand
and Prince.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from math import ceil, sqrt

import numpy as np
from numpy.polynomial.chebyshev import Chebyshev
from scipy.integrate import RK45

from cadbem.spline.basis import Array

Rate = Callable[[Array], Array]
DAMPING = 2 / 13


@dataclass(frozen=True, eq=False)
class Step:
    """The result of an attempted step: the new ``state``, its ``slope`` if known, the estimated
    ``error`` (an array like the state) and its power of the step's length, and the ``evaluations``
    spent."""

    state: Array
    slope: Array | None
    error: Array
    evaluations: int
    power: int = 3


@dataclass(frozen=True)
class Euler:
    """Explicit Euler with a fixed ``step``, as in the thesis."""

    step: float

    def attempt(
        self, rate: Rate, state: Array, slope: Array, length: float, largest: float
    ) -> Step:
        """One step of the given length."""
        return Step(state + length * slope, None, np.zeros_like(state), 0)

    def first_length(self, largest: float) -> float:
        """Length of the first step."""
        return self.step

    def next_length(self, length: float, error: float, power: int) -> tuple[bool, float]:
        """Whether a step is accepted, and the length of the next attempt."""
        return True, self.step

    def bound(self, largest: float) -> float:
        """Longest step: the user's own."""
        return self.step


@dataclass(frozen=True)
class Adaptive:
    """Runge-Kutta-Chebyshev steps with an estimated error below ``tolerance`` each, relative to
    the body's size; ``longest`` bounds the length, ``stages`` the evaluations of a step."""

    tolerance: float = 1e-3
    longest: float = np.inf
    stages: int = 12

    def attempt(
        self, rate: Rate, state: Array, slope: Array, length: float, largest: float
    ) -> Step:
        """One step; ``slope`` is the rate at its beginning, ``largest`` the fastest decay rate."""
        if largest == 0.0:
            return dormand_prince(rate, state, slope, length)
        stages = min(max(2, 1 + ceil(sqrt(1 + 1.54 * length * largest))), self.stages)
        coefficients = chebyshev_coefficients(stages)
        before, current = state, state + coefficients[0] * length * slope
        for j in range(1, stages):
            mix, previous, new, first = coefficients[1][j - 1]
            change = rate(current)
            following = (
                (1 - mix - previous) * state
                + mix * current
                + previous * before
                + length * (new * change + first * slope)
            )
            before, current = current, following
        end = rate(current)
        error = 0.8 * (state - current) + 0.4 * length * (slope + end)
        return Step(current, end, error, stages)

    def first_length(self, largest: float) -> float:
        """Length of the first step: one that plain Euler could take."""
        return min(1.0 / max(largest, 1e-12), self.longest)

    def next_length(self, length: float, error: float, power: int) -> tuple[bool, float]:
        """Whether a step is accepted, and the length of the next attempt.

        The ``error`` is proportional to the length to a ``power``."""
        share = error / self.tolerance
        factor = min(max(0.8 * max(share, 1e-9) ** (-1 / power), 0.2), 2.0)
        return share <= 1.0, min(length * factor, self.longest)

    def bound(self, largest: float) -> float:
        """Longest step that is stable with the allowed stages."""
        return 0.65 * (self.stages**2 - 1) / max(largest, 1e-12)


Stepper = Euler | Adaptive


def dormand_prince(rate: Rate, state: Array, slope: Array, length: float | Array) -> Step:
    """A step of order 5 with an error estimate of order 4, by SciPy's coefficients.

    The ``length`` may be one number or an array that goes with the ``state``."""
    slopes = [slope]
    for row in RK45.A[1:]:
        slopes.append(rate(state + length * np.tensordot(row[: len(slopes)], slopes, 1)))
    end = state + length * np.tensordot(RK45.B, slopes, 1)
    slopes.append(rate(end))
    error = length * np.tensordot(RK45.E, slopes, 1)
    return Step(end, slopes[-1], error, len(slopes) - 1, power=5)


@lru_cache(maxsize=64)
def chebyshev_coefficients(stages: int) -> tuple[float, list[tuple[float, ...]]]:
    """Coefficients of the method with s stages: μ~_1, and (μ, ν, μ~, γ~) for j = 2 ... s."""
    w0 = 1 + DAMPING / stages**2
    value = [Chebyshev.basis(j) for j in range(stages + 1)]
    t = [p(w0) for p in value]
    d = [p.deriv(1)(w0) for p in value]
    dd = [p.deriv(2)(w0) for p in value]
    w1 = d[stages] / dd[stages]
    b = [dd[j] / d[j] ** 2 if j > 1 else 0.0 for j in range(stages + 1)]
    b[0] = b[1] = b[2]
    a = [1 - b[j] * t[j] for j in range(stages + 1)]
    rows: list[tuple[float, ...]] = []
    for j in range(2, stages + 1):
        mix, previous = 2 * b[j] * w0 / b[j - 1], -b[j] / b[j - 2]
        new = 2 * b[j] * w1 / b[j - 1]
        rows.append((float(mix), float(previous), float(new), float(-a[j - 1] * new)))
    return float(b[1] * w1), rows
