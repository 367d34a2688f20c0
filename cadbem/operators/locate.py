"""The search for points on the boundary, and for their parameters."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from cadbem.boundary import Boundary
from cadbem.operators.panels import split_patch
from cadbem.spline.basis import Array

ON_BOUNDARY = 1e-9  # distance over panel length below which a point counts as on the panel


def locate(boundary: Boundary, position: Array) -> tuple[NDArray[np.int64], Array]:
    """Patch (M,) on which each point (dim, M) lies, or -1, and its parameters (dim - 1, M)."""
    owner = np.full(position.shape[1], -1)
    parameters = np.zeros((len(position) - 1, position.shape[1]))
    for index, patch in enumerate(boundary.patches):
        panels = split_patch(patch.surface)
        target, panel = panels.close_pairs(position, ON_BOUNDARY * panels.lengths)
        closest = panels.closest(position, target, panel)
        on = closest[2] < ON_BOUNDARY * panels.lengths[panel]
        cells = np.divmod(panel[on], panels.shape[1])
        for direction, cell in enumerate(cells[: len(parameters)]):
            breaks = panels.breaks[direction]
            step = breaks[cell + 1] - breaks[cell]
            parameters[direction, target[on]] = breaks[cell] + closest[direction, on] * step
        owner[target[on]] = index
    return owner, parameters
