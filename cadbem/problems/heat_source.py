"""Volume integrals of a source over a body, as integrals over its boundary.

The radial integration method (Gao 2002): with s the distance from x0 and n into the body,

    ∫_V b G dV = ∫_S ∂G/∂n F dS up to the factor of ∂G/∂n,   F = ∫₀ʳ b(x0 + s e) G(s) s^(dim-1) ds

along the straight line from x0 to the boundary point x0 + r e, where -(e·n) / r^(dim-1) dS is the
element of solid angle.  The line may leave the body; the parts outside cancel, so that b must be
known there too.  F is a kernel's entry, computed by Gauss rules along the line.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache
from math import log

import numpy as np

from cadbem.boundary import Boundary
from cadbem.errors import ConditionError
from cadbem.kernels.kernel import Index, Kernel
from cadbem.kernels.laplace_2d import LAPLACE_2D, LAPLACE_GRADIENT_2D
from cadbem.kernels.laplace_3d import LAPLACE_3D, LAPLACE_GRADIENT_3D
from cadbem.quadrature.gauss import gauss_unit
from cadbem.space import Space
from cadbem.spline.basis import Array

Source = float | Callable[[Array], Array]
ORDERS = (4, 8, 16, 32, 64)  # of rules along a line, for sources that are not constant
SAMPLES = 24  # points between which lines are tried out


def laplace_kernel(dimension: int, size: float) -> Kernel:
    """G and ∂G/∂n, positive at distances below ``size``: 1/r (3D), -ln(r / size) (2D).

    Without ``size`` the single layer of a plane curve would have no inverse at one scale.
    """
    if dimension == 3:
        return LAPLACE_3D
    def fill(*arguments: Array) -> None:
        LAPLACE_2D.fill(*arguments)
        arguments[-1][0] += log(size)

    return replace(LAPLACE_2D, fill=fill)


def gradient_kernel(dimension: int) -> Kernel:
    """Gradients of G and ∂G/∂n with respect to the target."""
    return LAPLACE_GRADIENT_3D if dimension == 3 else LAPLACE_GRADIENT_2D


@dataclass(frozen=True, eq=False)
class SourceKernels:
    """Kernels whose double layers of density 1 are ∫ b G dV and its gradient.

    ``order`` is that of the Gauss rule along a line; G is that of ``laplace_kernel``.
    """

    source: Source
    dimension: int
    size: float
    order: int

    @property
    def value(self) -> Kernel:
        """Kernel of ∫ b G dV."""
        return self._kernel("heat source", 1, self._value)

    @property
    def gradient(self) -> Kernel:
        """Kernel of ∫ b ∇G dV, ∇ with respect to the target."""
        return self._kernel("heat source, gradient", self.dimension, self._gradient)

    def _kernel(self, name: str, rows: int, entries: Callable[[Array, Array], Array]) -> Kernel:
        def fill(
            targets: Array,
            starts: Index,
            stops: Index,
            columns: Index,
            position: Array,
            normal: Array,
            table: Array,
        ) -> None:
            lengths = stops - starts
            target = np.repeat(np.arange(len(lengths)), lengths)
            place = np.arange(len(target)) - np.repeat(np.cumsum(lengths) - lengths, lengths)
            chosen = starts[target] + place
            start, step = targets[:, target], position[:, chosen] - targets[:, target]
            across = -(step * normal[:, chosen]).sum(axis=0)
            table[:, columns[target] + place] = across * entries(start, step)

        layout = tuple((i,) for i in range(rows))
        return Kernel(name, self.dimension, rows, layout, layout, fill, invariant=False)

    def _value(self, start: Array, step: Array) -> Array:
        """F / r^dim on lines from ``start`` along ``step`` (dim, M); see the top of this file."""
        _, linear, logarithmic = _line_moments(self.source, self.order, start, step)
        distance = _distance(step)
        if self.dimension == 3:
            return linear / distance
        return logarithmic - np.log(distance / self.size) * linear

    def _gradient(self, start: Array, step: Array) -> Array:
        """The same with the gradient of G, e / s^(dim-1)."""
        constant, _, _ = _line_moments(self.source, self.order, start, step)
        return constant * step / _distance(step) ** self.dimension


def source_kernels(source: Source, space: Space, size: float, tolerance: float) -> SourceKernels:
    """Kernels of a source in a space's body.

    Raises ``ConditionError`` when the source varies too fast along lines through the body.
    """
    order = _order(source, space.collocation.position, tolerance)
    return SourceKernels(source, space.boundary.dimension, size, order)


def _distance(step: Array) -> Array:
    distance = np.linalg.norm(step, axis=0)
    return np.where(distance > 0, distance, 1.0)  # at 0 the normal part of the step vanishes


def _line_moments(source: Source, order: int, start: Array, step: Array) -> Array:
    """∫₀¹ b w dt for w = 1, t, t ln(1/t) along lines x = start + t step: (3, M)."""
    nodes, weights = _line_rule(order)
    moments = np.zeros((3, start.shape[1]))
    for t, w in zip(nodes, weights.T, strict=True):
        moments += np.multiply.outer(w, evaluate(source, start + t * step))
    return moments


@lru_cache(maxsize=8)
def _line_rule(order: int) -> tuple[Array, Array]:
    """Nodes on [0, 1] and weights (3, order) of 1, t and t ln(1/t), exact to degree order - 1."""
    nodes, weights = gauss_unit(order)
    # the substitution t = s⁴ leaves a smooth integrand for the moments of Legendre polynomials
    s, w = gauss_unit(order + 40)
    polynomials = np.polynomial.legendre.legvander(2 * s**4 - 1, order - 1)
    moments = (w * 4 * s**3 * s**4 * -4 * np.log(s)) @ polynomials
    table = np.polynomial.legendre.legvander(2 * nodes - 1, order - 1)
    return nodes, np.stack([weights, weights * nodes, np.linalg.solve(table.T, moments)])


def _order(source: Source, position: Array, tolerance: float) -> int:
    """Smallest order whose moments agree with the next one's on lines through the body."""
    if not callable(source):
        return 1
    sample = position[:, np.linspace(0, position.shape[1] - 1, SAMPLES).astype(int)]
    start = np.repeat(sample, sample.shape[1], axis=1)
    step = np.tile(sample, sample.shape[1]) - start
    last = _line_moments(source, ORDERS[0], start, step)
    for lower, order in zip(ORDERS, ORDERS[1:], strict=False):
        moments = _line_moments(source, order, start, step)
        if abs(moments - last).max() <= tolerance * abs(moments).max():
            return lower
        last = moments
    raise ConditionError(
        f"the heat source is not resolved by {ORDERS[-1]} points along lines through the body; "
        "give a smoother one or a larger tolerance of quadrature"
    )


def evaluate(source: Source, position: Array) -> Array:
    """Values (N,) of a source at positions (dim, N)."""
    if callable(source):
        return np.broadcast_to(np.asarray(source(position), dtype=float), position.shape[1:])
    return np.full(position.shape[1], float(source))


def total_source(source: Source, boundary: Boundary, order: int = 32) -> float:
    """∫ b dV over the body, by lines from the middle of its box."""
    points, weights = boundary.quadrature()
    start = np.broadcast_to(boundary.bounds().mean(axis=0)[:, None], points.position.shape)
    step = points.position - start
    nodes, shares = gauss_unit(order)
    along = sum(
        w * t ** (boundary.dimension - 1) * evaluate(source, start + t * step)
        for t, w in zip(nodes, shares, strict=True)
    )
    return -float((step * points.normal).sum(axis=0) * along @ weights)
