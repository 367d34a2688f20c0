"""Whether the channel behind an opening is straight, which its conditions take for granted.

A developed profile, or a pressure without tangential velocity, is what the flow in a straight duct
fulfils.  Where walls meet the opening at another angle than 90 degrees, or turn within half a
width, the flow is another one: a round pipe two radii long that is cut at 30 degrees lets 1.05
times as much through.
"""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from math import asin, degrees

import numpy as np

from cadbem.boundary import Boundary
from cadbem.errors import AccuracyWarning
from cadbem.points import surface_points
from cadbem.problems.profiles import Port
from cadbem.spline.basis import Array

TILTED = 2.0  # degrees from which it is worth a word
DEPTH = 0.5  # widths behind an opening that are looked at
SAMPLES = 9  # a direction of each patch


def warn_if_not_straight(
    boundary: Boundary, ports: Sequence[Port], walls: Sequence[int]
) -> None:
    """An ``AccuracyWarning`` for each opening whose ``walls`` (patches) are not straight."""
    for port in ports:
        angle = tilt(boundary, port, walls)
        if angle > TILTED:
            warnings.warn(
                f"the walls behind the opening '{port.name}' lean by up to {angle:.0f} degrees "
                "against its axis within half a width, where its condition takes a straight duct "
                f"for granted; make the channel longer: cb.extended(channel, '{port.name}', "
                f"{2 * _width(port):.3g})",
                AccuracyWarning,
                stacklevel=4,
            )


def tilt(boundary: Boundary, port: Port, walls: Sequence[int]) -> float:
    """The largest angle (degrees) between walls within half a width and an opening's axis."""
    width, radius = _width(port), _radius(port)
    worst = 0.0
    for i in walls:
        surface = boundary.patches[i].surface
        axes = [np.linspace(*ends, SAMPLES) for ends in surface.domain]
        grid = [g.ravel() for g in np.meshgrid(*axes, indexing="ij")]
        points = surface_points(surface, *grid)
        away = points.position - port.centre[:, None]
        depth = port.normal @ away
        beside = np.linalg.norm(away - depth * port.normal[:, None], axis=0)
        near = (abs(depth) < DEPTH * width) & (beside < radius + abs(depth))
        if near.any():
            worst = max(worst, float(abs(port.normal @ points.normal[:, near]).max()))
    return degrees(asin(min(worst, 1.0)))


def _width(port: Port) -> float:
    """The narrow width: of a circle the diameter, of a rectangle the shorter side."""
    if len(port.centre) == 2:
        return port.area
    return port.area / (2 * _radius(port)) * (4 / np.pi)


def _radius(port: Port) -> float:
    reach: Array = np.linalg.norm(port.outline - port.centre[:, None], axis=0)
    return float(reach.max()) * (1 + 1e-6)
