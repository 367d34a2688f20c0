"""Pairs of targets and panels that tensor rules resolve, through matrix products."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from cadbem.compiled import compiled
from cadbem.kernels.kernel import Index, Kernel
from cadbem.operators.panels import Panels, tensor_nodes
from cadbem.operators.sinks import Sink
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
    order: int,
    position: Array,
    target: Index,
    panel: Index,
    sink: Sink,
) -> None:
    """Add what panels do to targets at ``position`` (dim, T) by the tensor rule of ``order``.

    Pairs (target, panel), those of one panel one after the other.
    """
    nodes = tensor_nodes(panels, order)
    source, normal = nodes.flat
    width = nodes.weight.shape[2]
    shape = tuple(f.shape[1:] for f in nodes.functions)
    weight = nodes.weight.reshape(*panels.shape, *(s[0] for s in shape))
    control = panels.surface.weights
    count = max(TABLE // width, 1)
    table = np.zeros((kernel.entries, count * width))  # the last columns may stay unused
    room = np.empty((count, kernel.entries, *(s[1] for s in shape)))
    columns = width * np.arange(count)
    for low in range(0, len(panel), count):
        part = slice(low, low + count)
        rows, starts = target[part], width * panel[part]
        at = np.take(position, rows, axis=1)
        kernel.fill(at, starts, starts + width, columns, source, normal, table)
        (a, b), values = np.divmod(panel[part], panels.shape[1]), room[: len(rows)]
        _products(a, b, table, weight, *nodes.functions, *panels.first, control, values)
        sink.pairs(rows, panels.first[0][a], panels.first[1][b], values)


@compiled(fastmath=True)
def _products(a, b, table, weight, along_u, along_v, first_u, first_v, control, values):
    """Tables of pairs k times functions of their panels (a, b)[k]: values (pairs, entries, i, j).

    ``table`` (entries, pairs N) for N nodes, with ``weight`` (P_u, P_v, m_u, m_v) and functions
    ``along_u`` (P_u, m_u, i), ``along_v`` (P_v, m_v, j), of which the first ones are ``first_u``,
    ``first_v`` in the net ``control`` of weights.
    """
    pairs, entries = values.shape[:2]
    width, functions = weight.shape[2] * weight.shape[3], values.shape[2] * values.shape[3]
    basis = np.empty((width, functions))
    room = np.empty((pairs, functions))
    flat = values.reshape(pairs, entries, functions)
    low = 0
    while low < pairs:
        high = low + 1
        while high < pairs and a[high] == a[low] and b[high] == b[low]:
            high += 1
        _functions(a[low], b[low], weight, along_u, along_v, first_u, first_v, control, basis)
        out = room[: high - low]
        for e in range(entries):
            kernel = table[e, low * width : high * width].reshape(high - low, width)
            np.dot(kernel, basis, out)
            for k in range(high - low):
                for f in range(functions):
                    flat[low + k, e, f] = out[k, f]
        low = high


@compiled
def _functions(a, b, weight, along_u, along_v, first_u, first_v, control, basis):
    """Weighted functions on panel (a, b): into ``basis`` (nodes, functions)."""
    node = 0
    for k in range(weight.shape[2]):
        for m in range(weight.shape[3]):
            f = 0
            for i in range(along_u.shape[2]):
                value = weight[a, b, k, m] * along_u[a, k, i]
                for j in range(along_v.shape[2]):
                    scale = control[first_u[a] + i, first_v[b] + j]
                    basis[node, f] = value * along_v[b, m, j] * scale
                    f += 1
            node += 1
