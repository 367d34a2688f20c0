"""The search for points on the boundary, and for their parameters."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from cadbem.boundary import Boundary
from cadbem.operators.panels import split_patch
from cadbem.spline.basis import Array
from cadbem.spline.nurbs import Nurbs

ON_BOUNDARY = 1e-9  # distance over panel length below which a point counts as on the panel


def locate(boundary: Boundary, position: Array) -> tuple[NDArray[np.int64], Array]:
    """Patch (M,) on which each point (dim, M) lies, or -1, and its parameters (dim - 1, M)."""
    owner = np.full(position.shape[1], -1)
    parameters = np.zeros((len(position) - 1, position.shape[1]))
    for index, patch in enumerate(boundary.patches):
        on, place = touching(patch.surface, position, ON_BOUNDARY)
        parameters[:, on] = place
        owner[on] = index
    return owner, parameters


def touching(surface: Nurbs, position: Array, share: float) -> tuple[NDArray[np.int64], Array]:
    """Numbers (K,) of the points (dim, M) that lie on a patch, and their parameters (dim - 1, K).

    Within a ``share`` of a panel's length a point counts as on it.
    """
    panels = split_patch(surface)
    target, panel = panels.close_pairs(position, share * panels.lengths)
    closest = panels.closest(position, target, panel)
    on = closest[2] < share * panels.lengths[panel]
    cells = np.divmod(panel[on], panels.shape[1])
    parameters = np.zeros((len(position) - 1, int(on.sum())))
    for direction, cell in enumerate(cells[: len(parameters)]):
        breaks = panels.breaks[direction]
        step = breaks[cell + 1] - breaks[cell]
        parameters[direction] = breaks[cell] + closest[direction, on] * step
    return target[on], parameters
