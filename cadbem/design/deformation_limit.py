"""The largest capillary number at which the deformation of a droplet stays below a limit."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from math import exp, isfinite, log

from scipy.optimize import brentq

from cadbem.checks import finite, positive, whole, within
from cadbem.errors import CadbemError, InputError
from cadbem.spline.closed_shapes import spline_sphere
from cadbem.suspension.bodies.droplet import Droplet
from cadbem.suspension.interface.laws import capillary_tension
from cadbem.suspension.multibody.measures import taylor_deformation
from cadbem.suspension.surroundings.flows import shear
from cadbem.suspension.surroundings.free_flow import FreeFlow
from cadbem.suspension.time.simulation import Simulation
from cadbem.suspension.time.state import State

WIDEN = 1.5  # factor by which a bracket grows
WIDEST = 30  # times that it may


def small_deformation(capillary: float, viscosity_ratio: float = 1.0) -> float:
    """Taylor's steady D = (19 λ + 16) / (16 λ + 16) Ca of a droplet in weak shear flow."""
    return capillary * (19 * viscosity_ratio + 16) / (16 * viscosity_ratio + 16)


def largest_deformation(states: Iterable[State]) -> float:
    """The largest D of the first droplet in a run; inf if it ended early, but by leaving."""
    largest = 0.0
    for state in states:
        if state.stopped and not state.left:
            return float("inf")
        if state.droplets:
            largest = max(largest, taylor_deformation(state.droplet.shape))
    return largest


@dataclass(frozen=True)
class ShearDeformation:
    """Ca -> the largest D of a droplet in unbounded shear flow up to ``end``, a time in inverse
    shear rates, looked at ``every`` so often; inf where it breaks up."""

    viscosity_ratio: float = 1.0
    end: float = 10.0
    points: int = 200
    every: float = 0.5

    def __post_init__(self) -> None:
        for name in ("viscosity_ratio", "end", "every"):
            positive(name, getattr(self, name))
        whole("points", self.points)

    def __call__(self, capillary: float) -> float:
        """The deformation at a capillary number."""
        shape = spline_sphere(points=self.points)
        drop = Droplet(shape, capillary_tension(capillary), self.viscosity_ratio)
        return largest_deformation(Simulation(FreeFlow(shear()), drop).run(self.end, self.every))


def largest_capillary(
    limit: float,
    deformation: Callable[[float], float] | None = None,
    guess: float | None = None,
    tolerance: float = 1e-3,
) -> float:
    """The Ca at which a ``deformation``, a function of Ca that grows with it, reaches a ``limit``.

    By default that of a droplet of the outer fluid's viscosity in shear flow; any other function
    will do, such as one that sends a droplet through a channel.  It may return inf, where the
    droplet breaks up.  ``tolerance`` is relative.  The search begins at the ``guess``, by default
    where Taylor's formula for λ = 1 has the limit.  Raises ``InputError`` for a limit that is
    not between 0 and 1, ``CadbemError`` when the function does not reach the limit.
    """
    if not 0 < finite("limit", limit) < 1:
        raise InputError(f"limit is {limit}; give a deformation D between 0 and 1")
    within("tolerance", tolerance, 1e-12, 0.5)
    if guess is not None:
        positive("guess", guess)
    measured = deformation or ShearDeformation()
    known: dict[float, float] = {}

    def excess(logarithm: float) -> float:
        if logarithm not in known:
            found = measured(exp(logarithm))
            known[logarithm] = min(found if isfinite(found) else 1.0, 1.0) - limit
        return known[logarithm]

    start = log(guess or limit / small_deformation(1.0))
    low, high = _bracket(excess, start, limit)
    return exp(brentq(excess, low, high, xtol=tolerance))


def _bracket(excess: Callable[[float], float], start: float, limit: float) -> tuple[float, float]:
    """Logarithms of Ca on either side of the limit."""
    step = log(WIDEN) if excess(start) < 0 else -log(WIDEN)
    near = start
    for _ in range(WIDEST):
        far = near + step
        if excess(far) * step >= 0:
            return min(near, far), max(near, far)
        near = far
    raise CadbemError(
        f"no capillary number between {exp(min(start, near)):.3g} and "
        f"{exp(max(start, near)):.3g} makes D = {limit:g}; give another limit or guess"
    )
