"""The distances from which on tensor rules are accurate enough for panels of any shape."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from cadbem.operators.panels import Panels, tensor_nodes
from cadbem.quadrature import Rules
from cadbem.spline.basis import Array

SHARE = 0.1  # of the tolerance that a panel's own shape may use up


@lru_cache(maxsize=1024)
def reaches(panels: Panels, orders: tuple[int, ...], rules: Rules) -> Array:
    """Distance (orders, E) from which each of the ascending ``orders`` resolves each panel.

    Infinite where the rule does not even integrate what varies on the panel itself - functions,
    area, normals, places - as the last one does: far away nothing else is left of the integrals.
    """
    degree = max(panels.surface.degrees)
    distance = np.outer([rules.reach(order, degree) for order in orders], panels.lengths)
    exact = _moments(panels, orders[-1])
    size = exact[:, 0].sum(axis=1)  # the functions sum to one: areas
    for order, row in zip(orders[:-1], distance, strict=False):
        error = abs(_moments(panels, order) - exact).max(axis=(1, 2))
        row[error > SHARE * rules.tolerance * size] = np.inf
    distance.setflags(write=False)
    return distance


def _moments(panels: Panels, order: int) -> Array:
    """Integrals of functions times 1, normals, and places within a panel: (E, 2 dim + 1, i j)."""
    nodes, dim = tensor_nodes(panels, order), len(panels.sphere[0])
    count = len(panels.flat_nets)
    normal, place = (x.reshape(dim, count, -1) for x in (nodes.normal, nodes.position))
    place = (place - panels.sphere[0][:, :, None]) / panels.lengths[:, None]
    factors = np.concatenate([np.ones((1, *place.shape[1:])), normal, place])
    weighted = (factors * nodes.weight.reshape(count, -1)).reshape(
        len(factors), *panels.shape, *(f.shape[1] for f in nodes.functions)
    )
    along = np.einsum("cabkl,aki,blj->abcij", weighted, *nodes.functions, optimize=True)
    moments = along * panels.controls[:, :, None]
    return moments.reshape(count, len(factors), -1)
