"""The accuracy of boundary integrals: rules and orders for a tolerance."""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil, log, log10, sinh, sqrt

import numpy as np
from numpy.typing import NDArray

from cadbem.checks import within

Array = NDArray[np.float64]

STEEP = 12  # order from which tensor rules need room for higher powers of 1/r
HIGHER = 0, 3, 7, 13, 22, 36  # orders of the tensor rules beyond the one for far panels


@dataclass(frozen=True)
class Quadrature:
    """``tolerance`` of each element's integrals, at any distance of the target.

    It is relative to the integral of the kernel alone: functions are at most 1.

    Raises ``ValueError`` unless 1e-14 <= tolerance <= 1e-2.
    """

    tolerance: float = 1e-8

    def __post_init__(self) -> None:
        within("Quadrature's tolerance", self.tolerance, 1e-14, 1e-2)

    def orders(self, degree: int) -> tuple[int, ...]:
        """Gauss orders of the tensor rules, for far panels first; they grow with the degree."""
        far = ceil(degree / 2 + 1 - 0.6 * log10(self.tolerance))
        return tuple(far + more for more in HIGHER)

    def far_orders(self, degree: int) -> tuple[int, ...]:
        """Orders up to the first of these, the lowest for panels farthest away."""
        return tuple(range(min(ceil(degree / 2) + 2, far := self.orders(degree)[0]), far + 1))

    def reach(self, order: int, degree: int) -> float:
        """Distance over panel length from which a tensor rule of this order is good enough.

        The nearest singularity of 1/r lies at ±i 2d/L over the interval [-1, 1], so the error
        falls like exp(-2 m asinh(2d/L)); densities of a degree use up half of it in order.  High
        orders come so near that powers of 1/r grow the error with the square of the order.
        """
        digits = -log(self.tolerance) + 5.0 + 2.0 * log(max(order, STEEP) / STEEP)
        return 0.5 * sinh(digits / (2.0 * (order - degree / 2)))

    @property
    def order(self) -> int:
        """No fixed order."""
        return 0

    def pieces(self, lengths: Array, distances: Array) -> None:
        """No uniform subdivision."""


@dataclass(frozen=True)
class UniformSubdivision:
    """The thesis's choice: one Gauss ``order``, close elements cut evenly, at most ``limit``².

    An element longer than L = (3R/8) [m / (-0.1 √(2s/3 + 2/5) ln(e/2)) - 1]^(4/3) is cut, for a
    target at the distance R, a tolerance e and a singularity of order s = 2 (Eq. 2.41, Bu and
    Davies); own elements get plain polar coordinates.  For comparison: targets closer than about
    1/80 of an element are integrated wrongly, because of the limit.
    """

    order: int = 10
    tolerance: float = 1e-4
    limit: int = 20
    singularity: int = 2

    def orders(self, degree: int) -> tuple[int, ...]:
        """The one order."""
        return (self.order,)

    def far_orders(self, degree: int) -> tuple[int, ...]:
        """The same."""
        return (self.order,)

    def reach(self, order: int, degree: int) -> float:
        """Distance over element length from which an element is not cut."""
        need = -0.1 * sqrt(2 * self.singularity / 3 + 0.4) * np.log(self.tolerance / 2)
        return 1 / (0.375 * (self.order / need - 1) ** (4 / 3))

    def pieces(self, lengths: Array, distances: Array) -> NDArray[np.int64]:
        """Parts in each direction of elements (N,) at distances from their targets."""
        with np.errstate(divide="ignore"):
            wanted = np.ceil(lengths / distances * self.reach(self.order, 0))
        return np.clip(wanted, 1, self.limit).astype(np.int64)


Rules = Quadrature | UniformSubdivision
