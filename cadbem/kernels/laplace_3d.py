"""Fundamental solution of Laplace's equation in three dimensions, without any factor.

With r = x - x0 (source minus target):

    G = 1 / r,   ∂G/∂n = -(r·n) / r³

For ∇²φ = 0 and n INTO the domain (∫ ∂G/∂n dS = 4π for x0 inside, 2π on a smooth boundary, 0
outside; Green's third identity with the outward normal turned):

    c φ(x0) = -∫ G ∂φ/∂n dS + ∫ φ ∂G/∂n dS,   c = 4π inside, 2π on a smooth boundary.

With q = -k ∂φ/∂n, the heat that flows into the domain per area, the first term is (1/k) ∫ G q dS.

The gradient of both layers with respect to x0, for heat fluxes inside:

    ∂G/∂x0_i = r_i / r³,   ∂²G/∂n∂x0_i = n_i / r³ - 3 r_i (r·n) / r⁵.
"""

from __future__ import annotations

from math import pi, sqrt

from cadbem.compiled import compiled
from cadbem.kernels.kernel import Kernel


@compiled(fastmath=True, error_model="numpy")
def _value(targets, starts, stops, columns, position, normal, table):
    for t in range(targets.shape[1]):
        x, y, z = targets[0, t], targets[1, t], targets[2, t]
        low, high = starts[t], stops[t]
        first, last = columns[t], columns[t] + high - low
        px, py, pz = position[0, low:high], position[1, low:high], position[2, low:high]
        nx, ny, nz = normal[0, low:high], normal[1, low:high], normal[2, low:high]
        single, double = table[0, first:last], table[1, first:last]
        for k in range(high - low):
            rx, ry, rz = px[k] - x, py[k] - y, pz[k] - z
            i = 1.0 / sqrt(rx * rx + ry * ry + rz * rz)
            single[k] = i
            double[k] = -(rx * nx[k] + ry * ny[k] + rz * nz[k]) * i * i * i


@compiled(fastmath=True, error_model="numpy")
def _gradient(targets, starts, stops, columns, position, normal, table):
    for t in range(targets.shape[1]):
        low, high = starts[t], stops[t]
        first = columns[t]
        for k in range(high - low):
            square = across = 0.0
            for c in range(3):
                r = position[c, low + k] - targets[c, t]
                square += r * r
                across += r * normal[c, low + k]
            cube = 1.0 / (square * sqrt(square))
            for c in range(3):
                r = position[c, low + k] - targets[c, t]
                table[c, first + k] = r * cube
                slope = normal[c, low + k] - 3.0 * r * across / square
                table[c + 3, first + k] = slope * cube


LAPLACE_3D = Kernel(
    name="Laplace, value, 3D",
    dimension=3,
    entries=2,
    single=((0,),),
    double=((1,),),
    fill=_value,
    free_term=2 * pi,
)

LAPLACE_GRADIENT_3D = Kernel(
    name="Laplace, gradient, 3D",
    dimension=3,
    entries=6,
    single=((0,), (1,), (2,)),
    double=((3,), (4,), (5,)),
    fill=_gradient,
)
