"""Interactions of a patch with targets: far, middle and near pairs through one contraction.

A pair of a target and a panel is *far* when the lowest tensor rule resolves it, *middle* when a
higher one does, *near* otherwise (then the rule is polar, see ``cadbem.quadrature.near``).  All
three give nodes and weights; the kernel fills a table; the table times the weighted functions
goes to a sink: matrix entries, or potentials of given densities.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cadbem.kernels.kernel import Index, Kernel
from cadbem.operators.far import far_field, flat
from cadbem.operators.panels import Nodes, Panels, tensor_nodes
from cadbem.operators.sinks import Sink
from cadbem.quadrature import Rules, near
from cadbem.spline.basis import Array

NODE_CAPACITY = 1 << 16  # nodes a table of near pairs


@dataclass(frozen=True, eq=False)
class Targets:
    """Points (dim, T) where potentials are wanted.

    A point that lies on the boundary names its patch in ``owner`` (T,) and its ``parameters``
    (dim - 1, T) there; the owner of any other point is -1.
    """

    position: Array
    owner: Index
    parameters: Array

    @classmethod
    def free(cls, position: Array) -> Targets:
        """Points off the boundary."""
        dim, count = position.shape
        return cls(position, np.full(count, -1), np.zeros((dim - 1, count)))

    @property
    def count(self) -> int:
        """Number of targets."""
        return self.position.shape[1]

    def part(self, chosen: slice) -> Targets:
        """Some of the targets."""
        return Targets(self.position[:, chosen], self.owner[chosen], self.parameters[:, chosen])


def interact(
    kernel: Kernel,
    panels: Panels,
    patch: int,
    targets: Targets,
    quadrature: Rules,
    sink: Sink,
) -> None:
    """Add everything that ``patch`` does to ``targets`` to ``sink``."""
    degree = max(panels.surface.degrees)
    orders = *quadrature.lower_orders(degree), quadrature.orders(degree)[0]
    level = panels.levels(targets.position, [quadrature.reach(m, degree) for m in orders])
    far_field(kernel, panels, targets.position, orders, level, sink)
    close = _Close.of(panels, patch, targets, quadrature, *np.nonzero(level == len(orders)))
    for k, order in enumerate(close.orders):
        _middle(kernel, panels, tensor_nodes(panels, order), targets, *close.pairs(k), sink)
    _near(kernel, panels, targets, close, quadrature, sink)


def interact_pairs(
    kernel: Kernel,
    panels: Panels,
    patch: int,
    targets: Targets,
    pairs: tuple[Index, Index],
    quadrature: Rules,
    sink: Sink,
) -> None:
    """Add what panels do to targets to ``sink``, for given pairs (targets, panels) alone."""
    target, panel = pairs
    degree = max(panels.surface.degrees)
    reach = quadrature.reach(quadrature.orders(degree)[0], degree) * panels.lengths
    centres, radii = panels.sphere
    away = np.linalg.norm(targets.position[:, target] - centres[:, panel], axis=0)
    far = away > (reach + radii)[panel]
    lowest = tensor_nodes(panels, quadrature.orders(degree)[0])
    _middle(kernel, panels, lowest, targets, target[far], panel[far], sink)
    close = _Close.of(panels, patch, targets, quadrature, target[~far], panel[~far])
    for k, order in enumerate(close.orders):
        _middle(kernel, panels, tensor_nodes(panels, order), targets, *close.pairs(k), sink)
    _near(kernel, panels, targets, close, quadrature, sink)


def mend(
    kernel: Kernel,
    panels: Panels,
    patch: int,
    targets: Targets,
    quadrature: Rules,
    sink: Sink,
    against: Sink,
) -> None:
    """Replace the lowest tensor rule where it is not good enough.

    What it gives for pairs that are too close goes to ``against``, a sink that takes away; the
    right contributions go to ``sink``.
    """
    close = _Close.find(panels, patch, targets, quadrature)
    for k, order in enumerate(close.orders):
        if k:
            lowest = tensor_nodes(panels, close.orders[0])
            _middle(kernel, panels, lowest, targets, *close.pairs(k), against)
            _middle(kernel, panels, tensor_nodes(panels, order), targets, *close.pairs(k), sink)
    last = len(close.orders)
    lowest = tensor_nodes(panels, close.orders[0])
    _middle(kernel, panels, lowest, targets, *close.pairs(last), against)
    _near(kernel, panels, targets, close, quadrature, sink)


@dataclass(frozen=True, eq=False)
class _Close:
    """Pairs of targets and panels that may be too close for the lowest of the ``orders``.

    ``closest`` (3, pairs): u, v within the panel, distance; ``level`` (pairs,): the first order
    that is good enough, their number if none is.
    """

    orders: tuple[int, ...]
    target: Index
    panel: Index
    closest: Array
    level: Index

    @classmethod
    def find(cls, panels: Panels, patch: int, targets: Targets, quadrature: Rules) -> _Close:
        """The close pairs of a patch."""
        degree = max(panels.surface.degrees)
        reach = quadrature.reach(quadrature.orders(degree)[0], degree) * panels.lengths
        target, panel = panels.close_pairs(targets.position, reach)
        return cls.of(panels, patch, targets, quadrature, target, panel)

    @classmethod
    def of(
        cls,
        panels: Panels,
        patch: int,
        targets: Targets,
        quadrature: Rules,
        target: Index,
        panel: Index,
    ) -> _Close:
        """Given pairs of a patch."""
        degree = max(panels.surface.degrees)
        orders = quadrature.orders(degree)
        closest = _closest(panels, patch, targets, target, panel)
        ratio = closest[2] / panels.lengths[panel]
        level = np.zeros(len(ratio), dtype=np.int64)
        for order in orders:
            level += ratio < quadrature.reach(order, degree)
        return cls(orders, target, panel, closest, level)

    def pairs(self, level: int) -> tuple[Index, Index]:
        """Targets and panels of one level."""
        return self.target[self.level == level], self.panel[self.level == level]


def _closest(
    panels: Panels, patch: int, targets: Targets, close_target: Index, close_panel: Index
) -> Array:
    """Closest points (3, pairs): u, v within the panel, distance; exact for a patch's own."""
    result = panels.closest(targets.position, close_target, close_panel)
    grid = np.divmod(close_panel, panels.shape[1])
    own = targets.owner[close_target] == patch
    pairs = np.arange(len(own))
    for direction, parameter in enumerate(targets.parameters):
        inside = panels.locate(direction, parameter[close_target])
        own &= inside[pairs, grid[direction]]
    for direction, parameter in enumerate(targets.parameters):
        local = panels.local(direction, parameter[close_target[own]], grid[direction][own])
        result[direction, own] = local
    result[2, own] = 0.0
    return result


