"""Checks of the thesis's figures 2.1 to 2.5: B-spline and NURBS curves and their refinement."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from cadbem.quadrature.gauss import gauss_on_breaks
from cadbem.spline.nurbs import Nurbs
from cadbem.verification.check import Check

# Eq. 2.6: control points of the square and of what comes close to a circle
SQUARE = np.array([[1, 1, 0, -1, -1, -1, 0, 1, 1], [0, 1, 1, 1, 0, -1, -1, -1, 0.0]]).T
ROUND_WEIGHTS = np.array([1, np.sqrt(0.5)] * 4 + [1])
INSERTED = (0.125, 0.375, 0.625, 0.875)
FINE = np.linspace(0, 1, 2001)
AREA, RADIUS = "Green's theorem", "the quadratic Bézier arc, by hand"


def checks() -> tuple[Check, ...]:
    """Of the curves' areas and radii, and that refinement changes neither."""
    circle = bspline_circle()
    same = "refinement does not move the curve"
    return (
        Check("Figure 2.1", "area of the square", lambda: _area(square()), 4.0, 1e-14, AREA),
        Check("Figure 2.2", "area of the B-spline circle", lambda: _area(circle), 10 / 3,
              1e-14, AREA),
        Check("Figure 2.2", "largest radius of the B-spline circle",
              lambda: _radii(circle).max(), 0.75 * np.sqrt(2), 1e-7, RADIUS),
        Check("Figure 2.3", "distance that inserted knots move the curve",
              _moved(knots_inserted), 0.0, 1e-14, same),
        Check("Figure 2.4", "distance that a raised degree moves the curve",
              _moved(degree_raised), 0.0, 1e-14, same),
        Check("Figure 2.5", "area of the NURBS circle", lambda: _area(nurbs_circle()), np.pi,
              1e-12, AREA),
        Check("Figure 2.5", "largest error of the NURBS circle's radius",
              lambda: abs(_radii(nurbs_circle()) - 1).max(), 0.0, 1e-14, "a unit circle"),
    )  # fmt: skip


def square() -> Nurbs:
    """Degree 1 (Eq. 2.7)."""
    knots = np.concatenate([[0.0], np.linspace(0, 1, 9), [1.0]])
    return Nurbs((1,), (knots,), SQUARE, np.ones(9))


def bspline_circle() -> Nurbs:
    """Degree 2 (Eq. 2.8): four arcs of radius 1 to 1.06."""
    knots = np.repeat([0, 0.25, 0.5, 0.75, 1], [3, 2, 2, 2, 3])
    return Nurbs((2,), (knots,), SQUARE, np.ones(9))


def knots_inserted() -> Nurbs:
    """The same with each span cut in two."""
    return bspline_circle().inserted([INSERTED])


def degree_raised() -> Nurbs:
    """The same with degree 3."""
    return bspline_circle().elevated((3,))


def nurbs_circle() -> Nurbs:
    """The same with weights that make it a circle."""
    curve = bspline_circle()
    return Nurbs((2,), curve.knots, SQUARE, ROUND_WEIGHTS)


def _area(curve: Nurbs) -> float:
    """½ ∮ x dy - y dx, counter-clockwise (Eq. 3.16)."""
    t, weight = gauss_on_breaks(20, curve.breaks(0))
    found = curve.derivatives(1, t)
    (x, y), (dx, dy) = found[(0,)], found[(1,)]
    return float(weight @ (x * dy - y * dx)) / 2


def _radii(curve: Nurbs) -> np.ndarray:
    return np.linalg.norm(curve.evaluate(FINE), axis=0)


def _moved(refined: Callable[[], Nurbs]) -> Callable[[], float]:
    def distance() -> float:
        return float(abs(refined().evaluate(FINE) - bspline_circle().evaluate(FINE)).max())

    return distance
