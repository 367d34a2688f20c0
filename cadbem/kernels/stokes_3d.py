"""Stokeslet, stresslet and their pressures in three dimensions, without any factor.

With r = x - x0 (source minus target):

    G_ij = δ_ij / r + r_i r_j / r³,   T_ijk n_k = -6 r_i r_j (r·n) / r⁵

(Pozrikidis 1992, ch. 2).  The velocity of a Stokes flow at x0 inside, n into the fluid, is
u = -(1/8πμ) ∫ G f dS + (1/8π) ∫ (T·n) u dS.  The pressure that belongs to it is
p = (1/8π) ∫ g·f dS + (μ/8π) ∫ h·u dS with

    g_j = 2 r_j / r³,   h_j = 4 (-n_j / r³ + 3 r_j (r·n) / r⁵).
"""

from __future__ import annotations

from math import pi, sqrt

import numpy as np

from cadbem.compiled import compiled
from cadbem.kernels.kernel import Kernel
from cadbem.kernels.stokes_sums import SUMS_3D

TILE = 256  # sources at a time, so that what pairs share stays in the nearest cache


@compiled(fastmath=True, error_model="numpy")
def _velocity(targets, starts, stops, columns, position, normal, table):
    r, inverse, cube, stress = np.empty((3, TILE)), np.empty(TILE), np.empty(TILE), np.empty(TILE)
    both = len(table) > 6
    for t in range(targets.shape[1]):
        x, y, z = targets[0, t], targets[1, t], targets[2, t]
        for low in range(starts[t], stops[t], TILE):
            high = min(low + TILE, stops[t])
            px, py, pz = position[0, low:high], position[1, low:high], position[2, low:high]
            nx, ny, nz = normal[0, low:high], normal[1, low:high], normal[2, low:high]
            for k in range(high - low):
                rx, ry, rz = px[k] - x, py[k] - y, pz[k] - z
                i = 1.0 / sqrt(rx * rx + ry * ry + rz * rz)
                r[0, k], r[1, k], r[2, k] = rx, ry, rz
                inverse[k] = i
                cube[k] = i * i * i
            if both:
                rx, ry, rz = r[0], r[1], r[2]
                for k in range(high - low):
                    across = rx[k] * nx[k] + ry[k] * ny[k] + rz[k] * nz[k]
                    stress[k] = -6.0 * across * cube[k] * inverse[k] * inverse[k]
            first = columns[t] + low - starts[t]
            last, entry = first + high - low, 0
            for a in range(3):
                for b in range(a, 3):
                    delta = 1.0 if a == b else 0.0
                    ra, rb = r[a], r[b]
                    # plain loops over one entry each: the compiler makes vectors of them
                    out = table[entry, first:last]
                    for k in range(high - low):
                        out[k] = delta * inverse[k] + ra[k] * rb[k] * cube[k]
                    if both:
                        out = table[entry + 6, first:last]
                        for k in range(high - low):
                            out[k] = ra[k] * rb[k] * stress[k]
                    entry += 1


@compiled(fastmath=True, error_model="numpy")
def _pressure(targets, starts, stops, columns, position, normal, table):
    r, cube, stress = np.empty((3, TILE)), np.empty(TILE), np.empty(TILE)
    for t in range(targets.shape[1]):
        x, y, z = targets[0, t], targets[1, t], targets[2, t]
        for low in range(starts[t], stops[t], TILE):
            high = min(low + TILE, stops[t])
            px, py, pz = position[0, low:high], position[1, low:high], position[2, low:high]
            nx, ny, nz = normal[0, low:high], normal[1, low:high], normal[2, low:high]
            for k in range(high - low):
                rx, ry, rz = px[k] - x, py[k] - y, pz[k] - z
                i = 1.0 / sqrt(rx * rx + ry * ry + rz * rz)
                r[0, k], r[1, k], r[2, k] = rx, ry, rz
                cube[k] = i * i * i
                stress[k] = 12.0 * (rx * nx[k] + ry * ny[k] + rz * nz[k]) * cube[k] * i * i
            first = columns[t] + low - starts[t]
            last = first + high - low
            for a in range(3):
                ra, na = r[a], normal[a, low:high]
                out = table[a, first:last]
                for k in range(high - low):
                    out[k] = 2.0 * ra[k] * cube[k]
                out = table[a + 3, first:last]
                for k in range(high - low):
                    out[k] = ra[k] * stress[k] - 4.0 * na[k] * cube[k]


STOKES_3D = Kernel(
    name="Stokes flow, velocity, 3D",
    dimension=3,
    entries=12,
    single=((0, 1, 2), (1, 3, 4), (2, 4, 5)),
    double=((6, 7, 8), (7, 9, 10), (8, 10, 11)),
    fill=_velocity,
    free_term=4 * pi,
    sums=SUMS_3D,
    separable=True,
)

STOKES_PRESSURE_3D = Kernel(
    name="Stokes flow, pressure, 3D",
    dimension=3,
    entries=6,
    single=((0, 1, 2),),
    double=((3, 4, 5),),
    fill=_pressure,
)
