"""Checks of the thesis's benchmark III: Stokes flow in channels of rectangular section.

x is along the channel, which is 2 long; the mean velocity and the viscosity are 1.  True values are
sums of the Fourier series of the developed flow (Eq. 2.53 and 2.55, corrected).
"""

from __future__ import annotations

from functools import cache

import numpy as np

from cadbem.boundary import Boundary, Patch
from cadbem.problems.conditions import Condition, Inflow, NoSlip, Pressure
from cadbem.problems.profiles import rectangle_profile
from cadbem.problems.solution import StokesSolution
from cadbem.problems.stokes import StokesProblem
from cadbem.quadrature import Quadrature
from cadbem.spline.shapes import box
from cadbem.verification.check import Check

SERIES = "Fourier series of the developed flow"
LENGTH = 2.0
GRADIENT = 28.454153769562279  # -dp/dx of a square channel, in viscosity U / W²


def checks() -> tuple[Check, ...]:
    """Of what enters, of the pressure's gradient, and of the velocity at the outlet."""
    return (
        Check("Figure 2.16", "square channel: largest velocity at the outlet",
              lambda: outlet_velocity(1.0), 2.0962560146839407, 1e-3, SERIES),
        Check("Figure 2.17", "square channel: net flux / inflow (Eq. 2.54a)",
              lambda: duct(1.0).net_flux(), 0.0, 1e-12, "what enters leaves"),
        Check("Figure 2.17", "square channel: net force / forces (Eq. 2.54b)",
              lambda: duct(1.0).net_force(), 0.0, 1e-5, "no inertia, no net force"),
        Check("Figure 2.18", "square channel: pressure gradient",
              lambda: gradient(1.0), GRADIENT, 5e-5, SERIES),
        Check("Eq. 2.55", "channel twice as wide as high: pressure gradient",
              lambda: gradient(2.0), 17.491563164933937, 5e-4, SERIES),
        Check("Figure 2.16", "channel twice as wide as high: largest velocity",
              lambda: outlet_velocity(2.0), 1.9917963443609719, 5e-3, SERIES),
    )  # fmt: skip


@cache
def duct(width: float) -> StokesSolution:
    """A channel of height 1, degree 2, with small elements at its long edges."""
    names = ("inlet", "outlet", "walls", "walls", "walls", "walls")
    sides = box((-LENGTH / 2, -width / 2, -0.5), (LENGTH / 2, width / 2, 0.5))
    patches = [Patch(s, n, i + 1) for i, (s, n) in enumerate(zip(sides, names, strict=True))]
    boundary = Boundary(tuple(patches)).elevated(2).refined(size=(LENGTH, width / 6, 1 / 6))
    boundary = boundary.graded(2, 0.5, toward=lambda x, inward: abs(inward[0]) < 0.5)
    given: dict[str, Condition] = {
        "inlet": Inflow(mean_velocity=1.0),
        "outlet": Pressure(0.0),
        "walls": NoSlip(),
    }
    return StokesProblem(boundary, 1.0, given, quadrature=Quadrature(1e-9)).solve()


def gradient(width: float) -> float:
    """-dp/dx from the mean pressures at both ends."""
    flow = duct(width)
    return (flow.mean_pressure("inlet") - flow.mean_pressure("outlet")) / LENGTH


def outlet_velocity(width: float) -> float:
    """In the middle of the outlet."""
    return float(duct(width).velocity_at([[LENGTH / 2], [0.0], [0.0]])[0, 0])


def error_at_outlet(solution: StokesSolution) -> float:
    """Largest error of the velocity in a square channel on the thesis's line (x, z) = (1, -0.047),
    |y| < 0.45."""
    y = np.linspace(-0.45, 0.45, 21)
    line = np.array([np.full_like(y, LENGTH / 2), y, np.full_like(y, -0.047)])
    exact = rectangle_profile(y, line[2], 1.0, 1.0)
    return float(abs(solution.velocity_at(line)[0] - exact).max())
