"""The type of a kernel: a value that fills tables of interactions of targets and sources."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Index = NDArray[np.int64]
Layout = tuple[tuple[int, ...], ...]


@dataclass(frozen=True)
class Sums:
    """Sums of a kernel over many sources at once, added to ``out``: see ``stokes_sums``.

    ``single(targets, position, q, out)`` and ``double(targets, u0, position, a, u, out)``, and
    their variants with sources for each target.  ``free_term`` is positive: with n outwards
    the double layer of a constant is -free_term times it, at smooth points.
    """

    single: Callable[..., None]
    single_near: Callable[..., None]
    double: Callable[..., None]
    double_near: Callable[..., None]
    free_term: float


@dataclass(frozen=True, eq=False)
class Kernel:
    """Single and double layer of one equation in one dimension.

    Per pair of target and source the kernel writes ``entries`` numbers, the distinct ones of
    its two blocks.  ``single[i][j]`` is the entry that maps source component j to target row i
    under the single layer, ``double`` likewise (with the source's normal).

    ``fill(targets, starts, stops, columns, position, normal, table)`` pairs target t of
    (dim, T) with the sources starts[t] ... stops[t] - 1 of ``position`` and ``normal``
    (dim, N), and writes table (entries, ·) from column columns[t] on.

    ``sums``, if there are any, do the same as ``fill`` and a product with densities, faster.
    ``free_term`` is the double layer of a constant density at a smooth point of a
    closed boundary, normals into the domain; inside it is twice that, outside zero.  Kernels of
    derivatives (pressure, gradient) make nothing of a constant.  An ``invariant`` kernel depends
    on differences of positions only, and may be evaluated with shifted ones.

    If ``separable``, the single layer's entries are the first ones, and ``fill`` writes no others
    into a table that has no more.
    """

    name: str
    dimension: int
    entries: int
    single: Layout
    double: Layout
    fill: Callable[..., None]
    free_term: float = 0.0
    invariant: bool = True
    sums: Sums | None = None
    separable: bool = False

    @property
    def rows(self) -> int:
        """Components at a target."""
        return len(self.single)

    @property
    def components(self) -> int:
        """Components of a density."""
        return len(self.single[0])

    @cached_property
    def single_alone(self) -> Kernel:
        """The single layer without the double layer, of separable kernels; others as they are."""
        if not self.separable:
            return self
        return replace(self, entries=1 + max(map(max, self.single)), double=())

    def block(self, targets: Array, position: Array, normal: Array, room: Array) -> Array:
        """Every target (dim, T) with every source (dim, N): table (entries, T, N).

        The table lies in ``room``, a flat array of at least entries T N numbers.
        """
        count, width = targets.shape[1], position.shape[1]
        starts, stops = np.zeros(count, dtype=np.int64), np.full(count, width)
        table = room[: self.entries * count * width].reshape(self.entries, -1)
        self.fill(targets, starts, stops, width * np.arange(count), position, normal, table)
        return table.reshape(self.entries, count, width)

    def rows_of(self, targets: Array, starts: Index, position: Array, normal: Array) -> Array:
        """Target t with the sources starts[t] ... starts[t + 1] - 1: table (entries, starts[T])."""
        table = np.empty((self.entries, starts[-1]))
        low = starts[:-1]
        self.fill(targets, low, starts[1:], low, position, normal, table)
        return table
