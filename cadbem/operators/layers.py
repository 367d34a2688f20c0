"""Single and double layer of a space as matrices between functions and targets."""

from __future__ import annotations

import os
from dataclasses import dataclass
from itertools import product

import numpy as np

from cadbem.kernels.kernel import Kernel
from cadbem.operators.accumulators import MatrixAccumulator, PotentialAccumulator
from cadbem.operators.groups import groups, in_shares_of
from cadbem.operators.interactions import Targets, interact
from cadbem.operators.panels import Panels, split_patch
from cadbem.operators.parallel import run_tasks
from cadbem.quadrature import Rules
from cadbem.space import Space
from cadbem.spline.basis import Array

TARGET_CHUNKS = 512, 2048  # targets a task, at least and at most
SHARES = 2  # tasks of each patch for each core

Task = tuple[int, Panels, slice]  # a patch's number, its panels, some targets


@dataclass(frozen=True, eq=False)
class Layers:
    """Single and double layer, without factors, from a space's functions to T targets.

    ``entries`` (entries, T, F) holds the kernel's distinct numbers: for few targets.
    """

    kernel: Kernel
    space: Space
    entries: Array

    @property
    def count(self) -> int:
        """Number of targets."""
        return self.entries.shape[1]

    def apply(self, single: Array, double: Array) -> Array:
        """S @ single + D @ double for coefficients (components, F): shape (rows, T)."""
        result = np.zeros((self.kernel.rows, self.count))
        for layout, density in ((self.kernel.single, single), (self.kernel.double, double)):
            for i, row in enumerate(layout):
                for j, entry in enumerate(row):
                    result[i] += self.entries[entry] @ density[j]
        return result

    def columns(self, patch: int, single: Array, double: Array) -> Array:
        """Matrix (rows, T, k, n) of the map q -> S (single q) + D (double q) on one patch.

        ``single`` and ``double`` (components, k) act alike on each of the patch's functions.
        """
        part = self.entries[:, :, self.space.functions(patch)]
        return mixed_columns(self.kernel, part, single, double)


@dataclass(frozen=True, eq=False)
class OwnLayers:
    """Single and double layer, without factors, from a space's functions to its own collocation
    points, without matrices: ``apply`` and ``columns`` integrate each time.

    ``tolerance`` of systems beyond round-off.
    """

    kernel: Kernel
    space: Space
    quadrature: Rules
    tolerance: float = 0.0

    @property
    def count(self) -> int:
        """Number of targets."""
        return self.space.count

    def apply(self, single: Array, double: Array) -> Array:
        """S @ single + D @ double for coefficients (components, F): shape (rows, T).

        Only patches with densities cost anything.
        """
        targets = collocation_targets(self.space)
        return applied(self.kernel, self.space, targets, self.quadrature, single, double)

    def columns(self, patch: int, single: Array, double: Array) -> Array:
        """Matrix (rows, T, k, n) of the map q -> S (single q) + D (double q) on one patch."""
        kernel = self.kernel if double.any() else self.kernel.single_alone
        targets = collocation_targets(self.space)
        entries = assemble_patch(kernel, self.space, patch, targets, self.quadrature)
        return mixed_columns(kernel, entries, single, double)


def mixed_columns(kernel: Kernel, entries: Array, single: Array, double: Array) -> Array:
    """Matrix (rows, T, k, n) from a kernel's ``entries`` (·, T, n): see ``Layers.columns``."""
    result = np.zeros((kernel.rows, entries.shape[1], single.shape[1], entries.shape[2]))
    add_mixed(kernel, entries, single, double, result)
    return result


def add_mixed(kernel: Kernel, entries: Array, single: Array, double: Array, result: Array) -> None:
    """Add the same to ``result``."""
    for layout, mixing in ((kernel.single, single), (kernel.double, double)):
        for i, j, k in product(*map(range, (len(layout), *mixing.shape))):
            if mixing[j, k] != 0.0:
                result[i, :, k] += mixing[j, k] * entries[layout[i][j]]


