"""What makes panels of splines: curves as surfaces, and cuts where elements turn too far."""

from __future__ import annotations

import numpy as np

from cadbem.spline.basis import Array
from cadbem.spline.nurbs import Nurbs

WIDEST_TURN = np.deg2rad(50.0)  # a rational arc wider than this asks for higher orders


def ruled(curve: Nurbs) -> Nurbs:
    """A curve as a patch of degree 0 across."""
    knots = (*curve.knots, np.array([0.0, 1.0]))
    return Nurbs((*curve.degrees, 0), knots, curve.points[:, None], curve.weights[:, None])


def panel_breaks(surface: Nurbs, direction: int) -> Array:
    """Where a surface is cut into panels: at its knots, and between them where it turns too far."""
    breaks = surface.breaks(direction)
    turns = _turns(surface, direction)
    pieces = np.maximum(1, np.ceil(turns / WIDEST_TURN)).astype(int)
    inner = [
        np.linspace(low, high, n + 1)[1:]
        for low, high, n in zip(breaks[:-1], breaks[1:], pieces, strict=True)
    ]
    return np.concatenate([breaks[:1], *inner])


def _turns(surface: Nurbs, direction: int) -> Array:
    """Largest angle by which the tangent turns along each element of a direction."""
    breaks = surface.breaks(direction)
    across = np.linspace(*surface.domain[1 - direction], 5)
    # just inside each element: the tangent may jump at its ends
    along = breaks[:-1, None] + np.diff(breaks)[:, None] * np.linspace(1e-9, 1 - 1e-9, 9)
    grid = np.meshgrid(along.ravel(), across, indexing="ij")
    parameters = grid if direction == 0 else grid[::-1]
    key = (1, 0) if direction == 0 else (0, 1)
    tangent = surface.derivatives(1, *parameters)[key].reshape(-1, *along.shape, 5)
    length = np.linalg.norm(tangent, axis=0)
    unit = tangent / np.where(length > 1e-12 * length.max(), length, np.inf)
    cosine = np.clip((unit[:, :, 1:] * unit[:, :, :-1]).sum(axis=0), -1, 1)
    cosine = np.where((length[:, 1:] > 0) & (length[:, :-1] > 0), cosine, 1.0)
    return np.arccos(cosine).sum(axis=1).max(axis=1)
