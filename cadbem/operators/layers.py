"""Single and double layer of a space: as matrices between functions and targets, or applied."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from itertools import product

import numpy as np
from threadpoolctl import threadpool_limits
from tqdm import tqdm

from cadbem.kernels.kernel import Kernel, Layout, Sums
from cadbem.operators.interactions import Targets, interact, mend
from cadbem.operators.panels import Panels, split_patch, tensor_nodes
from cadbem.operators.sinks import MatrixSink, PotentialSink
from cadbem.quadrature import Rules
from cadbem.space import Space
from cadbem.spline.basis import Array

TARGET_CHUNK = 2048  # targets a task


@dataclass(frozen=True, eq=False)
class Layers:
    """Single and double layer, without factors, from a space's functions to T targets.

    ``entries`` (entries, T, F) holds the kernel's distinct numbers; ``apply`` and ``columns``
    are the face that problems see.
    """

    kernel: Kernel
    space: Space
    entries: Array

    def apply(self, single: Array, double: Array) -> Array:
        """S @ single + D @ double for coefficients (components, F): shape (rows, T)."""
        result = np.zeros((self.kernel.rows, self.entries.shape[1]))
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
        shape = (self.kernel.rows, part.shape[1], single.shape[1], part.shape[2])
        result = np.zeros(shape)
        for layout, mixing in ((self.kernel.single, single), (self.kernel.double, double)):
            for i, j, k in product(*map(range, (len(layout), *mixing.shape))):
                if mixing[j, k] != 0.0:
                    result[i, :, k] += mixing[j, k] * part[layout[i][j]]
        return result


def collocation_targets(space: Space) -> Targets:
    """The collocation points of a space as targets that know where they lie."""
    owner = np.repeat(np.arange(len(space.parameters)), np.diff(space.offsets))
    return Targets(space.collocation.position, owner, np.concatenate(space.parameters, axis=1))


def assemble_layers(kernel: Kernel, space: Space, targets: Targets, quadrature: Rules) -> Layers:
    """Compute both layers from a space to targets; on the boundary, principal values."""
    entries = np.zeros((kernel.entries, targets.count, space.count))

    def task(patch: int, panels: Panels, rows: slice) -> None:
        shape = panels.surface.weights.shape
        part = entries[:, rows, space.functions(patch)]
        sink = MatrixSink(part.reshape(*part.shape[:2], *shape, copy=False))
        interact(kernel, panels, patch, targets.part(rows), quadrature, sink)

    _run(task, space, targets.count, "boundary integrals")
    return Layers(kernel, space, entries)


def potentials(
    kernel: Kernel,
    space: Space,
    targets: Targets,
    quadrature: Rules,
    single: Array,
    double: Array,
) -> Array:
    """Both layers' potentials S single + D double at targets: (rows, T), without factors.

    ``single`` and ``double`` (components, F) are coefficients.
    """
    layouts: tuple[Layout, Layout] = (kernel.single, kernel.double)
    results = np.zeros((len(space.boundary.patches), kernel.rows, targets.count))

    def task(patch: int, panels: Panels, rows: slice) -> None:
        shape = panels.surface.weights.shape
        part, here = space.functions(patch), targets.part(rows)
        densities = [d[:, part].reshape(-1, *shape) for d in (single, double)]
        sink = PotentialSink(results[patch][:, rows], layouts, densities)
        if kernel.sums is None:
            interact(kernel, panels, patch, here, quadrature, sink)
            return
        results[patch][:, rows] += _summed(kernel.sums, panels, here, quadrature, densities)
        against = PotentialSink(results[patch][:, rows], layouts, [-d for d in densities])
        mend(kernel, panels, patch, here, quadrature, sink, against)

    _run(task, space, targets.count, "fields")
    return results.sum(axis=0)


def _summed(
    sums: Sums, panels: Panels, targets: Targets, quadrature: Rules, densities: Sequence[Array]
) -> Array:
    """Both layers' potentials (dim, T) by the lowest tensor rule on all panels."""
    nodes = tensor_nodes(panels, quadrature.orders(max(panels.surface.degrees))[0])
    position, normal = nodes.flat
    at, out = np.ascontiguousarray(targets.position), np.zeros(targets.position.shape)
    single, double = (nodes.densities(panels, d) for d in densities)
    if densities[0].any():
        sums.single(at, position, single, out)
    if densities[1].any():
        sums.double(at, np.zeros_like(out), position, normal, double, out)
    return out


def _run(task: Callable[[int, Panels, slice], None], space: Space, count: int, label: str) -> None:
    """Run a task for each patch and chunk of targets on all cores; results do not overlap."""
    panels = [split_patch(p.surface) for p in space.boundary.patches]
    chunks = [slice(k, min(k + TARGET_CHUNK, count)) for k in range(0, count, TARGET_CHUNK)]
    jobs = list(product(range(len(panels)), chunks))
    with threadpool_limits(1), ThreadPoolExecutor(os.cpu_count()) as pool:
        futures = [pool.submit(task, i, panels[i], rows) for i, rows in jobs]
        try:
            for future in _progress(futures, label):
                future.result()
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            raise


def _progress(futures: list, label: str) -> Iterable:
    return tqdm(futures, desc=label, delay=2.0, leave=False, disable=None)
