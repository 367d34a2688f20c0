"""Clusters of points by bisection, and which pairs of clusters are far apart."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from cadbem.kernels.kernel import Array, Index

Pairs = list[tuple[int, int]]


@dataclass(frozen=True, eq=False)
class Tree:
    """A binary tree of clusters of N items, each a ball; cluster 0 holds all.

    ``order`` (N,) lists the items so that each cluster's are neighbours: cluster c holds
    order[start[c]:stop[c]].  ``centre`` (dim, C) and ``radius`` (C,) of balls that hold them;
    ``children`` (C, 2), -1 at leaves.
    """

    order: Index
    start: Index
    stop: Index
    centre: Array
    radius: Array
    children: Index

    def items(self, cluster: int) -> Index:
        """The items of a cluster."""
        return self.order[self.start[cluster] : self.stop[cluster]]

    @cached_property
    def leaves(self) -> Index:
        """Clusters without children, in the order of their items."""
        return np.nonzero(self.children[:, 0] < 0)[0]


def cluster(centres: Array, radii: Array, leaf: int) -> Tree:
    """Bisect balls with ``centres`` (dim, N) and ``radii`` (N,), at the median across the longest
    side of their box, until no cluster has more than ``leaf``."""
    order = np.arange(centres.shape[1])
    rows: list[tuple[int, int, float]] = []
    middles: list[Array] = []
    children: list[list[int]] = []

    def add(start: int, stop: int) -> int:
        number, items = len(rows), order[start:stop]
        points = centres[:, items]
        low, high = points.min(axis=1), points.max(axis=1)
        middle = 0.5 * (low + high)
        away = np.linalg.norm(points - middle[:, None], axis=0) + radii[items]
        rows.append((start, stop, float(away.max())))
        middles.append(middle)
        children.append([-1, -1])
        if stop - start > leaf:
            along = points[int((high - low).argmax())]
            order[start:stop] = items[np.argsort(along, kind="stable")]
            half = (start + stop) // 2
            children[number] = [add(start, half), add(half, stop)]
        return number

    add(0, len(order))
    start, stop, radius = (np.array(column) for column in zip(*rows, strict=True))
    return Tree(order, start, stop, np.stack(middles, axis=1), radius, np.array(children))


def partition(
    targets: Tree, sources: Tree, is_far: Callable[[int, int], bool]
) -> tuple[Pairs, Pairs]:
    """Far pairs of clusters, as large as may be, and near pairs of leaves.

    Together they hold each pair of a target and a source once.
    """
    far: Pairs = []
    near: Pairs = []
    todo = [(0, 0)]
    while todo:
        t, s = todo.pop()
        if is_far(t, s):
            far.append((t, s))
            continue
        split_t, split_s = targets.children[t, 0] >= 0, sources.children[s, 0] >= 0
        if not split_t and not split_s:
            near.append((t, s))
            continue
        if split_t and split_s:  # only the larger one, unless they are alike
            ratio = targets.radius[t] / max(sources.radius[s], 1e-300)
            split_t, split_s = ratio > 0.7, ratio < 1 / 0.7
        below_t = targets.children[t] if split_t else [t]
        below_s = sources.children[s] if split_s else [s]
        todo += [(int(a), int(b)) for a in below_t for b in below_s]
    return far, near
