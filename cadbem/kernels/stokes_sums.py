"""Sums of Stokeslets and stresslets over many sources at once, without tables of pairs.

    single_j(x0) = Σ G_ij(x, x0) q_i,    double_j(x0) = Σ T_ijk(x, x0) a_k (u_i(x) - u0_i)

with G and T as in ``stokes_2d`` and ``stokes_3d``; the quadrature weights are in q and in the area
vectors a, and u0 belongs to the target.  No source may lie at a target.  Sums are added to ``out``
(dim, T).  Each comes twice: over the same N sources for all T targets, arrays (dim, N), and over K
sources for each target, arrays (dim, K, T).
"""

from __future__ import annotations

from math import pi, sqrt

from cadbem.compiled import compiled
from cadbem.kernels.kernel import Sums
from cadbem.kernels.logarithm import logarithm


@compiled(fastmath=True, error_model="numpy", inline="always")
def _stokeslet_3d(rx, ry, rz, qx, qy, qz):
    inverse = 1.0 / sqrt(rx * rx + ry * ry + rz * rz)
    along = (rx * qx + ry * qy + rz * qz) * inverse * inverse
    return inverse * (qx + rx * along), inverse * (qy + ry * along), inverse * (qz + rz * along)


@compiled(fastmath=True, error_model="numpy", inline="always")
def _stresslet_3d(rx, ry, rz, ax, ay, az, ux, uy, uz):
    inverse = 1.0 / sqrt(rx * rx + ry * ry + rz * rz)
    squared = inverse * inverse
    flux = rx * ax + ry * ay + rz * az
    factor = -6.0 * (rx * ux + ry * uy + rz * uz) * flux * squared * squared * inverse
    return factor * rx, factor * ry, factor * rz


@compiled(fastmath=True, error_model="numpy", inline="always")
def _stokeslet_2d(rx, ry, qx, qy):
    inverse = 1.0 / (rx * rx + ry * ry)
    half = 0.5 * logarithm(inverse)
    along = (rx * qx + ry * qy) * inverse
    return half * qx + rx * along, half * qy + ry * along


@compiled(fastmath=True, error_model="numpy", inline="always")
def _stresslet_2d(rx, ry, ax, ay, ux, uy):
    inverse = 1.0 / (rx * rx + ry * ry)
    factor = -4.0 * (rx * ux + ry * uy) * (rx * ax + ry * ay) * inverse * inverse
    return factor * rx, factor * ry


@compiled(fastmath=True, error_model="numpy")
def _single_3d(targets, position, density, out):
    px, py, pz = position[0], position[1], position[2]
    qx, qy, qz = density[0], density[1], density[2]
    for t in range(targets.shape[1]):
        x, y, z = targets[0, t], targets[1, t], targets[2, t]
        sx = sy = sz = 0.0
        for k in range(len(px)):
            vx, vy, vz = _stokeslet_3d(px[k] - x, py[k] - y, pz[k] - z, qx[k], qy[k], qz[k])
            sx += vx
            sy += vy
            sz += vz
        out[0, t] += sx
        out[1, t] += sy
        out[2, t] += sz


@compiled(fastmath=True, error_model="numpy")
def _single_near_3d(targets, position, density, out):
    x, y, z = targets[0], targets[1], targets[2]
    for k in range(position.shape[1]):
        px, py, pz = position[0, k], position[1, k], position[2, k]
        qx, qy, qz = density[0, k], density[1, k], density[2, k]
        for t in range(len(x)):
            vx, vy, vz = _stokeslet_3d(
                px[t] - x[t], py[t] - y[t], pz[t] - z[t], qx[t], qy[t], qz[t]
            )
            out[0, t] += vx
            out[1, t] += vy
            out[2, t] += vz


