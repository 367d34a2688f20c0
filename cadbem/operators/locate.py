"""Which points lie on the boundary, and where."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from cadbem.boundary import Boundary
from cadbem.operators.panels import split_patch
from cadbem.quadrature.panels import closest_on_panels
from cadbem.spline.basis import Array

ON_BOUNDARY = 1e-9  # distance over panel length below which a point counts as on the panel


def locate(boundary: Boundary, position: Array) -> tuple[NDArray[np.int64], Array]:
    """Patch (M,) on which each point (dim, M) lies, or -1, and its parameters (dim - 1, M)."""
    owner = np.full(position.shape[1], -1)
    parameters = np.zeros((len(position) - 1, position.shape[1]))
    for index, patch in enumerate(boundary.patches):
        panels = split_patch(patch.surface)
        centres, radii = panels.sphere
        square = ((position[:, :, None] - centres[:, None, :]) ** 2).sum(axis=0)
        target, panel = np.nonzero(square < (radii + ON_BOUNDARY * panels.lengths) ** 2)
        closest = np.empty((3, len(target)))
        u, v, samples = panels.samples
        closest_on_panels(position, target, panel, panels.flat_nets, u, v, samples, closest)
        on = closest[2] < ON_BOUNDARY * panels.lengths[panel]
        cells = np.divmod(panel[on], panels.shape[1])
        for direction, cell in enumerate(cells[: len(parameters)]):
            breaks = panels.breaks[direction]
            step = breaks[cell + 1] - breaks[cell]
            parameters[direction, target[on]] = breaks[cell] + closest[direction, on] * step
        owner[target[on]] = index
    return owner, parameters
