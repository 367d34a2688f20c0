"""Checks of the thesis's section 4.2: droplets between plates.

R / W is the radius over half the distance of the plates.  True values come from a spectral
computation: a droplet that starts as a sphere, Ca = 0.2, λ = 1, R / W = 0.8.
"""

from __future__ import annotations

from functools import cache, partial

import numpy as np

from cadbem.spline.closed_shapes import spline_sphere
from cadbem.suspension.bodies.droplet import Droplet
from cadbem.suspension.interface.laws import capillary_tension
from cadbem.suspension.surroundings.flows import shear
from cadbem.suspension.surroundings.free_flow import FreeFlow
from cadbem.suspension.surroundings.surroundings import Surroundings
from cadbem.suspension.time.history import History, record
from cadbem.suspension.time.simulation import Simulation
from cadbem.suspension.time.stepping import Adaptive
from cadbem.verification.check import Check
from cadbem.verification.plates import between_plates
from cadbem.verification.theory import shapira_haber

SPECTRAL = "spectral computation"
EARLY = {0.5: 0.1802094836, 1.0: 0.2706801508, 1.5: 0.3172750638}  # D(τ)
FINE = {"spans": 8, "rings": 2}


def checks() -> tuple[Check, ...]:
    """Of the way to the overshoot, of the steady shape, and of plates far away."""
    place = "Figure 4.8"
    early = tuple(
        Check(place, f"D({tau:g}), Ca = 0.2, λ = 1, R / W = 0.8", partial(_early, tau), true, 1e-2,
              SPECTRAL)
        for tau, true in EARLY.items()
    )  # fmt: skip
    added = shapira_haber(0.05, 1.0, 0.4) / shapira_haber(0.05, 1.0, 0.0) - 1
    return (
        *early,
        Check(place, "largest D", lambda: float(overshoot().deformation.max()), 0.3586, 2e-3,
              SPECTRAL, 0.3548, long=True),
        Check(place, "steady D", lambda: float(overshoot().deformation[-1]), 0.34884, 2e-3,
              SPECTRAL, 0.3461, long=True),
        Check("Figure 4.7", "what plates add to D, R / W = 0.4, Ca = 0.05", added_by_plates, added,
              0.05, "Shapira and Haber, small Ca", long=True),
    )  # fmt: skip


def run(
    flow: Surroundings, points: int, capillary: float, end: float, every: float, degree: int = 4
) -> History:
    """A droplet that is round at first, λ = 1."""
    shape = spline_sphere(points=points, degree=degree)
    droplet = Droplet(shape, capillary_tension(capillary))
    return record(Simulation(flow, droplet, Adaptive(1e-3)).run(end, every=every))


@cache
def _start() -> History:
    return run(between_plates(1.25, 6.0, spans=6, rings=1), 128, 0.2, max(EARLY), 0.5)


def _early(tau: float) -> float:
    history = _start()
    return float(history.deformation[np.isclose(history.times, tau)][0])


@cache
def overshoot() -> History:
    """All the way to the steady shape."""
    return run(between_plates(1.25, 12.0, **FINE), 200, 0.2, 14.0, 0.1, degree=6)


def added_by_plates() -> float:
    """D between plates over that without, less 1."""
    flows = between_plates(2.5, 12.0, **FINE), FreeFlow(shear())
    bounded, free = (run(flow, 200, 0.05, 3.0, 3.0).deformation[-1] for flow in flows)
    return float(bounded / free - 1)
