"""The openings through which droplets leave, and when."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from cadbem.spline.basis import Array
from cadbem.suspension.bodies.droplet import Droplet
from cadbem.suspension.time.history import History, record
from cadbem.suspension.time.simulation import Simulation
from cadbem.tables import text_table
from cadbem.units import Units


@dataclass(frozen=True, eq=False)
class Fate:
    """The fate of one droplet: the ``opening`` through which it left at a ``time``, or "" and
    why the run ``ended``; its ``path`` (dim, N) of centres at the ``times`` (N,), the largest
    ``deformation`` D and the narrowest ``gap`` among the states kept, inf where it was wide."""

    droplet: Droplet
    opening: str
    time: float
    ended: str
    times: Array
    path: Array
    deformation: float
    gap: float

    @property
    def radius(self) -> float:
        """The droplet's radius, from its volume."""
        return float((3 * self.droplet.volume / (4 * np.pi)) ** (1 / 3))


def droplet_fate(simulation: Simulation, end: float, every: float | None = None) -> Fate:
    """The fate of the one droplet of a ``simulation``, which is run up to a time ``end``.

    The states of each multiple of ``every``, by default of all steps, are looked at.  Raises what
    ``Simulation.run`` raises.
    """
    return fate_of(record(simulation.run(end, every)))


def fate_of(run: History) -> Fate:
    """The fate of the droplet of a ``run`` with one body, from the states that were kept."""
    last = run.last
    times, path = run.track()
    return Fate(
        droplet=run.states[0].droplet,
        opening=last.gaps[0].opening if last.left else "",
        time=last.time,
        ended=last.stopped or f"still inside at time {last.time:.4g}",
        times=times,
        path=path,
        deformation=float(run.deformation.max()),
        gap=min(state.gaps[0].length for state in run.states),
    )


def droplet_fates(
    simulation: Simulation, droplets: Iterable[Droplet], end: float, every: float | None = None
) -> list[Fate]:
    """The fates of several ``droplets``, each alone in the flow of the ``simulation``."""
    return [droplet_fate(replace(simulation, bodies=d), end, every) for d in droplets]


def fates_report(fates: Sequence[Fate], units: Units, tracers: Sequence[str]) -> str:
    """A table of droplets: radius, x at the start, how they left and when, largest D, narrowest
    gap; ``tracers`` names the openings through which points of fluid of the same starts left."""
    rows = []
    for fate, other in zip(fates, tracers, strict=True):
        gap = units.show(fate.gap, "length") if np.isfinite(fate.gap) else "-"
        start = f"{fate.path[0, 0]:+.3f} {units.length}"
        rows.append([
            units.show(fate.radius, "length"), start, fate.opening or "none",
            units.show(fate.time, "time"), f"{fate.deformation:.3f}", gap, other or "-",
        ])  # fmt: skip
    head = ("droplet", "off the axis", "left through", "after", "largest D", "gap", "a tracer")
    ended = [
        f"{units.show(f.radius, 'length')} from {f.path[0, 0]:+.3f} {units.length}: {f.ended}"
        for f in fates
        if not f.opening
    ]
    return "\n".join([text_table(head, rows), *ended])
