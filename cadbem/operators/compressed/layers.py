"""Both layers of a space at its own collocation points, without their matrices."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from cadbem.errors import InputError
from cadbem.kernels.kernel import Array, Kernel
from cadbem.operators.compressed.coarse import two_level
from cadbem.operators.compressed.compress import compress
from cadbem.operators.compressed.cross import MixedKernel
from cadbem.operators.compressed.iterate import Iteration
from cadbem.operators.compressed.storage import Compressed, Storage, storage_for
from cadbem.operators.layers import OwnLayers, collocation_targets
from cadbem.operators.solve import Border
from cadbem.quadrature import Rules
from cadbem.space import Space

SURFACE_ORDER = 4  # Gauss points a direction, for the size of patches


@dataclass(frozen=True, eq=False)
class CompressedLayers(OwnLayers):
    """Layers whose systems are compressed with a ``tolerance``."""

    def system(
        self,
        free_term: float,
        single: Sequence[Array],
        double: Sequence[Array],
        border: Border | None,
    ) -> Iteration:
        """The system q -> S (F q) + (D - free_term) (U q): see ``factorise``."""
        scales = [
            1 / (size * abs(f).max(axis=0) + abs(u).max(axis=0))
            for size, f, u in zip(self._spacings(), single, double, strict=True)
        ]
        mixing = np.array([[f * s, u * s] for f, u, s in zip(single, double, scales, strict=True)])
        matrix = compress(
            MixedKernel(self.kernel, mixing),
            self.space,
            collocation_targets(self.space),
            self.quadrature,
            self.tolerance,
            own=free_term * mixing[:, 1],
        )
        counts = np.diff(self.space.offsets)
        scale = np.repeat(np.array(scales).T, counts, axis=1)
        if border is None:
            fields = np.empty((0, self.kernel.rows, self.count))
            border = Border(np.empty((0, *scale.shape)), fields)
        preconditioner = two_level(matrix, self.space.collocation.position)
        return Iteration(matrix, scale, border, preconditioner, self.tolerance)

    def _spacings(self) -> list[float]:
        """Mean distance of collocation points on each patch."""
        power = 1 / (self.space.boundary.dimension - 1)
        counts = np.diff(self.space.offsets)
        return [
            float((patch.quadrature(SURFACE_ORDER)[1].sum() / n) ** power)
            for patch, n in zip(self.space.boundary.patches, counts, strict=True)
        ]


def own_layers(
    kernel: Kernel, space: Space, quadrature: Rules, storage: Storage | None
) -> OwnLayers:
    """Both layers of a space at its own collocation points; without a ``storage``, in the one that
    suits their number.  Raises ``InputError`` for any other storage."""
    storage = storage_for(space.count) if storage is None else storage
    if not isinstance(storage, Storage):
        raise InputError(f"storage is {storage!r}; give Dense() or Compressed(tolerance)")
    if isinstance(storage, Compressed):
        return CompressedLayers(kernel, space, quadrature, storage.tolerance)
    return OwnLayers(kernel, space, quadrature)
