"""The choice of the storage of matrices: dense or compressed."""

from __future__ import annotations

from dataclasses import dataclass

from cadbem.checks import within

DENSE_TO = 4000  # collocation points from which a compressed matrix is smaller and faster


@dataclass(frozen=True)
class Dense:
    """All entries, factorised once: best for many right sides and few points.

    Memory and time grow with the second and the third power of the points.
    """


@dataclass(frozen=True)
class Compressed:
    """Blocks of low rank far away, solved by iteration: memory grows hardly faster than the points.

    ``tolerance`` of each block, and of the residual relative to the right side.  From 1e-7 on
    blocks far away are kept in 32 bits.  Raises ``ValueError`` unless 1e-12 <= tolerance <= 1e-2.
    """

    tolerance: float = 1e-6

    def __post_init__(self) -> None:
        within("Compressed's tolerance", self.tolerance, 1e-12, 1e-2)


Storage = Dense | Compressed


def storage_for(count: int) -> Storage:
    """The default storage for this number of collocation points."""
    return Dense() if count <= DENSE_TO else Compressed()
