"""A sphere over a plate that stands for a wall."""

from __future__ import annotations

from dataclasses import replace
from math import pi

import numpy as np

from cadbem.boundary import Boundary, Patch
from cadbem.spline.shapes import plate, sphere


def near_wall(
    height: float, elements: int, *, rings: int = 15, across: int = 6, side: float = 100.0
) -> Boundary:
    """A unit sphere at a height over a plate, with elements for the pressure in the gap.

    The gap is height - 1 + r² / 2, so elements grow like √(w² + r²) with w² = 2 (height - 1):
    there are ``elements`` a side on the face that looks down, knots at w sinh t.  The plate has its
    elements right below: where they are wider than the gap, only pairs that face each other tell
    the traction of one surface from that of the other.
    """
    width, half = np.sqrt(2 * (height - 1)), pi / 4  # half the angle that the face takes
    places = np.linspace(-1, 1, elements + 1) * np.arcsinh(half / width)
    knots = 0.5 + 0.5 * width / half * np.sinh(places)
    ball = [Patch(surface, "body") for surface in sphere(centre=(0, 0, height))]
    lowest = min(range(6), key=lambda k: ball[k].middle().normal[2, 0])
    line = ball[lowest].surface.evaluate(knots, 0.5)
    below = np.sort(line[np.argmax(np.ptp(line, axis=1))])
    inner = [knots[1:-1] if k == lowest else [0.5] for k in range(6)]
    patches = [
        replace(patch, surface=patch.surface.inserted([new, new]))
        for patch, new in zip(ball, inner, strict=True)
    ]
    middle = 2 * below[-1]
    under, edge = below[1:-1] / middle + 0.5, np.linspace(0, 1, across + 1)[1:-1]
    square, *around = plate(middle, side, degree=4, spans=1, rings=rings)
    wall = [square.inserted([under, under]), *(s.inserted([[], edge]) for s in around)]
    return Boundary((*patches, *(Patch(surface, "wall") for surface in wall)))
