"""Velocity and pressure inside the channel, on a mesh of tetrahedra."""

from __future__ import annotations

from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from cadbem.post.fields.sampling import in_portions
from cadbem.post.style.display import load_pyvista
from cadbem.quadrature import Quadrature
from cadbem.spline.basis import Array

SEEN = Quadrature(1e-5)  # finer than any picture shows


class Flow(Protocol):
    """A flow that can be evaluated at points (3, M) inside and on its boundary."""

    def velocity_at(self, points: Array, quadrature: Quadrature) -> Array: ...

    def pressure_at(self, points: Array, quadrature: Quadrature) -> Array: ...


def volume_grid(points: Array, tetrahedra: NDArray[np.int64], solution: Flow) -> Any:
    """A ``pyvista.UnstructuredGrid`` with point data ``velocity`` (N, 3) and ``pressure`` (N,).

    ``points`` (3, N) in the boundary's unit of length, ``tetrahedra`` (4, M) indices into them,
    as ``mesh_volume`` returns them.
    """
    pyvista = load_pyvista()
    grid = pyvista.UnstructuredGrid({pyvista.CellType.TETRA: tetrahedra.T}, points.T.copy())
    grid.point_data["velocity"] = in_portions(solution.velocity_at, points, SEEN, "velocity").T
    grid.point_data["pressure"] = in_portions(solution.pressure_at, points, SEEN, "pressure")
    return grid
