"""Stokeslet, stresslet and their pressures in two dimensions, without any factor.

With r = x - x0 (source minus target):

    G_ij = -δ_ij ln r + r_i r_j / r²,   T_ijk n_k = -4 r_i r_j (r·n) / r⁴

(Pozrikidis 1992, ch. 2).  The velocity of a Stokes flow at x0 inside, n into the fluid, is
u = -(1/4πμ) ∫ G f ds + (1/4π) ∫ (T·n) u ds.  The pressure that belongs to it is
p = (1/4π) ∫ g·f ds + (μ/4π) ∫ h·u ds with

    g_j = 2 r_j / r²,   h_j = 4 (-n_j / r² + 2 r_j (r·n) / r⁴):

-∇p + μ∇²u = 0 holds for each column, as ∇² of a column of G (in x0, source fixed) is -∇g,
and that of one of T·n is ∇h.
"""

from __future__ import annotations

from math import log, pi

from cadbem.compiled import compiled
from cadbem.kernels.kernel import Kernel
from cadbem.kernels.stokes_sums import SUMS_2D


@compiled(fastmath=True, error_model="numpy")
def _velocity(targets, starts, stops, columns, position, normal, table):
    for t in range(targets.shape[1]):
        x, y = targets[0, t], targets[1, t]
        low, high = starts[t], stops[t]
        px, py = position[0, low:high], position[1, low:high]
        nx, ny = normal[0, low:high], normal[1, low:high]
        out = table[:, columns[t] : columns[t] + high - low]
        for k in range(high - low):
            rx, ry = px[k] - x, py[k] - y
            inverse = 1.0 / (rx * rx + ry * ry)
            logarithm = 0.5 * log(inverse)
            xx, xy, yy = rx * rx * inverse, rx * ry * inverse, ry * ry * inverse
            stress = -4.0 * (rx * nx[k] + ry * ny[k]) * inverse
            out[0, k] = logarithm + xx
            out[1, k] = xy
            out[2, k] = logarithm + yy
            out[3, k] = stress * xx
            out[4, k] = stress * xy
            out[5, k] = stress * yy


@compiled(fastmath=True, error_model="numpy")
def _pressure(targets, starts, stops, columns, position, normal, table):
    for t in range(targets.shape[1]):
        x, y = targets[0, t], targets[1, t]
        low, high = starts[t], stops[t]
        px, py = position[0, low:high], position[1, low:high]
        nx, ny = normal[0, low:high], normal[1, low:high]
        out = table[:, columns[t] : columns[t] + high - low]
        for k in range(high - low):
            rx, ry = px[k] - x, py[k] - y
            inverse = 1.0 / (rx * rx + ry * ry)
            stress = 8.0 * (rx * nx[k] + ry * ny[k]) * inverse
            out[0, k] = 2.0 * rx * inverse
            out[1, k] = 2.0 * ry * inverse
            out[2, k] = (stress * rx - 4.0 * nx[k]) * inverse
            out[3, k] = (stress * ry - 4.0 * ny[k]) * inverse


STOKES_2D = Kernel(
    name="Stokes flow, velocity, 2D",
    dimension=2,
    entries=6,
    single=((0, 1), (1, 2)),
    double=((3, 4), (4, 5)),
    fill=_velocity,
    free_term=2 * pi,
    sums=SUMS_2D,
)

STOKES_PRESSURE_2D = Kernel(
    name="Stokes flow, pressure, 2D",
    dimension=2,
    entries=4,
    single=((0, 1),),
    double=((2, 3),),
    fill=_pressure,
)
