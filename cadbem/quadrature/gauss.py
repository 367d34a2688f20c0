"""Gauss-Legendre rules on intervals, elements and rectangles."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]



@lru_cache(maxsize=128)
def gauss_unit(order: int) -> tuple[Array, Array]:
    """Gauss-Legendre nodes and weights on [0, 1], exact to degree 2 order - 1."""
    nodes, weights = np.polynomial.legendre.leggauss(order)
    nodes, weights = 0.5 * (nodes + 1.0), 0.5 * weights
    nodes.setflags(write=False)
    weights.setflags(write=False)
    return nodes, weights


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
