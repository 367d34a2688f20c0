"""How accurately boundary integrals are computed."""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil, log, log10, sinh


@dataclass(frozen=True)
class Quadrature:
    """``tolerance`` of each element's integrals, at any distance of the target.

    It is relative to the integral of the kernel alone: functions are at most 1.

    Raises ``ValueError`` unless 1e-14 <= tolerance <= 1e-2.
    """

    tolerance: float = 1e-8

    def __post_init__(self) -> None:
        if not 1e-14 <= self.tolerance <= 1e-2:
            raise ValueError(f"quadrature tolerance {self.tolerance} is not in 1e-14 ... 1e-2")

    def orders(self, degree: int) -> tuple[int, ...]:
        """Gauss orders of the tensor rules, for far panels first; they grow with the degree."""
        far = ceil(degree / 2 + 1 - 0.6 * log10(self.tolerance))
        return far, far + 3, far + 7

    def reach(self, order: int, degree: int) -> float:
        """Distance over panel length from which a tensor rule of this order is good enough.

        The nearest singularity of 1/r lies at ±i 2d/L over the interval [-1, 1], so the error
        falls like exp(-2 m asinh(2d/L)); densities of a degree use up half of it in order.
        """
        digits = -log(self.tolerance) + 5.0
        return 0.5 * sinh(digits / (2.0 * (order - degree / 2)))
