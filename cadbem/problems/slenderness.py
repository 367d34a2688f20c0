"""Elements that are much longer than wide, on which integrals and splines lose their digits."""

from __future__ import annotations

import warnings

import numpy as np

from cadbem.boundary import Boundary
from cadbem.errors import AccuracyWarning
from cadbem.spline.basis import Array
from cadbem.spline.nurbs import Nurbs

SLENDER = 200.0  # from which a duct's pressure is wrong by more than 0.1%


def warn_if_slender(boundary: Boundary) -> None:
    """An ``AccuracyWarning`` where an element is more than 200 times as long as wide.

    For problems whose errors are not estimated; those whose errors are say more."""
    if boundary.dimension == 2:
        return
    ratios = [slenderness(patch.surface) for patch in boundary.patches]
    worst = int(np.argmax(ratios))
    if ratios[worst] > SLENDER:
        warnings.warn(
            f"an element of {boundary.label(worst)} is {ratios[worst]:.0f} times as long as wide, "
            "and the flow along it may be far off: make elements shorter by boundary.refined("
            "size=...)",
            AccuracyWarning,
            stacklevel=4,
        )


def slenderness(surface: Nurbs) -> float:
    """The largest ratio of length and width of a surface's elements, along their middle lines."""
    first, second = _lengths(surface, 0), _lengths(surface, 1).T
    return float((np.maximum(first, second) / np.minimum(first, second)).max())


def _lengths(surface: Nurbs, direction: int) -> Array:
    """Lengths (along, across) of elements in a direction, in two chords."""
    along, across = surface.breaks(direction), surface.breaks(1 - direction)
    ends = np.sort(np.concatenate([along, (along[1:] + along[:-1]) / 2]))
    middles = (across[1:] + across[:-1]) / 2
    grid = [g.ravel() for g in np.meshgrid(ends, middles, indexing="ij")]
    points = surface.evaluate(*(grid if direction == 0 else grid[::-1]))
    points = points.reshape(-1, len(ends), len(middles))
    chords = np.linalg.norm(np.diff(points, axis=1), axis=0)
    return chords[::2] + chords[1::2]
