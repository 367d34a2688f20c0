"""Errors of heat conduction on finer and finer grids, and profiles along a ray."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field

import numpy as np

from cadbem.post.style.plots import Curve, Plot, fitted_order
from cadbem.problems.heat_solution import HeatSolution
from cadbem.spline.basis import Array
from cadbem.verification.heat import RADII

Profile = Callable[[Array], Array]


@dataclass(eq=False)
class Convergence:
    """``errors`` on grids with more and more points, by what was refined, ``label``.

    Orders are fitted to the last grids, ``window`` of them, or with 0 to all."""

    label: str
    window: int = 2
    counts: list[int] = field(default_factory=list)
    errors: list[float] = field(default_factory=list)

    def add(self, count: int, error: float) -> str:
        """One more grid; the order, or nothing for the first."""
        self.counts.append(count)
        self.errors.append(error)
        last = slice(-self.window, None)
        if len(self.counts) < 2:
            return ""
        return f"{fitted_order(self.counts[last], self.errors[last]):5.2f}"


def on_ray(direction: Array) -> Array:
    """25 points (dim, 25) through the wall."""
    return np.outer(direction, RADII)


def ray_error(solution: HeatSolution, direction: Array, exact: Profile) -> float:
    """Largest relative error of the temperatures there."""
    found = solution.temperature_at(on_ray(direction))
    return float(abs(found / exact(RADII) - 1).max())


def plots(
    found: Iterable[Convergence], label: str, solution: HeatSolution, ray: Array, exact: Profile
) -> list[Plot]:
    """Errors over points, and the temperature on a ray beside the exact one."""
    fine = np.linspace(1, 2, 101)
    profile = [
        Curve(fine, exact(fine), "exact"),
        Curve(RADII, solution.temperature_at(on_ray(ray)), "computed", line=False, marks=True),
    ]
    convergence = [Curve(c.counts, c.errors, c.label, marks=True) for c in found]
    return [
        Plot("collocation points", label, convergence, True),
        Plot("r / inner radius", "temperature / surroundings'", profile),
    ]
