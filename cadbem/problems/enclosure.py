"""The search for points in the fluid, and for their distance from the boundary."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cadbem.boundary import Boundary
from cadbem.operators.nearest import NearestSearch
from cadbem.operators.panels import Index
from cadbem.problems.bodies import closed_surfaces
from cadbem.spline.basis import Array


@dataclass(frozen=True, eq=False)
class Clearance:
    """Room between M points and the boundary.

    ``distance`` (M,) to the nearest point of the boundary, negative outside the fluid, inf beyond
    reach; ``patch`` (M,) the number of its patch, -1 beyond reach; ``normal`` (dim, M) there, into
    the fluid, 0 beyond reach.  An open surface has fluid on both sides, and the normal points to
    the side that the point is on.
    """

    distance: Array
    patch: Index
    normal: Array


@dataclass(frozen=True, eq=False)
class Enclosure:
    """Asks where points are in the fluid of a ``boundary``; made once, it is quick."""

    boundary: Boundary

    @cached_property
    def _search(self) -> NearestSearch:
        return NearestSearch(self.boundary)

    @cached_property
    def two_sided(self) -> NDArray[np.bool_]:
        """Which patches belong to open surfaces; the last, of no patch, does not."""
        two_sided = np.zeros(len(self.boundary.patches) + 1, dtype=bool)
        for surface in closed_surfaces(self.boundary):
            two_sided[list(surface.patches)] = surface.volume == 0.0
        return two_sided

    def clearance(self, points: ArrayLike, reach: float = np.inf) -> Clearance:
        """Signed distances of points (dim, M) to the boundary, of those within ``reach`` of it."""
        near = self._search.find(np.asarray(points, dtype=float), reach)
        behind = ~near.before & (near.patch >= 0)
        two_sided = self.two_sided[near.patch]
        distance = np.where(behind & ~two_sided, -near.distance, near.distance)
        normal = np.where(behind & two_sided, -near.normal, near.normal)
        return Clearance(distance, near.patch, normal)

    def inside(self, points: ArrayLike) -> NDArray[np.bool_]:
        """Whether points (dim, M) lie in the fluid, not on its boundary: (M,)."""
        return self.clearance(points).distance > 0


def inside(boundary: Boundary, points: ArrayLike) -> NDArray[np.bool_]:
    """Whether points (dim, M) lie in the fluid that a boundary holds, or is around: (M,)."""
    return Enclosure(boundary).inside(points)
