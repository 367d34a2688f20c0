"""True D(τ) of droplets that start round, from a spectral computation with many more unknowns."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cadbem.spline.basis import Array
from cadbem.suspension.time.history import History


@dataclass(frozen=True, eq=False)
class TrueSeries:
    """Taylor's D (N,) at ``times`` τ (N,), and its ``steady`` value."""

    times: Array
    deformation: Array
    steady: float

    def during(self, run: History) -> tuple[Array, Array]:
        """Times and D as long as a run lasts."""
        shown = self.times < run.last.time + 1e-9
        return self.times[shown], self.deformation[shown]


# Ca = 0.2, λ = 1, in shear flow
SHEAR = TrueSeries(
    np.linspace(0.5, 10.0, 20),
    np.array([
        0.1479217042, 0.1959248623, 0.2130056469, 0.2194107731, 0.2218200897, 0.2226977248,
        0.2229987141, 0.2230923556, 0.223116648, 0.2231203087, 0.2231191392, 0.2231175828,
        0.2231165326, 0.2231159536, 0.2231156669, 0.2231155348, 0.2231154774, 0.2231154537,
        0.2231154444, 0.223115441,
    ]),
    0.2231154,
)  # fmt: skip
# the same between plates, R / W = 0.8
PLATES = TrueSeries(
    np.linspace(0.5, 5.0, 10),
    np.array([
        0.1802094836, 0.2706801508, 0.3172750638, 0.3412488867, 0.3528801206, 0.3576084166,
        0.3585521915, 0.3575895292, 0.3558567718, 0.3540075483,
    ]),
    0.34884,
)  # fmt: skip
# in a plane, with a Ca of 0.1
PLANE_SHEAR = TrueSeries(
    np.linspace(0.0, 8.0, 41),
    np.array([
        0.0, 0.0631338306, 0.086309021, 0.094763684, 0.09777375, 0.0988043437, 0.0991390131,
        0.099239957, 0.0992670106, 0.0992726634, 0.0992729972, 0.0992724401, 0.0992719804,
        0.0992717195, 0.0992715918, 0.0992715345, 0.0992715102, 0.0992715004, 0.0992714966,
        0.0992714951, 0.0992714946, 0.0992714944, 0.0992714944, 0.0992714944, 0.0992714944,
        0.0992714944, 0.0992714944, 0.0992714944, 0.0992714944, 0.0992714944, 0.0992714944,
        0.0992714944, 0.0992714944, 0.0992714944, 0.0992714944, 0.0992714944, 0.0992714944,
        0.0992714944, 0.0992714944, 0.0992714944, 0.0992714944,
    ]),
    0.09927149436486744,
)  # fmt: skip
# λ = 10 in uniaxial extension: Ca and the steady D
EXTENSION = (0.05, 0.10185286053533336)
