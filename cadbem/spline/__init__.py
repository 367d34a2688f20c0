"""B-splines and NURBS: bases, curves, surfaces, refinement."""

from cadbem.spline.basis import greville, open_knots
from cadbem.spline.nurbs import Nurbs

__all__ = ["Nurbs", "greville", "open_knots"]
