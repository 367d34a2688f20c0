"""What panels far from their targets do: tensor rules of low order through matrix products."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from cadbem.kernels.kernel import Index, Kernel
from cadbem.operators.panels import Nodes, Panels, tensor_nodes
from cadbem.operators.sinks import Sink
from cadbem.spline.basis import Array

TABLE = 8192  # pairs a table, to stay in cache
STRIP = 4  # panels side by side in one matrix product
TARGETS = 64  # at a time: what neighbouring panels add to them stays in cache
FEW = 8  # targets that are not worth an order of their own

Levels = NDArray[np.int8]


def far_field(
    kernel: Kernel,
    panels: Panels,
    position: Array,
    orders: Sequence[int],
    level: Levels,
    sink: Sink,
) -> None:
    """Add what panels do to targets at ``position`` (dim, T) to ``sink``.

    ``level`` (T, E) numbers, for each pair, the one of the ascending ``orders`` that resolves it;
    pairs beyond them are left out.  Panels side by side share the highest order any of them needs.
    """
    beyond = len(orders)
    grid = level.reshape(-1, *panels.shape)
    for low in range(0, len(grid), TARGETS):
        for a, strip in _strips(panels):
            levels = grid[low : low + TARGETS, a, strip]
            for k, rows in _by_order(levels, beyond):
                nodes, left_out = tensor_nodes(panels, orders[k]), levels[rows] == beyond
                _strip(kernel, panels, nodes, a, strip, position, low + rows, left_out, sink)


def _strips(panels: Panels) -> Iterator[tuple[int, slice]]:
    rows, columns = panels.shape
    for a in range(rows):
        for start in range(0, columns, STRIP):
            yield a, slice(start, min(start + STRIP, columns))


def _by_order(levels: Levels, beyond: int) -> Iterator[tuple[int, Index]]:
    """Orders that a strip needs, each with its targets."""
    highest = np.where(levels < beyond, levels, -1).max(axis=1)
    last = highest.max()
    for k in range(last + 1):
        rows = np.flatnonzero(highest == k)
        if len(rows) <= FEW and k < last:
            highest[rows] = k + 1
        else:
            yield k, rows


def _strip(
    kernel: Kernel,
    panels: Panels,
    nodes: Nodes,
    a: int,
    strip: slice,
    position: Array,
    rows: Index,
    left_out: NDArray[np.bool_],
    sink: Sink,
) -> None:
    """One strip with those targets that need the order of ``nodes``."""
    basis, part_u, part_v = nodes.basis(panels, a, strip)
    source, normal = flat(nodes.position[:, a, strip]), flat(nodes.normal[:, a, strip])
    count = min(max(TABLE // source.shape[1], 1), len(rows))
    room = np.empty(kernel.entries * count * source.shape[1])
    for low in range(0, len(rows), count):
        here = rows[low : low + count]
        table = kernel.block(position[:, here], source, normal, room)
        target, panel = np.nonzero(left_out[low : low + count])
        if len(target):
            by_panel = table.reshape(kernel.entries, len(here), left_out.shape[1], -1)
            by_panel[:, target, panel] = 0.0
        sink.block(here, table, basis, part_u, part_v)


def flat(values: Array) -> Array:
    """Vectors (dim, ...) with one index for all nodes."""
    return np.ascontiguousarray(values.reshape(len(values), -1))