@compiled(fastmath=True, error_model="numpy")
def _double_3d(targets, offset, position, area, density, out):
    px, py, pz = position[0], position[1], position[2]
    ax, ay, az = area[0], area[1], area[2]
    ux, uy, uz = density[0], density[1], density[2]
    for t in range(targets.shape[1]):
        x, y, z = targets[0, t], targets[1, t], targets[2, t]
        ox, oy, oz = offset[0, t], offset[1, t], offset[2, t]
        sx = sy = sz = 0.0
        for k in range(len(px)):
            vx, vy, vz = _stresslet_3d(
                px[k] - x, py[k] - y, pz[k] - z, ax[k], ay[k], az[k],
                ux[k] - ox, uy[k] - oy, uz[k] - oz,
            )  # fmt: skip
            sx += vx
            sy += vy
            sz += vz
        out[0, t] += sx
        out[1, t] += sy
        out[2, t] += sz


@compiled(fastmath=True, error_model="numpy")
def _double_near_3d(targets, offset, position, area, density, out):
    x, y, z = targets[0], targets[1], targets[2]
    ox, oy, oz = offset[0], offset[1], offset[2]
    for k in range(position.shape[1]):
        px, py, pz = position[0, k], position[1, k], position[2, k]
        ax, ay, az = area[0, k], area[1, k], area[2, k]
        ux, uy, uz = density[0, k], density[1, k], density[2, k]
        for t in range(len(x)):
            vx, vy, vz = _stresslet_3d(
                px[t] - x[t], py[t] - y[t], pz[t] - z[t], ax[t], ay[t], az[t],
                ux[t] - ox[t], uy[t] - oy[t], uz[t] - oz[t],
            )  # fmt: skip
            out[0, t] += vx
            out[1, t] += vy
            out[2, t] += vz


@compiled(fastmath=True, error_model="numpy")
def _single_2d(targets, position, density, out):
    px, py = position[0], position[1]
    qx, qy = density[0], density[1]
    for t in range(targets.shape[1]):
        x, y = targets[0, t], targets[1, t]
        sx = sy = 0.0
        for k in range(len(px)):
            vx, vy = _stokeslet_2d(px[k] - x, py[k] - y, qx[k], qy[k])
            sx += vx
            sy += vy
        out[0, t] += sx
        out[1, t] += sy


@compiled(fastmath=True, error_model="numpy")
def _single_near_2d(targets, position, density, out):
    for k in range(position.shape[1]):
        for t in range(targets.shape[1]):
            rx, ry = position[0, k, t] - targets[0, t], position[1, k, t] - targets[1, t]
            vx, vy = _stokeslet_2d(rx, ry, density[0, k, t], density[1, k, t])
            out[0, t] += vx
            out[1, t] += vy


@compiled(fastmath=True, error_model="numpy")
def _double_2d(targets, offset, position, area, density, out):
    px, py = position[0], position[1]
    ax, ay = area[0], area[1]
    ux, uy = density[0], density[1]
    for t in range(targets.shape[1]):
        x, y, ox, oy = targets[0, t], targets[1, t], offset[0, t], offset[1, t]
        sx = sy = 0.0
        for k in range(len(px)):
            vx, vy = _stresslet_2d(px[k] - x, py[k] - y, ax[k], ay[k], ux[k] - ox, uy[k] - oy)
            sx += vx
            sy += vy
        out[0, t] += sx
        out[1, t] += sy


@compiled(fastmath=True, error_model="numpy")
def _double_near_2d(targets, offset, position, area, density, out):
    for k in range(position.shape[1]):
        for t in range(targets.shape[1]):
            rx, ry = position[0, k, t] - targets[0, t], position[1, k, t] - targets[1, t]
            ux, uy = density[0, k, t] - offset[0, t], density[1, k, t] - offset[1, t]
            vx, vy = _stresslet_2d(rx, ry, area[0, k, t], area[1, k, t], ux, uy)
            out[0, t] += vx
            out[1, t] += vy


SUMS_2D = Sums(_single_2d, _single_near_2d, _double_2d, _double_near_2d, 2 * pi)
SUMS_3D = Sums(_single_3d, _single_near_3d, _double_3d, _double_near_3d, 4 * pi)


def stokes_sums(dimension: int) -> Sums:
    """The sums in 2 or 3 dimensions."""
    return SUMS_2D if dimension == 2 else SUMS_3D
