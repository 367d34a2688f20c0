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

from math import pi

import numpy as np

from cadbem.compiled import compiled
from cadbem.kernels.kernel import Kernel
from cadbem.kernels.logarithm import logarithm
from cadbem.kernels.stokes_sums import SUMS_2D

TILE = 256  # sources at a time, so that what pairs share stays in the nearest cache


@compiled(fastmath=True)
def _velocity(targets, starts, stops, columns, position, normal, table):
    r, inverse, log, stress = np.empty((2, TILE)), np.empty(TILE), np.empty(TILE), np.empty(TILE)
    both = len(table) > 3
    for t in range(targets.shape[1]):
        x, y = targets[0, t], targets[1, t]
        for low in range(starts[t], stops[t], TILE):
            high = min(low + TILE, stops[t])
            px, py = position[0, low:high], position[1, low:high]
            nx, ny = normal[0, low:high], normal[1, low:high]
            for k in range(high - low):
                rx, ry = px[k] - x, py[k] - y
                i = 1.0 / (rx * rx + ry * ry)
                r[0, k], r[1, k] = rx, ry
                inverse[k] = i
                log[k] = 0.5 * logarithm(i)
                stress[k] = -4.0 * (rx * nx[k] + ry * ny[k]) * i * i
            first = columns[t] + low - starts[t]
            last, entry = first + high - low, 0
            for a in range(2):
                for b in range(a, 2):
                    delta = 1.0 if a == b else 0.0
                    ra, rb = r[a], r[b]
                    # plain loops over one entry each: the compiler makes vectors of them
                    out = table[entry, first:last]
                    for k in range(high - low):
                        out[k] = delta * log[k] + ra[k] * rb[k] * inverse[k]
                    if both:
                        out = table[entry + 3, first:last]
                        for k in range(high - low):
                            out[k] = ra[k] * rb[k] * stress[k]
                    entry += 1


@compiled(fastmath=True)
def _pressure(targets, starts, stops, columns, position, normal, table):
    r, inverse, stress = np.empty((2, TILE)), np.empty(TILE), np.empty(TILE)
    for t in range(targets.shape[1]):
        x, y = targets[0, t], targets[1, t]
        for low in range(starts[t], stops[t], TILE):
            high = min(low + TILE, stops[t])
            px, py = position[0, low:high], position[1, low:high]
            nx, ny = normal[0, low:high], normal[1, low:high]
            for k in range(high - low):
                rx, ry = px[k] - x, py[k] - y
                i = 1.0 / (rx * rx + ry * ry)
                r[0, k], r[1, k] = rx, ry
                inverse[k] = i
                stress[k] = 8.0 * (rx * nx[k] + ry * ny[k]) * i * i
            first = columns[t] + low - starts[t]
            last = first + high - low
            for a in range(2):
                ra, na = r[a], normal[a, low:high]
                out = table[a, first:last]
                for k in range(high - low):
                    out[k] = 2.0 * ra[k] * inverse[k]
                out = table[a + 2, first:last]
                for k in range(high - low):
                    out[k] = ra[k] * stress[k] - 4.0 * na[k] * inverse[k]


STOKES_2D = Kernel(
    name="Stokes flow, velocity, 2D",
    dimension=2,
    entries=6,
    single=((0, 1), (1, 2)),
    double=((3, 4), (4, 5)),
    fill=_velocity,
    free_term=2 * pi,
    sums=SUMS_2D,
    separable=True,
)

STOKES_PRESSURE_2D = Kernel(
    name="Stokes flow, pressure, 2D",
    dimension=2,
    entries=4,
    single=((0, 1),),
    double=((2, 3),),
    fill=_pressure,
)
