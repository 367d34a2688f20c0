"""The construction of a compressed matrix."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from threading import Lock

import numpy as np

from cadbem.kernels.kernel import Array, Index
from cadbem.operators.compressed.clusters import Pairs, Tree, cluster, partition
from cadbem.operators.compressed.cross import (
    MixedKernel,
    PanelCluster,
    cross_approximation,
    recompressed,
)
from cadbem.operators.compressed.matrix import CompressedMatrix, SourceFactors, TargetFactors
from cadbem.operators.compressed.near_blocks import NearAccumulator, NearBlocks
from cadbem.operators.compressed.sources import PanelList, Sources, sources
from cadbem.operators.interactions import Targets, interact_pairs
from cadbem.operators.orders import reaches
from cadbem.operators.panels import split_patch
from cadbem.operators.parallel import run_tasks
from cadbem.quadrature import Rules
from cadbem.space import Space

LEAF = 64  # targets in the smallest clusters, at most
LEAST_PANELS = 16  # in the smallest clusters, at least
SEPARATION = 0.5  # least gap between far clusters over the larger radius
LOWER = 3  # lower Gauss orders for panels farther away
POINTS = 2  # Gauss points a direction of a panel, for crosses
FLOAT32_FROM = 1e-7  # tolerance from which crosses are accurate enough in 32 bits


def compress(
    mixed: MixedKernel,
    space: Space,
    targets: Targets,
    quadrature: Rules,
    tolerance: float,
    own: Array,
) -> CompressedMatrix:
    """The compressed matrix of a mixed kernel, each far block within ``tolerance`` of its size.

    From it are taken ``own`` (patches, rows, unknowns) times the functions' values at targets that
    lie on their patch.
    """
    panels = PanelList.of(space, tuple(split_patch(p.surface) for p in space.boundary.patches))
    tree = cluster(targets.position, np.zeros(targets.count), LEAF)
    builder = _Builder(mixed, panels, tree, targets, quadrature, tolerance)
    near = builder.near()
    for patch in np.nonzero(own.any(axis=(1, 2)))[0]:
        near.take(space, int(patch), own[patch])
    source_factors, target_factors = builder.far()
    return CompressedMatrix(mixed, tree, near, source_factors, target_factors)


@dataclass(frozen=True, eq=False)
class _Builder:
    """The data from which both parts of a compressed matrix are built."""

    mixed: MixedKernel
    unordered: PanelList
    tree: Tree
    targets: Targets
    quadrature: Rules
    tolerance: float

    @property
    def dtype(self) -> type:
        """Of crosses.  Near blocks need all digits: a pressure makes large, opposite tractions."""
        return np.float32 if self.tolerance >= FLOAT32_FROM else np.float64

    @cached_property
    def panel_tree(self) -> Tree:
        """Clusters of panels, as many as of targets: then those of one place are alike."""
        count = len(self.unordered.patch)
        leaf = max(-(-LEAF * count // self.targets.count), LEAST_PANELS)
        return cluster(*self.unordered.balls(), leaf)

    @cached_property
    def panels(self) -> PanelList:
        """The panels in their tree's order."""
        return self.unordered.ordered(self.panel_tree.order)

    @cached_property
    def orders(self) -> list[list[int]]:
        """Gauss orders for panels far away, as many for each patch, ascending."""
        rules, orders = self.quadrature, []
        for panels in self.panels.panels:
            degree = max(panels.surface.degrees)
            orders.append(list(rules.far_orders(degree)[-LOWER - 1 :]))
        most = max(map(len, orders))
        return [o[:1] * (most - len(o)) + o for o in orders]

    @cached_property
    def _reaches(self) -> Array:
        """Distance from which an order is good enough for all panels of a cluster: (orders, C)."""
        rules, tree = self.quadrature, self.panel_tree
        parts = zip(self.panels.panels, self.orders, strict=True)
        reach = self.panels.gathered([reaches(p, tuple(orders), rules) for p, orders in parts])
        pairs = zip(tree.start, tree.stop, strict=True)
        return np.stack([reach[:, a:b].max(axis=1) for a, b in pairs], axis=1)

    def _gap(self, t: int, s: int) -> float:
        """Distance between two clusters' balls."""
        own, other = self.tree, self.panel_tree
        away = np.linalg.norm(own.centre[:, t] - other.centre[:, s])
        return float(away - own.radius[t] - other.radius[s])

    @cached_property
    def partition(self) -> tuple[Pairs, Pairs]:
        """Far and near pairs of clusters of targets and panels."""
        t, s = self.tree, self.panel_tree

        def is_far(i: int, j: int) -> bool:
            least = max(SEPARATION * max(t.radius[i], s.radius[j]), self._reaches[-1, j])
            return self._gap(i, j) > least

        return partition(t, s, is_far)

    @cached_property
    def functions(self) -> tuple[Index, Index]:
        """Functions of each panel, flat, and where each panel's begin."""
        return self.panels.functions()

    def functions_of(self, *clusters: int) -> Index:
        """Sorted numbers of the functions on clusters of panels."""
        flat, first = self.functions
        tree = self.panel_tree
        parts = [flat[first[tree.start[s]] : first[tree.stop[s]]] for s in clusters]
        return np.unique(np.concatenate(parts))

    def near(self) -> NearBlocks:
        """The near blocks."""
        below: dict[int, list[int]] = {int(b): [] for b in self.tree.leaves}
        above: dict[int, list[int]] = {}
        for t, s in self.partition[1]:
            below[t].append(s)
            above.setdefault(s, []).append(t)
        clusters = [self.tree.items(t) for t in below]
        blocks = NearBlocks.empty(
            self.mixed, clusters, [self.functions_of(*near) for near in below.values()]
        )
        lock, patches = Lock(), self.panels.patch

        def work(_: int, pair: tuple[int, list[int]]) -> None:
            s, near = pair
            rows = np.concatenate([self.tree.items(t) for t in near])
            here = np.arange(self.panel_tree.start[s], self.panel_tree.stop[s])
            for patch in np.unique(patches[here]):
                numbers = self.panels.number[here[patches[here] == patch]]
                pairs = np.tile(rows, len(numbers)), np.repeat(numbers, len(rows))
                panels, offset = self.panels.panels[patch], self.panels.space.offsets[patch]
                accumulator = NearAccumulator(
                    blocks, patch, offset, panels.surface.weights.shape[1], lock
                )
                interact_pairs(
                    self.mixed.kernel,
                    panels,
                    patch,
                    self.targets,
                    pairs,
                    self.quadrature,
                    accumulator,
                )

        run_tasks(work, list(above.items()), "near interactions")
        return blocks

    def far(self) -> tuple[list[SourceFactors], list[TargetFactors]]:
        """All crosses."""
        below: dict[int, list[int]] = {}
        for t, s in self.partition[0]:
            below.setdefault(s, []).append(t)
        jobs = sorted(below.items(), key=lambda job: -len(job[1]))
        made: dict[int, tuple[SourceFactors, list[Array]]] = {}

        def work(k: int, job: tuple[int, list[int]]) -> None:
            made[k] = self._crosses(*job)

        run_tasks(work, jobs, "far interactions")
        parts: dict[int, list[tuple[Array, Index]]] = {}
        first = 0
        for k, (_, near) in enumerate(jobs):
            for t, left in zip(near, made[k][1], strict=True):
                parts.setdefault(t, []).append((left, np.arange(first, first + len(left))))
                first += len(left)
            made[k][1].clear()
        # one cluster after the other, so that never everything is there twice
        target_factors = [self._target_factors(t, parts.pop(t)) for t in list(parts)]
        return [made[k][0] for k in range(len(jobs))], target_factors

    def _crosses(self, s: int, near: list[int]) -> tuple[SourceFactors, list[Array]]:
        """Crosses of a cluster of panels with clusters of targets: their rows together, and one
        table of columns a cluster of targets."""
        levels = [self._level(t, s) for t in near]
        clusters = {level: self._panel_cluster(s, level) for level in set(levels)}
        lefts: list[Array] = []
        rights: list[Array] = []
        for t, level in zip(near, levels, strict=True):
            at = np.ascontiguousarray(self.targets.position[:, self.tree.items(t)])
            crosses = cross_approximation(clusters[level], at, self.tolerance)
            left, right = recompressed(*crosses, self.tolerance)
            lefts.append(left.astype(self.dtype))
            rights.append(right.astype(self.dtype))
        return SourceFactors(self.functions_of(s), np.concatenate(rights)), lefts

    def _target_factors(self, t: int, group: list[tuple[Array, Index]]) -> TargetFactors:
        """All crosses of a cluster of targets."""
        tables, crosses = zip(*group, strict=True)
        part = slice(self.tree.start[t], self.tree.stop[t])
        return TargetFactors(part, np.concatenate(tables), np.concatenate(crosses))

    @cached_property
    def _points(self) -> Sources:
        return sources(self.panels, (POINTS,) * len(self.panels.panels))

    @cached_property
    def _nodes(self) -> list[Sources]:
        """Nodes of each of the ``orders``."""
        return [sources(self.panels, tuple(o)) for o in zip(*self.orders, strict=True)]

    def _level(self, t: int, s: int) -> int:
        """The first of the ``orders`` that is good enough between two clusters."""
        return int((self._reaches[:-1, s] > self._gap(t, s)).sum())

    def _panel_cluster(self, s: int, level: int) -> PanelCluster:
        part = slice(self.panel_tree.start[s], self.panel_tree.stop[s])
        numbers = self.functions_of(s)
        flat, first = self.functions
        starts = first[part.start : part.stop + 1]
        return PanelCluster(
            self.mixed,
            self._points.part(part),
            self._nodes[level].part(part),
            self.panels.patch[part],
            np.searchsorted(numbers, flat[starts[0] : starts[-1]]),
            starts - starts[0],
            len(numbers),
        )
