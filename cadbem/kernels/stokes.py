"""The kernels of Stokes flow by dimension."""

from __future__ import annotations

from cadbem.kernels.kernel import Kernel
from cadbem.kernels.stokes_2d import STOKES_2D, STOKES_PRESSURE_2D
from cadbem.kernels.stokes_3d import STOKES_3D, STOKES_PRESSURE_3D


def stokes_kernels(dimension: int) -> tuple[Kernel, Kernel]:
    """Velocity and pressure in 2 or 3 dimensions."""
    if dimension == 2:
        return STOKES_2D, STOKES_PRESSURE_2D
    return STOKES_3D, STOKES_PRESSURE_3D
