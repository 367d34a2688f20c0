"""Pairs of targets and panels that tensor rules resolve, through matrix products."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from cadbem.kernels.kernel import Index, Kernel
from cadbem.operators.accumulators import Accumulator
from cadbem.operators.panels import Panels, nodes_of_some, tensor_nodes
from cadbem.spline.basis import Array

TABLE = 8192  # nodes a table, to stay in cache
TARGETS = 128  # at a time: what neighbouring panels add to them stays in cache


def by_blocks(chosen: NDArray[np.bool_]) -> tuple[Index, Index]:
    """Pairs of targets and panels that are ``chosen`` (T, E): a few targets with all panels, the
    next few, and so on."""
    count, panels = chosen.shape
    blocks = np.zeros((-(-count // TARGETS), TARGETS, panels), dtype=bool)
    blocks.reshape(-1, panels)[:count] = chosen
    block, panel, target = np.nonzero(blocks.swapaxes(1, 2))
    return TARGETS * block + target, panel


def add_tensor(
    kernel: Kernel,
    panels: Panels,
    order: int | tuple[int, int],
    position: Array,
    target: Index,
    panel: Index,
    accumulator: Accumulator,
) -> None:
    """Add what panels do to targets at ``position`` (dim, T) by the tensor rule of ``order``, or of
    two orders, one in each direction.

    Pairs (target, panel), those of one panel one after the other.
    """
    if not len(panel):
        return
    present = np.bincount(panel) > 0
    chosen, places = np.flatnonzero(present), np.cumsum(present) - 1
    if isinstance(order, tuple):
        *nodes, functions = nodes_of_some(panels, order, chosen)
        number = places
    else:
        all_nodes, number = tensor_nodes(panels, order), np.arange(len(present))
        nodes, functions = list(all_nodes.flat), all_nodes.weighted(panels, chosen)
    width, shape = functions.shape[1], [degree + 1 for degree in panels.surface.degrees]
    count = max(TABLE // width, 1)
    table = np.zeros((kernel.entries, count * width))  # the last columns may stay unused
    room = np.empty((count, kernel.entries, *shape))
    columns = width * np.arange(count)
    for low in range(0, len(panel), count):
        rows, here = target[low : low + count], panel[low : low + count]
        at, starts = np.take(position, rows, axis=1), width * number[here]
        kernel.fill(at, starts, starts + width, columns, *nodes, table)
        part = table[:, : width * len(rows)].reshape(len(table), -1, width)
        values = room[: len(rows)]
        _products(part, functions, places[here], values.reshape(*values.shape[:2], -1))
        a, b = np.divmod(here, panels.shape[1])
        accumulator.pairs(rows, panels.first[0][a], panels.first[1][b], values)


def _products(table: Array, functions: Array, number: Index, values: Array) -> None:
    """Tables (entries, pairs, N) of pairs times ``functions``[number] (N, ·), a ``number`` for each
    pair: into ``values`` (pairs, entries, ·)."""
    values = values.swapaxes(0, 1)
    ends = [*np.flatnonzero(number[1:] != number[:-1]).tolist(), len(number) - 1]
    low = 0
    for end in ends:
        high = end + 1
        np.matmul(table[:, low:high], functions[number[end]], out=values[:, low:high])
        low = high
