"""Gauss-Legendre rules on intervals, elements and rectangles."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
MAX_ORDER = 64  # of rules; compiled code takes it, hence a mark for cadbem.compiled


@lru_cache(maxsize=128)
def gauss_unit(order: int) -> tuple[Array, Array]:
    """Gauss-Legendre nodes and weights on [0, 1], exact to degree 2 order - 1."""
    nodes, weights = np.polynomial.legendre.leggauss(order)
    nodes, weights = 0.5 * (nodes + 1.0), 0.5 * weights
    nodes.setflags(write=False)
    weights.setflags(write=False)
    return nodes, weights


@lru_cache(maxsize=128)
def log_unit(order: int) -> tuple[Array, Array]:
    """Nodes and weights on [0, 1], exact for f(x) + g(x) ln x with polynomials f and g.

    Their degrees go up to order // 2 - 1.  The nodes are those of Gauss to the power 3/2, dense
    enough at 0 for positive weights, yet not so dense that differences of points lose digits.
    The weights are the smallest change that makes the moments exact, which are
    ∫ P_k(2x - 1) ln x dx = (-1)^(k + 1) / (k (k + 1)), and -1 for k = 0.
    """
    nodes, weights = gauss_unit(order)
    x, w = nodes**1.5, 1.5 * np.sqrt(nodes) * weights
    size = max(order // 2, 1)
    powers = np.polynomial.legendre.legvander(2 * x - 1, size - 1).T
    k = np.arange(1, size)
    moments = np.concatenate([[1.0], 0.0 * k, [-1.0], (-1.0) ** (k + 1) / (k * (k + 1))])
    scale = np.sqrt(w)
    matrix = np.concatenate([powers, powers * np.log(x)])
    change = np.linalg.lstsq(matrix * scale, moments - matrix @ w, rcond=1e-15)[0]
    return x, w + scale * change


def gauss_on_breaks(order: int, breaks: Array) -> tuple[Array, Array]:
    """The rule of ``order`` repeated on each interval between increasing ``breaks``."""
    nodes, weights = gauss_unit(order)
    lengths = np.diff(breaks)[:, None]
    return (breaks[:-1, None] + lengths * nodes).ravel(), (lengths * weights).ravel()


def tensor_rule(rules: Sequence[tuple[Array, Array]]) -> tuple[list[Array], Array]:
    """Product of one-dimensional rules: flat nodes a parameter, the last one fastest."""
    nodes = np.meshgrid(*[n for n, _ in rules], indexing="ij")
    weights = np.meshgrid(*[w for _, w in rules], indexing="ij")
    return [n.ravel() for n in nodes], np.prod(weights, axis=0).ravel()