def collocation_targets(space: Space) -> Targets:
    """The collocation points of a space as targets, with their patches and parameters."""
    owner = np.repeat(np.arange(len(space.parameters)), np.diff(space.offsets))
    return Targets(space.collocation.position, owner, np.concatenate(space.parameters, axis=1))


def assemble_layers(kernel: Kernel, space: Space, targets: Targets, quadrature: Rules) -> Layers:
    """Compute both layers from a space to targets; on the boundary, principal values."""
    entries = np.zeros((kernel.entries, targets.count, space.count))

    def work(_: int, task: Task) -> None:
        patch, panels, rows = task
        columns, offset = panels.surface.weights.shape[1], space.functions(patch).start
        accumulator = MatrixAccumulator(entries, columns, rows.start, offset)
        interact(kernel, panels, patch, targets.part(rows), quadrature, accumulator)

    run_tasks(work, tasks(space, targets.count), "boundary integrals")
    return Layers(kernel, space, entries)


def applied(
    kernel: Kernel,
    space: Space,
    targets: Targets,
    quadrature: Rules,
    single: Array,
    double: Array,
) -> Array:
    """S @ single + D @ double at targets for coefficients (components, F), without matrices.

    On the boundary, principal values.  Only patches with densities cost anything: (rows, T).
    """
    active = [
        any(d[:, space.functions(i)].any() for d in (single, double))
        for i in range(len(space.parameters))
    ]
    kernel = kernel if double.any() else kernel.single_alone
    layouts = [x for x in (kernel.single, kernel.double) if x]
    shared = in_shares_of(space, targets)
    together = [group for group in groups(space, active) if active[group.patches[0]]]
    jobs = list(product(range(len(together)), chunks(targets.count)))
    results = np.zeros((len(together), kernel.rows, targets.count))

    def work(_: int, job: tuple[int, slice]) -> None:
        group, rows = together[job[0]], job[1]
        densities = [group.gathered(space, d) for d in (single, double)][: len(layouts)]
        result = np.zeros((kernel.rows, rows.stop - rows.start))
        accumulator = PotentialAccumulator(result, layouts, densities)
        here = group.targets(shared.part(rows))
        interact(kernel, group.panels, group.owner, here, quadrature, accumulator)
        results[job[0]][:, rows] = result

    run_tasks(work, jobs, "boundary integrals")
    return results.sum(axis=0)


def assemble_patch(
    kernel: Kernel, space: Space, patch: int, targets: Targets, quadrature: Rules
) -> Array:
    """Entries (entries, T, n) of both layers of one patch."""
    whole = tasks(space, targets.count)
    jobs = [job for job in whole if job[0] == patch]
    count = jobs[0][1].surface.weights.size
    entries = np.zeros((kernel.entries, targets.count, count))

    def work(_: int, task: Task) -> None:
        _, panels, rows = task
        accumulator = MatrixAccumulator(entries, panels.surface.weights.shape[1], rows.start)
        interact(kernel, panels, patch, targets.part(rows), quadrature, accumulator)

    run_tasks(work, jobs, "boundary integrals")
    return entries


def tasks(space: Space, count: int) -> list[Task]:
    """Each patch with each chunk of ``count`` targets, the most work first."""
    panels = [split_patch(p.surface) for p in space.boundary.patches]
    jobs = [(i, panels[i], rows) for i, rows in product(range(len(panels)), chunks(count))]
    return sorted(jobs, key=lambda job: -len(job[1].flat_nets) * (job[2].stop - job[2].start))


def chunks(count: int) -> list[slice]:
    """Parts of ``count`` targets that are enough for all cores."""
    chunk = int(np.clip(-(-count // (SHARES * (os.cpu_count() or 1))), *TARGET_CHUNKS))
    return [slice(k, min(k + chunk, count)) for k in range(0, count, chunk)]
