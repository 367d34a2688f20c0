"""Potential of a line source and its normal derivative in two dimensions, without any factor.

With r = x - x0 (source minus target):

    G = -ln r,   ∂G/∂n = -(r·n) / r²

A harmonic function at x0 inside, n into the domain, is
φ = -(1/2π) ∫ G ∂φ/∂n ds + (1/2π) ∫ (∂G/∂n) φ ds (Green's third identity).

The gradient of both layers with respect to x0:

    ∂G/∂x0_i = r_i / r²,   ∂²G/∂n∂x0_i = n_i / r² - 2 r_i (r·n) / r⁴.
"""

from __future__ import annotations

from math import pi

from cadbem.compiled import compiled
from cadbem.kernels.kernel import Kernel
from cadbem.kernels.logarithm import logarithm


@compiled(fastmath=True, error_model="numpy")
def _potential(targets, starts, stops, columns, position, normal, table):
    for t in range(targets.shape[1]):
        x, y = targets[0, t], targets[1, t]
        low, high = starts[t], stops[t]
        px, py = position[0, low:high], position[1, low:high]
        nx, ny = normal[0, low:high], normal[1, low:high]
        first, last = columns[t], columns[t] + high - low
        single, double = table[0, first:last], table[1, first:last]
        for k in range(high - low):
            rx, ry = px[k] - x, py[k] - y
            square = rx * rx + ry * ry
            single[k] = -0.5 * logarithm(square)
            double[k] = -(rx * nx[k] + ry * ny[k]) / square


@compiled(fastmath=True, error_model="numpy")
def _gradient(targets, starts, stops, columns, position, normal, table):
    for t in range(targets.shape[1]):
        x, y = targets[0, t], targets[1, t]
        low, high = starts[t], stops[t]
        px, py = position[0, low:high], position[1, low:high]
        nx, ny = normal[0, low:high], normal[1, low:high]
        out = table[:, columns[t] : columns[t] + high - low]
        for k in range(high - low):
            rx, ry = px[k] - x, py[k] - y
            inverse = 1.0 / (rx * rx + ry * ry)
            across = 2.0 * (rx * nx[k] + ry * ny[k]) * inverse
            out[0, k] = rx * inverse
            out[1, k] = ry * inverse
            out[2, k] = (nx[k] - across * rx) * inverse
            out[3, k] = (ny[k] - across * ry) * inverse


LAPLACE_2D = Kernel(
    name="Laplace equation, 2D",
    dimension=2,
    entries=2,
    single=((0,),),
    double=((1,),),
    fill=_potential,
    free_term=pi,
)

LAPLACE_GRADIENT_2D = Kernel(
    name="Laplace equation, gradient, 2D",
    dimension=2,
    entries=4,
    single=((0,), (1,)),
    double=((2,), (3,)),
    fill=_gradient,
)