def _middle(
    kernel: Kernel,
    panels: Panels,
    nodes: Nodes,
    targets: Targets,
    close_target: Index,
    close_panel: Index,
    sink: Sink,
) -> None:
    if len(close_panel) == 0:
        return
    order = np.argsort(close_panel, kind="stable")
    chosen, starts = np.unique(close_panel[order], return_index=True)
    for panel, rows in zip(chosen, np.split(close_target[order], starts[1:]), strict=True):
        a, b = divmod(int(panel), panels.shape[1])
        basis, part_u, part_v = nodes.basis(panels, a, slice(b, b + 1))
        here = np.ascontiguousarray(targets.position[:, rows])
        position, normal = flat(nodes.position[:, a, b]), flat(nodes.normal[:, a, b])
        room = np.empty(kernel.entries * len(rows) * len(basis))
        table = kernel.block(here, position, normal, room)
        sink.block(rows, table, basis, part_u, part_v)


def _near(
    kernel: Kernel,
    panels: Panels,
    targets: Targets,
    close: _Close,
    quadrature: Rules,
    sink: Sink,
) -> None:
    close_target, close_panel = close.pairs(len(close.orders))
    closest = close.closest[:, close.level == len(close.orders)]
    p, q = panels.surface.degrees
    dim, capacity = targets.position.shape[0], NODE_CAPACITY
    position, normal = np.empty((dim, capacity)), np.empty((dim, capacity))
    weight, foot = np.empty(capacity), np.empty((dim, len(close_target)))
    bu, bv = np.empty((p + 1, capacity)), np.empty((q + 1, capacity))
    starts, gauss = np.empty(len(close_target) + 1, dtype=np.int64), near.gauss_table()
    pieces = quadrature.pieces(panels.lengths[close_panel], closest[2])
    curve, poles = (np.empty((p + 1, dim)), None) if dim == 2 else (None, panels.poles)
    u, v, distance = map(np.ascontiguousarray, closest)
    done = 0
    while done < len(close_target):
        count = near.place_nodes(
            panels.flat_nets, poles, close_panel, done, u, v, distance,
            quadrature.tolerance, pieces, quadrature.order, gauss,
            starts, foot, curve, position, normal, weight, bu, bv,
        )  # fmt: skip
        rows = close_target[done : done + count]
        part = starts[: count + 1]
        here = targets.position[:, rows] - foot[:, :count]
        here[:, distance[done : done + count] == 0.0] = 0.0
        if not kernel.invariant:
            here += foot[:, :count]
            position[:, : part[-1]] += np.repeat(foot[:, :count], np.diff(part), axis=1)
        table = kernel.rows_of(here, part, position, normal)
        moments = np.empty((count, kernel.entries, p + 1, q + 1))
        near.moments(part, table, weight, bu, bv, moments)
        _add_moments(panels, rows, close_panel[done : done + count], moments, sink)
        done += count


def _add_moments(panels: Panels, rows: Index, panel: Index, moments: Array, sink: Sink) -> None:
    """From Bernstein moments to the patch's rational functions."""
    a, b = np.divmod(panel, panels.shape[1])
    first_u, first_v = panels.first[0][a], panels.first[1][b]
    # (pairs, entries, i, j) with extraction (pairs, i, function)
    along = np.matmul(moments, panels.extraction[1][b][:, None])
    values = np.matmul(panels.extraction[0][a].swapaxes(1, 2)[:, None], along)
    p, q = panels.surface.degrees
    u = (first_u[:, None] + np.arange(p + 1))[:, :, None]
    v = (first_v[:, None] + np.arange(q + 1))[:, None, :]
    values *= panels.surface.weights[u, v][:, None]
    sink.pairs(rows, first_u, first_v, values)
