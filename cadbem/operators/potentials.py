"""Potentials of given densities at fixed targets, as often as densities change.

What depends on geometry alone is computed once: the tensor rule of each panel, the pairs that are
too close for it, and the accurate integrals of those pairs.  An application then sums the
kernel over all nodes and adds these corrections.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from cadbem.kernels.kernel import Kernel, Sums
from cadbem.operators.accumulators import PotentialAccumulator, Record
from cadbem.operators.interactions import Targets, correct_close_pairs, interact
from cadbem.operators.layers import Task, tasks
from cadbem.operators.orders import reaches
from cadbem.operators.panels import Nodes, Panels, tensor_nodes
from cadbem.operators.parallel import run_tasks
from cadbem.quadrature import Rules
from cadbem.space import Space
from cadbem.spline.basis import Array


@dataclass(frozen=True, eq=False)
class Potentials:
    """S single + D double at ``targets``, without factors, for densities of a ``space``."""

    kernel: Kernel
    space: Space
    targets: Targets
    quadrature: Rules

    def apply(self, single: Array, double: Array) -> Array:
        """Potentials (rows, T) of coefficients ``single`` and ``double`` (components, F)."""
        patches = len(self.space.boundary.patches)
        results = np.zeros((patches, self.kernel.rows, self.targets.count))
        records = self._records

        def work(k: int, task: Task) -> None:
            patch, panels, rows = task
            shape, part = panels.surface.weights.shape, self.space.functions(patch)
            densities = [
                np.ascontiguousarray(d[:, part]).reshape(-1, *shape) for d in (single, double)
            ]
            accumulator = self._accumulator(
                np.zeros((self.kernel.rows, rows.stop - rows.start)), densities
            )
            if self.kernel.sums is None:
                here = self.targets.part(rows)
                interact(self.kernel, panels, patch, here, self.quadrature, accumulator)
            else:
                self._sum(self.kernel.sums, self._parts[k], task, densities, accumulator.result)
                records[k].replay(accumulator)
            results[patch][:, rows] = accumulator.result

        run_tasks(work, self._tasks, "fields")
        return results.sum(axis=0)

    def _accumulator(self, result: Array, densities: Sequence[Array]) -> PotentialAccumulator:
        return PotentialAccumulator(result, (self.kernel.single, self.kernel.double), densities)

    @cached_property
    def _tasks(self) -> list[Task]:
        return tasks(self.space, self.targets.count)

    @cached_property
    def _records(self) -> list[Record]:
        """The corrections of each task, for kernels that have sums."""
        records = [Record() for _ in self._tasks]

        def work(k: int, task: Task) -> None:
            patch, panels, rows = task
            here, record = self.targets.part(rows), records[k]
            correct_close_pairs(
                self.kernel, panels, patch, here, self.quadrature, record, record.negative
            )

        if self.kernel.sums is not None:
            run_tasks(work, self._tasks, "near fields")
        return records

    @cached_property
    def _parts(self) -> list[list[_Part]]:
        """For each task its panels by the order that all of its targets allow."""
        return [list(self._by_order(*task)) for task in self._tasks]

    def _by_order(self, _: int, panels: Panels, rows: slice) -> Iterator[_Part]:
        degree = max(panels.surface.degrees)
        orders = self.quadrature.far_orders(degree)
        reach = reaches(panels, orders, self.quadrature)[:-1]
        highest = panels.levels(self.targets.position[:, rows], reach).max(axis=0)
        for k in np.unique(highest):
            nodes = tensor_nodes(panels, orders[k])
            chosen = np.repeat(highest == k, nodes.weight.shape[2])
            position, normal = (np.ascontiguousarray(x[:, chosen]) for x in nodes.flat)
            yield _Part(nodes, chosen, position, normal)

    def _sum(
        self,
        sums: Sums,
        parts: Sequence[_Part],
        task: Task,
        densities: Sequence[Array],
        out: Array,
    ) -> None:
        """Add both layers' potentials (dim, T) by tensor rules on all panels."""
        _, panels, rows = task
        at = np.ascontiguousarray(self.targets.position[:, rows])
        for part in parts:
            if densities[0].any():
                sums.single(at, part.position, part.weighted(panels, densities[0]), out)
            if densities[1].any():
                weighted = part.weighted(panels, densities[1])
                sums.double(at, np.zeros_like(at), part.position, part.normal, weighted, out)


@dataclass(frozen=True, eq=False)
class _Part:
    """The ``nodes`` of a patch that are ``chosen``, at ``position``, with ``normal`` (dim, N)."""

    nodes: Nodes
    chosen: NDArray[np.bool_]
    position: Array
    normal: Array

    def weighted(self, panels: Panels, density: Array) -> Array:
        """Weighted values (components, N) of coefficients (components, n_u, n_v)."""
        return np.ascontiguousarray(self.nodes.densities(panels, density)[:, self.chosen])
