"""Numbers that are asked of a solution, as linear functionals of its boundary fields."""

from __future__ import annotations

from dataclasses import dataclass

from cadbem.spline.basis import Array

MEAN_PRESSURE, FLOW_RATE = "mean pressure", "flow rate"
FORCES = ("x force", "y force", "z force")


@dataclass(frozen=True, eq=False)
class Functional:
    """J = value_weights · u + flux_weights · f for coefficients (components, F) of a solution's
    value u and flux f.

    ``kind`` and ``place`` say what it is ("flow rate" of "outlet"), ``value`` is J of the solution,
    ``scale`` the size that errors are compared with; estimates of its errors are
    multiplied by ``safety``.
    """

    kind: str
    place: str
    value: float
    scale: float
    value_weights: Array
    flux_weights: Array
    safety: float = 1.0

    @property
    def name(self) -> str:
        """What it is, in words."""
        return f"{self.kind} '{self.place}'" if self.place else self.kind
