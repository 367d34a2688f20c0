"""Interactions of a patch with targets: far, middle and near pairs.

A pair of a target and a panel is *far* when the ball around the panel shows that a tensor rule of
low order resolves it, *middle* when a tensor rule does by the distance to the closest point, *near*
otherwise (then the rule is polar, see ``cadbem.quadrature.near``).  All three give nodes and
weights; the kernel fills a table; the table times the weighted functions goes to an
accumulator: matrix entries, or potentials of given densities.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cadbem.kernels.kernel import Index, Kernel
from cadbem.operators.accumulators import Accumulator
from cadbem.operators.orders import reaches
from cadbem.operators.panels import Panels
from cadbem.operators.tensor import add_tensor, by_blocks
from cadbem.quadrature import Rules, near
from cadbem.quadrature.polar import WHOLE
from cadbem.spline.basis import Array

NODE_CAPACITY = 1 << 16  # nodes a table of near pairs
MOST_NODES = 1200  # of a tensor rule: more are slower than a polar rule


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
        position = np.ascontiguousarray(self.position[:, chosen])
        return Targets(position, self.owner[chosen], self.parameters[:, chosen])


def interact(
    kernel: Kernel,
    panels: Panels,
    patch: int | Index,
    targets: Targets,
    quadrature: Rules,
    accumulator: Accumulator,
) -> None:
    """Add everything that ``patch`` does to ``targets`` to ``accumulator``.

    Where several patches are taken for one, ``patch`` is the owner of each row of panels.
    """
    orders = quadrature.far_orders(max(panels.surface.degrees))
    level = panels.levels(targets.position, reaches(panels, orders, quadrature))
    for k, order in enumerate(orders):
        target, panel = by_blocks(level == k)
        add_tensor(kernel, panels, order, targets.position, target, panel, accumulator)
    close = by_blocks(level == len(orders))
    _add_close(kernel, panels, patch, targets, close, quadrature, accumulator)


def interact_pairs(
    kernel: Kernel,
    panels: Panels,
    patch: int | Index,
    targets: Targets,
    pairs: tuple[Index, Index],
    quadrature: Rules,
    accumulator: Accumulator,
) -> None:
    """Add what panels do to targets to ``accumulator``, for given pairs (targets, panels) alone."""
    by_panel = np.argsort(pairs[1], kind="stable")
    target, panel = pairs[0][by_panel], pairs[1][by_panel]
    orders = quadrature.far_orders(max(panels.surface.degrees))
    centres, radii = panels.sphere
    away = np.linalg.norm(targets.position[:, target] - centres[:, panel], axis=0) - radii[panel]
    level = (away < reaches(panels, orders, quadrature)[:, panel]).sum(axis=0)
    for k, order in enumerate(orders):
        far = target[level == k], panel[level == k]
        add_tensor(kernel, panels, order, targets.position, *far, accumulator)
    rest = level == len(orders)
    _add_close(kernel, panels, patch, targets, (target[rest], panel[rest]), quadrature, accumulator)


def _add_close(
    kernel: Kernel,
    panels: Panels,
    patch: int | Index,
    targets: Targets,
    pairs: tuple[Index, Index],
    quadrature: Rules,
    accumulator: Accumulator,
) -> None:
    """Add pairs that may be too close for the lowest of the rule's orders."""
    close = _Close.of(panels, patch, targets, quadrature, *pairs)
    close.add_tensors(kernel, targets, accumulator)
    _near(kernel, panels, targets, close, quadrature, accumulator)


def correct_close_pairs(
    kernel: Kernel,
    panels: Panels,
    patch: int | Index,
    targets: Targets,
    quadrature: Rules,
    accumulator: Accumulator,
    against: Accumulator,
) -> None:
    """Replace the lowest tensor rule where it is not good enough.

    What it gives for pairs that are too close goes to ``against``, an accumulator that takes
    away; the right contributions go to ``accumulator``.
    """
    degree = max(panels.surface.degrees)
    lowest = quadrature.orders(degree)[0]
    level = panels.levels(targets.position, reaches(panels, (lowest,), quadrature))
    close = _Close.of(panels, patch, targets, quadrature, *by_blocks(level > 0))
    bad = close.level.max(axis=0) > 0
    close.add_tensors(kernel, targets, accumulator, bad)
    pairs = close.target[bad], close.panel[bad]
    add_tensor(kernel, panels, lowest, targets.position, *pairs, against)
    _near(kernel, panels, targets, close, quadrature, accumulator)


