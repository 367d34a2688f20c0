"""Sums of Stokeslets and stresslets over many sources at once, without tables of pairs.

    single_j(x0) = Σ G_ij(x, x0) q_i,    double_j(x0) = Σ T_ijk(x, x0) a_k (u_i(x) - u0_i)

with G and T as in ``stokes_2d`` and ``stokes_3d``; the quadrature weights are in q and in the area
vectors a, and u0 belongs to the target.  Target t takes the sources starts[t] ... stops[t] - 1; a
source at the target itself is left out.  Sums are added to ``out`` (dim, T).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import log, pi, sqrt

from numba import njit


@njit(cache=True, nogil=True, fastmath=True, error_model="numpy")
def _single_3d(targets, starts, stops, position, density, out):
    for t in range(targets.shape[1]):
        x, y, z = targets[0, t], targets[1, t], targets[2, t]
        low, high = starts[t], stops[t]
        px, py, pz = position[0, low:high], position[1, low:high], position[2, low:high]
        qx, qy, qz = density[0, low:high], density[1, low:high], density[2, low:high]
        sx = sy = sz = 0.0
        for k in range(high - low):
            rx, ry, rz = px[k] - x, py[k] - y, pz[k] - z
            square = rx * rx + ry * ry + rz * rz
            inverse = 1.0 / sqrt(square) if square > 0.0 else 0.0
            along = (rx * qx[k] + ry * qy[k] + rz * qz[k]) * inverse * inverse
            sx += inverse * (qx[k] + rx * along)
            sy += inverse * (qy[k] + ry * along)
            sz += inverse * (qz[k] + rz * along)
        out[0, t] += sx
        out[1, t] += sy
        out[2, t] += sz


@njit(cache=True, nogil=True, fastmath=True, error_model="numpy")
def _double_3d(targets, offset, starts, stops, position, area, density, out):
    for t in range(targets.shape[1]):
        x, y, z = targets[0, t], targets[1, t], targets[2, t]
        ox, oy, oz = offset[0, t], offset[1, t], offset[2, t]
        low, high = starts[t], stops[t]
        px, py, pz = position[0, low:high], position[1, low:high], position[2, low:high]
        ax, ay, az = area[0, low:high], area[1, low:high], area[2, low:high]
        ux, uy, uz = density[0, low:high], density[1, low:high], density[2, low:high]
        sx = sy = sz = 0.0
        for k in range(high - low):
            rx, ry, rz = px[k] - x, py[k] - y, pz[k] - z
            square = rx * rx + ry * ry + rz * rz
            inverse = 1.0 / sqrt(square) if square > 0.0 else 0.0
            squared = inverse * inverse
            along = rx * (ux[k] - ox) + ry * (uy[k] - oy) + rz * (uz[k] - oz)
            flux = rx * ax[k] + ry * ay[k] + rz * az[k]
            factor = -6.0 * along * flux * squared * squared * inverse
            sx += factor * rx
            sy += factor * ry
            sz += factor * rz
        out[0, t] += sx
        out[1, t] += sy
        out[2, t] += sz


@njit(cache=True, nogil=True, fastmath=True, error_model="numpy")
def _single_2d(targets, starts, stops, position, density, out):
    for t in range(targets.shape[1]):
        x, y = targets[0, t], targets[1, t]
        sx = sy = 0.0
        for k in range(starts[t], stops[t]):
            rx, ry = position[0, k] - x, position[1, k] - y
            square = rx * rx + ry * ry
            if square > 0.0:
                qx, qy = density[0, k], density[1, k]
                along = (rx * qx + ry * qy) / square
                logarithm = -0.5 * log(square)
                sx += logarithm * qx + rx * along
                sy += logarithm * qy + ry * along
        out[0, t] += sx
        out[1, t] += sy


@njit(cache=True, nogil=True, fastmath=True, error_model="numpy")
def _double_2d(targets, offset, starts, stops, position, area, density, out):
    for t in range(targets.shape[1]):
        x, y = targets[0, t], targets[1, t]
        ox, oy = offset[0, t], offset[1, t]
        sx = sy = 0.0
        for k in range(starts[t], stops[t]):
            rx, ry = position[0, k] - x, position[1, k] - y
            square = rx * rx + ry * ry
            if square > 0.0:
                along = rx * (density[0, k] - ox) + ry * (density[1, k] - oy)
                flux = rx * area[0, k] + ry * area[1, k]
                factor = -4.0 * along * flux / (square * square)
                sx += factor * rx
                sy += factor * ry
        out[0, t] += sx
        out[1, t] += sy


@dataclass(frozen=True)
class StokesSums:
    """Both sums in one dimension, and ∫ T·n over a closed surface at a point of it.

    ``free_term`` is positive: with n outwards the integral is -free_term times the identity.
    """

    single: Callable[..., None]
    double: Callable[..., None]
    free_term: float


def stokes_sums(dimension: int) -> StokesSums:
    """The sums in 2 or 3 dimensions."""
    if dimension == 2:
        return StokesSums(_single_2d, _double_2d, 2 * pi)
    return StokesSums(_single_3d, _double_3d, 4 * pi)
