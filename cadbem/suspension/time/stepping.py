"""Time stepping of an array of coordinates, with few evaluations of its rate.

Capillary relaxation is stiff with real negative rates, the largest growing with the tension and
with the number of points.  Where it is moderate, steps are of a stabilised explicit method,
Runge-Kutta-Chebyshev of second order (Sommeijer, Shampine and Verwer 1997): s stages are stable for
steps of about 0.65 s² over the largest rate.  Where it is not, they are linearly implicit
(``rosenbrock``), if the relaxation is known nearly enough.  Both lengths follow from estimated
errors; of the two methods that one takes the next step that needs fewer evaluations for the time.
Rigid particles alone do not relax; they take the steps of order 5 of Dormand and Prince.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache
from math import ceil, sqrt

import numpy as np
from numpy.polynomial.chebyshev import Chebyshev
from scipy.integrate import RK45

from cadbem.checks import positive, whole, within
from cadbem.spline.basis import Array
from cadbem.suspension.time.rosenbrock import (
    GAMMA,
    START,
    WEIGHTS,
    WEIGHTS_LOW,
    Damping,
    rosenbrock_stages,
)

Rate = Callable[[Array], Array]
Relaxing = Callable[[float], Damping]  # s -> (I - s A)^-1 with the rates A of relaxation
DAMPING = 2 / 13
IMPLICIT_COST = 6.0  # evaluations of a linearly implicit step: 4, and a margin for failed ones
RECOVERY = 1.1  # growth, a step, of a length that was too long when it was last tried


@dataclass(frozen=True, eq=False)
class Step:
    """The result of an attempted step: the new ``state``, its ``slope`` if known, the estimated
    ``error`` (an array like the state) and its power of the step's length, and the ``evaluations``
    spent; ``ends`` are slopes at both ends for states between them, if not those of the rate."""

    state: Array
    slope: Array | None
    error: Array
    evaluations: int
    power: int = 3
    ends: tuple[Array, Array] | None = None


@dataclass(frozen=True)
class Lengths:
    """The lengths that the next step may have: an ``explicit`` and a linearly ``implicit`` one, and
    how long an implicit one is ``trusted`` to be stable."""

    explicit: float
    implicit: float
    trusted: float = np.inf


@dataclass(frozen=True)
class Errors:
    """What a step may have missed: of the ``whole`` displacement, relative to bodies' sizes, and of
    the ``shape`` of droplets, relative to how far they are from round."""

    whole: float
    shape: float


@dataclass(frozen=True)
class Euler:
    """Explicit Euler with a fixed ``step``, as in the thesis."""

    step: float

    def __post_init__(self) -> None:
        positive("Euler's step", self.step)

    def attempt(
        self, rate: Rate, state: Array, slope: Array, length: float, largest: float,
        relaxing: Relaxing | None = None,
    ) -> Step:  # fmt: skip
        """One step of the given length."""
        return Step(state + length * slope, None, np.zeros_like(state), 0)

    def first_lengths(self, largest: float) -> Lengths:
        """Lengths of the first step."""
        return Lengths(self.step, self.step)

    def next_lengths(
        self, lengths: Lengths, length: float, errors: Errors, power: int, implicit: bool
    ) -> tuple[bool, Lengths]:
        """Whether a step is accepted, and the lengths of the next attempt."""
        return True, lengths

    def choose(self, lengths: Lengths, longest: float, largest: float) -> tuple[bool, float]:
        """Whether the next step is implicit, which it is not, and its length."""
        return False, min(self.step, longest)


@dataclass(frozen=True)
class Adaptive:
    """Steps with an estimated error below ``tolerance`` each, relative to the body's size; that of
    implicit steps in shapes is relative to how far these are from round.

    ``longest`` bounds the length, ``stages`` the evaluations of a Runge-Kutta-Chebyshev step.
    """

    tolerance: float = 1e-3
    longest: float = np.inf
    stages: int = 12

    def __post_init__(self) -> None:
        within("Adaptive's tolerance", self.tolerance, 1e-14, 0.5)
        if self.longest != np.inf:
            positive("Adaptive's longest", self.longest)
        whole("Adaptive's stages", self.stages, 2)

    def attempt(
        self, rate: Rate, state: Array, slope: Array, length: float, largest: float,
        relaxing: Relaxing | None = None,
    ) -> Step:  # fmt: skip
        """One step: implicit with the rates of relaxation, explicit without; ``slope`` is the rate
        at its beginning, ``largest`` the fastest decay rate."""
        if relaxing is not None:
            return rosenbrock(rate, state, slope, length, relaxing(GAMMA * length))
        if largest == 0.0:
            return dormand_prince(rate, state, slope, length)
        return chebyshev(rate, state, slope, length, self._stages(length, largest))

    def _stages(self, length: float, largest: float) -> int:
        """Stages that make an explicit step stable, at most those allowed."""
        return min(max(2, 1 + ceil(sqrt(1 + 1.54 * length * largest))), self.stages)

    def first_lengths(self, largest: float) -> Lengths:
        """Lengths of the first step: one that plain Euler could take."""
        length = min(1.0 / max(largest, 1e-12), self.longest)
        return Lengths(length, length)

    def next_lengths(
        self, lengths: Lengths, length: float, errors: Errors, power: int, implicit: bool
    ) -> tuple[bool, Lengths]:
        """Whether a step of a ``length`` is accepted, and the lengths of the next attempt.

        Errors are proportional to the length to a ``power``.  An accepted step proposes the length
        of the other method, too.  The length of an implicit step that failed recovers slowly: the
        shape may be too far from round.
        """
        loose, strict = (
            self._following(length, e, power)
            for e in (errors.whole, max(errors.whole, errors.shape))
        )
        if implicit:
            if strict[0] > 1.0:
                return False, Lengths(lengths.explicit, strict[1], strict[1])
            return True, Lengths(strict[1], strict[1])
        if loose[0] > 1.0:
            return False, replace(lengths, explicit=loose[1])
        trusted = RECOVERY * lengths.trusted
        return True, Lengths(loose[1], min(strict[1], trusted), trusted)

    def _following(self, length: float, error: float, power: int) -> tuple[float, float]:
        """An error as a share of the tolerance, and the length that should follow."""
        share = error / self.tolerance
        factor = min(max(0.8 * max(share, 1e-9) ** (-1 / power), 0.2), 2.0)
        return share, min(length * factor, self.longest)

    def choose(self, lengths: Lengths, longest: float, largest: float) -> tuple[bool, float]:
        """Whether the next step is implicit, and its length, at most ``longest``: the method with
        more time for an evaluation; explicit steps must be stable with the allowed stages."""
        stable = 0.65 * (self.stages**2 - 1) / max(largest, 1e-12)
        explicit, implicit = min(lengths.explicit, stable, longest), min(lengths.implicit, longest)
        gain = explicit / self._stages(explicit, largest)
        if largest > 0.0 and implicit / IMPLICIT_COST > gain:
            return True, implicit
        return False, explicit


Stepper = Euler | Adaptive


def chebyshev(rate: Rate, state: Array, slope: Array, length: float, stages: int) -> Step:
    """A step of order 2 by as many evaluations as ``stages``, the last one of the slope at its
    end, with an error estimate."""
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


def rosenbrock(rate: Rate, state: Array, slope: Array, length: float, damping: Damping) -> Step:
    """A linearly implicit step of order 3 with an error estimate of order 2 and, for states
    between its ends, damped slopes there: those of the rate are off by what a tiny change of the
    state makes of them."""
    slopes = rosenbrock_stages(rate, state, slope, length, damping)
    error = length * ((WEIGHTS - WEIGHTS_LOW) @ slopes)
    ends = START @ slopes, (2 * WEIGHTS - START) @ slopes
    return Step(state + length * (WEIGHTS @ slopes), None, error, len(slopes) - 1, ends=ends)


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