@dataclass(frozen=True, eq=False)
class _Close:
    """Pairs of targets and panels that may be too close for the lowest of the ``orders``.

    ``closest`` (3, pairs): u, v within the panel, distance; ``level`` (2, pairs): the first order
    that is good enough in each direction; both their number if there is none, or if a polar rule
    needs fewer nodes.
    """

    panels: Panels
    orders: tuple[int, ...]
    target: Index
    panel: Index
    closest: Array
    level: Index

    @classmethod
    def of(
        cls,
        panels: Panels,
        patch: int | Index,
        targets: Targets,
        quadrature: Rules,
        target: Index,
        panel: Index,
    ) -> _Close:
        """Given pairs of a patch, those of one panel one after the other."""
        degree = max(panels.surface.degrees)
        orders = quadrature.orders(degree)
        closest = _closest(panels, patch, targets, target, panel)
        level = np.zeros((2, len(target)), dtype=np.int64)
        for order in orders:
            level += closest[2] < quadrature.reach(order, degree) * panels.sides[:, panel]
        counts = np.array([*orders, MOST_NODES])[level]
        level[:, counts[0] * counts[1] >= MOST_NODES] = len(orders)
        return cls(panels, orders, target, panel, closest, level)

    @property
    def left(self) -> NDArray[np.bool_]:
        """Pairs (pairs,) for polar rules."""
        return self.level[0] == len(self.orders)

    def add_tensors(
        self,
        kernel: Kernel,
        targets: Targets,
        accumulator: Accumulator,
        chosen: NDArray[np.bool_] | None = None,
    ) -> None:
        """Add the pairs for tensor rules, or only those of them that are ``chosen`` (pairs,)."""
        most = len(self.orders)
        key = np.where(self.left, -1, self.level[0] * most + self.level[1])
        if chosen is not None:
            key[~chosen] = -1
        for number in np.unique(key[key >= 0]):
            here = key == number
            orders = self.orders[number // most], self.orders[number % most]
            pairs = self.target[here], self.panel[here]
            add_tensor(kernel, self.panels, orders, targets.position, *pairs, accumulator)


def _closest(
    panels: Panels, patch: int | Index, targets: Targets, close_target: Index, close_panel: Index
) -> Array:
    """Closest points (3, pairs): u, v within the panel, distance; exact for a patch's own."""
    result = panels.closest(targets.position, close_target, close_panel)
    grid = np.divmod(close_panel, panels.shape[1])
    own = targets.owner[close_target] == np.broadcast_to(patch, panels.shape[0])[grid[0]]
    pairs = np.arange(len(own))
    for direction, parameter in enumerate(targets.parameters):
        inside = panels.locate(direction, parameter[close_target])
        own &= inside[pairs, grid[direction]]
    for direction, parameter in enumerate(targets.parameters):
        local = panels.local(direction, parameter[close_target[own]], grid[direction][own])
        result[direction, own] = local
    result[2, own] = 0.0
    return result


def _near(
    kernel: Kernel,
    panels: Panels,
    targets: Targets,
    close: _Close,
    quadrature: Rules,
    accumulator: Accumulator,
) -> None:
    left = close.left
    close_target, close_panel = close.target[left], close.panel[left]
    closest = close.closest[:, left]
    p, q = panels.surface.degrees
    dim, capacity = targets.position.shape[0], NODE_CAPACITY
    position, normal = np.empty((dim, capacity)), np.empty((dim, capacity))
    weight, foot = np.empty(capacity), np.empty((dim, len(close_target)))
    bu, bv = np.empty((p + 1, capacity)), np.empty((q + 1, capacity))
    starts, gauss = np.empty(len(close_target) + 1, dtype=np.int64), near.gauss_table()
    pieces = quadrature.pieces(panels.lengths[close_panel], closest[2])
    curve = np.empty((p + 1, dim)) if dim == 2 else None
    box, collapsed = (None, None) if dim == 2 else (WHOLE, panels.collapsed_sides)
    u, v, distance = map(np.ascontiguousarray, closest)
    done = 0
    while done < len(close_target):
        count = near.place_nodes(
            panels.flat_nets, box, collapsed, close_panel, done, u, v, distance,
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
        _add_moments(panels, rows, close_panel[done : done + count], moments, accumulator)
        done += count


def _add_moments(
    panels: Panels, rows: Index, panel: Index, moments: Array, accumulator: Accumulator
) -> None:
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
    accumulator.pairs(rows, first_u, first_v, values)
