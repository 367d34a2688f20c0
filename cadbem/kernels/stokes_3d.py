"""Stokeslet, stresslet and their pressures in three dimensions, without any factor.

With r = x - x0 (source minus target):

    G_ij = δ_ij / r + r_i r_j / r³,   T_ijk n_k = -6 r_i r_j (r·n) / r⁵

(Pozrikidis 1992, ch. 2).  The velocity of a Stokes flow at x0 inside, n into the fluid, is
u = -(1/8πμ) ∫ G f dS + (1/8π) ∫ (T·n) u dS.  The pressure that belongs to it is
p = (1/8π) ∫ g·f dS + (μ/8π) ∫ h·u dS with

    g_j = 2 r_j / r³,   h_j = 4 (-n_j / r³ + 3 r_j (r·n) / r⁵).
"""

from __future__ import annotations

from math import sqrt

from numba import njit

from cadbem.kernels.kernel import Kernel


@njit(cache=True, nogil=True, fastmath=True, error_model="numpy")
def _velocity_row(x, y, z, start, stop, position, normal, table):
    for k in range(start, stop):
        rx, ry, rz = position[0, k] - x, position[1, k] - y, position[2, k] - z
        inverse = 1.0 / sqrt(rx * rx + ry * ry + rz * rz)
        square = inverse * inverse
        cube = square * inverse
        flux = rx * normal[0, k] + ry * normal[1, k] + rz * normal[2, k]
        stress = -6.0 * flux * cube * square
        table[0, k] = inverse + rx * rx * cube
        table[1, k] = rx * ry * cube
        table[2, k] = rx * rz * cube
        table[3, k] = inverse + ry * ry * cube
        table[4, k] = ry * rz * cube
        table[5, k] = inverse + rz * rz * cube
        table[6, k] = rx * rx * stress
        table[7, k] = rx * ry * stress
        table[8, k] = rx * rz * stress
        table[9, k] = ry * ry * stress
        table[10, k] = ry * rz * stress
        table[11, k] = rz * rz * stress


@njit(cache=True, nogil=True, fastmath=True)
def _velocity_block(targets, position, normal, table):
    for t in range(targets.shape[1]):
        _velocity_row(
            targets[0, t], targets[1, t], targets[2, t],
            0, position.shape[1], position, normal, table[:, t],
        )  # fmt: skip


@njit(cache=True, nogil=True, fastmath=True)
def _velocity_rows(targets, starts, position, normal, table):
    for t in range(targets.shape[1]):
        _velocity_row(
            targets[0, t], targets[1, t], targets[2, t],
            starts[t], starts[t + 1], position, normal, table,
        )  # fmt: skip


@njit(cache=True, nogil=True, fastmath=True, error_model="numpy")
def _pressure_row(x, y, z, start, stop, position, normal, table):
    for k in range(start, stop):
        rx, ry, rz = position[0, k] - x, position[1, k] - y, position[2, k] - z
        square = 1.0 / (rx * rx + ry * ry + rz * rz)
        cube = square * sqrt(square)
        flux = rx * normal[0, k] + ry * normal[1, k] + rz * normal[2, k]
        stress = 12.0 * flux * cube * square
        table[0, k] = 2.0 * rx * cube
        table[1, k] = 2.0 * ry * cube
        table[2, k] = 2.0 * rz * cube
        table[3, k] = rx * stress - 4.0 * normal[0, k] * cube
        table[4, k] = ry * stress - 4.0 * normal[1, k] * cube
        table[5, k] = rz * stress - 4.0 * normal[2, k] * cube


@njit(cache=True, nogil=True, fastmath=True)
def _pressure_block(targets, position, normal, table):
    for t in range(targets.shape[1]):
        _pressure_row(
            targets[0, t], targets[1, t], targets[2, t],
            0, position.shape[1], position, normal, table[:, t],
        )  # fmt: skip


@njit(cache=True, nogil=True, fastmath=True)
def _pressure_rows(targets, starts, position, normal, table):
    for t in range(targets.shape[1]):
        _pressure_row(
            targets[0, t], targets[1, t], targets[2, t],
            starts[t], starts[t + 1], position, normal, table,
        )  # fmt: skip


STOKES_3D = Kernel(
    name="Stokes flow, velocity, 3D",
    dimension=3,
    entries=12,
    single=((0, 1, 2), (1, 3, 4), (2, 4, 5)),
    double=((6, 7, 8), (7, 9, 10), (8, 10, 11)),
    fill_block=_velocity_block,
    fill_rows=_velocity_rows,
)

STOKES_PRESSURE_3D = Kernel(
    name="Stokes flow, pressure, 3D",
    dimension=3,
    entries=6,
    single=((0, 1, 2),),
    double=((3, 4, 5),),
    fill_block=_pressure_block,
    fill_rows=_pressure_rows,
)
