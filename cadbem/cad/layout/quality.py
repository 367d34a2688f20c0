"""Quality of a patch: angles and ratios of area elements."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from cadbem.points import area_vector
from cadbem.spline.basis import Array
from cadbem.spline.nurbs import Nurbs

SAMPLES = 9  # along each span
COLLAPSED = 1e-6  # length of a tangent, per size of the patch, that is a pole


def worst_angle(surface: Nurbs) -> float:
    """Smallest angle (radians) between parameter lines, on a grid with corners and edges; where an
    edge is a point there is none."""
    area, lengths, size = _elements(surface)
    there = lengths > COLLAPSED * size**2
    sines = area[there] / lengths[there]
    return float(np.arcsin(np.clip(sines.min(), 0.0, 1.0))) if there.any() else 0.0


def least_element(surface: Nurbs) -> float:
    """Smallest ∂x ∂y' - ∂y ∂x' of a plane patch (control points with two coordinates) on the same
    grid, except at poles: negative if it folds."""
    along_u, along_v = _tangents(surface)
    area = along_u[0] * along_v[1] - along_u[1] * along_v[0]
    return float(area[np.abs(area) > COLLAPSED * np.abs(area).max()].min())


def jacobian_ratio(surface: Nurbs) -> float:
    """Smallest over largest area element, on a grid as of `worst_angle`; 0 at a pole."""
    ratios = []
    for piece in surface.bezier_pieces():  # a fast parameter on one span is not a bad shape
        area, _, _ = _elements(piece)
        ratios.append(area.min() / area.max())
    return float(min(ratios))


def _elements(surface: Nurbs) -> tuple[Array, Array, float]:
    """|∂u × ∂v|, |∂u| |∂v| on a grid, and the size of the patch."""
    along_u, along_v = _tangents(surface)
    area = np.linalg.norm(area_vector(along_u, along_v), axis=0)
    lengths = np.linalg.norm(along_u, axis=0) * np.linalg.norm(along_v, axis=0)
    extent = float(np.ptp(surface.points.reshape(-1, 3), axis=0).max())
    scale = np.array([b - a for a, b in surface.domain]).prod()
    return area, lengths, extent / float(np.sqrt(scale))


def _tangents(surface: Nurbs) -> tuple[Array, Array]:
    """∂u and ∂v on a grid of `SAMPLES` points a span, its ends among them."""
    u, v = (
        np.concatenate([np.linspace(a, b, SAMPLES) for a, b in pairwise(surface.breaks(d))])
        for d in (0, 1)
    )
    tangents = surface.derivatives(1, *np.meshgrid(u, v, indexing="ij"))
    return tangents[1, 0], tangents[0, 1]
