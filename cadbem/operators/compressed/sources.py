"""Nodes of all panels of a boundary in flat arrays, in any order of the panels."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cadbem.kernels.kernel import Array, Index
from cadbem.operators.panels import Panels, tensor_nodes
from cadbem.space import Space


@dataclass(frozen=True, eq=False)
class PanelList:
    """The E panels of a space: their ``patch`` (E,) and ``number`` (E,) within it; ``panels`` one
    entry a patch."""

    space: Space
    panels: tuple[Panels, ...]
    patch: Index
    number: Index

    @classmethod
    def of(cls, space: Space, panels: tuple[Panels, ...]) -> PanelList:
        """All panels, patch by patch."""
        counts = [len(p.flat_nets) for p in panels]
        patch = np.repeat(np.arange(len(panels)), counts)
        return cls(space, panels, patch, np.concatenate([np.arange(n) for n in counts]))

    def ordered(self, order: Index) -> PanelList:
        """The same in another order."""
        return PanelList(self.space, self.panels, self.patch[order], self.number[order])

    def gathered(self, parts: list[Array]) -> Array:
        """From one array (..., E_i) a patch, all panels' values (..., E)."""
        starts = np.cumsum([0] + [p.shape[-1] for p in parts[:-1]])
        return np.concatenate(parts, axis=-1)[..., starts[self.patch] + self.number]

    def balls(self) -> tuple[Array, Array]:
        """Centres (dim, E) and radii (E,) of balls that hold the panels."""
        centres, radii = zip(*[p.sphere for p in self.panels], strict=True)
        return self.gathered(list(centres)), self.gathered(list(radii))

    def lengths(self) -> Array:
        """The longer side of each panel: (E,)."""
        return self.gathered([p.lengths for p in self.panels])

    def functions(self) -> tuple[Index, Index]:
        """Numbers of the functions on each panel, one panel after the other, and where each panel's
        begin: (E + 1,)."""
        tables = [_functions(p, s) for p, s in zip(self.panels, self.space.offsets, strict=False)]
        return _flat([tables[p][e] for p, e in zip(self.patch, self.number, strict=True)])


@dataclass(frozen=True, eq=False)
class Sources:
    """Nodes of one tensor rule on a list of panels.

    ``position`` and ``normal`` (dim, M) with panel e's nodes from ``first``[e] (E + 1,) on;
    ``basis`` its weighted functions (functions, nodes), flat from ``basis_first``[e] on.
    """

    position: Array
    normal: Array
    first: Index
    basis: Array
    basis_first: Index

    def part(self, panels: slice) -> Sources:
        """The nodes of consecutive panels."""
        first = self.first[panels.start : panels.stop + 1]
        basis_first = self.basis_first[panels.start : panels.stop + 1]
        return Sources(
            np.ascontiguousarray(self.position[:, first[0] : first[-1]]),
            np.ascontiguousarray(self.normal[:, first[0] : first[-1]]),
            first - first[0],
            self.basis[basis_first[0] : basis_first[-1]],
            basis_first - basis_first[0],
        )


def sources(panels: PanelList, orders: tuple[int, ...]) -> Sources:
    """Nodes of the rule with ``orders[i]`` on the panels of patch i."""
    nodes = [tensor_nodes(p, order) for p, order in zip(panels.panels, orders, strict=True)]
    tables = [
        n.weighted(p, np.arange(len(p.flat_nets))).swapaxes(1, 2)
        for p, n in zip(panels.panels, nodes, strict=True)
    ]
    pairs = list(zip(panels.patch, panels.number, strict=True))
    dim = panels.space.boundary.dimension
    position = [n.position.reshape(dim, len(t), -1) for n, t in zip(nodes, tables, strict=True)]
    normal = [n.normal.reshape(dim, len(t), -1) for n, t in zip(nodes, tables, strict=True)]
    counts = np.array([p.shape[2] for p in position], dtype=np.int64)
    basis, basis_first = _flat([tables[p][e].ravel() for p, e in pairs])
    return Sources(
        np.concatenate([position[p][:, e] for p, e in pairs], axis=1),
        np.concatenate([normal[p][:, e] for p, e in pairs], axis=1),
        np.concatenate([[0], np.cumsum(counts[panels.patch])]),
        basis,
        basis_first,
    )


def _functions(panels: Panels, offset: int) -> Index:
    """Numbers (E, functions) of the functions on each panel of a patch."""
    p, q = panels.surface.degrees
    columns = panels.surface.weights.shape[1]
    rows = panels.first[0][:, None] + np.arange(p + 1)
    across = panels.first[1][:, None] + np.arange(q + 1)
    table = rows[:, None, :, None] * columns + across[None, :, None, :]
    return offset + table.reshape(len(rows) * len(across), -1)


def _flat(parts: list) -> tuple:
    """Arrays one after the other, and where each begins."""
    return np.concatenate(parts), np.concatenate([[0], np.cumsum([len(p) for p in parts])])
