"""What a kernel is: a value that fills tables of pair interactions."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

Layout = tuple[tuple[int, ...], ...]
Fill = Callable[..., None]


@dataclass(frozen=True, eq=False)
class Kernel:
    """Single and double layer of one equation in one dimension.

    Per pair of target and source the kernel writes ``entries`` numbers, the distinct ones of
    its two blocks.  ``single[i][j]`` is the entry that maps source component j to target row i
    under the single layer, ``double`` likewise (with the source's normal).

    ``fill_block(targets, positions, normals, table)`` pairs every target (dim, T) with every
    source (dim, N) into table (entries, T, N).  ``fill_rows(targets, starts, positions,
    normals, table)`` pairs target k with the sources starts[k] ... starts[k + 1] - 1 into
    table (entries, N).
    """

    name: str
    dimension: int
    entries: int
    single: Layout
    double: Layout
    fill_block: Fill
    fill_rows: Fill

    @property
    def rows(self) -> int:
        """Components at a target."""
        return len(self.single)

    @property
    def components(self) -> int:
        """Components of a density."""
        return len(self.single[0])


