"""The developed profile of a flat opening of any shape, by boundary elements on its rim.

Along a straight channel μ ∇²u = dp/dx across the opening, and u = 0 on its rim.  With
u = φ - |x|²/4 that is Laplace's equation for φ with φ = |x|²/4 on the rim, up to scale.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from cadbem.boundary import Boundary, Patch
from cadbem.problems.heat import HeatProblem
from cadbem.problems.heat_conditions import Temperature
from cadbem.spline.basis import Array
from cadbem.spline.nurbs import Nurbs

DEGREE, SPANS, LEVELS, RATIO = 8, 2, 10, 0.6  # of the rim: fine at its corners
ORDER = 24  # Gauss points an element and direction, for the mean
SAME = 1e-7  # distance over size below which edges are the same


def developed_profile(
    patches: Sequence[Patch], centre: Array, normal: Array
) -> Callable[[Array], Array]:
    """Velocity over mean velocity at points (3, N) of the opening that flat patches make.

    ``centre`` (3,) lies in its plane, ``normal`` is the patches' unit normal.
    """
    first = np.linalg.svd(normal[None])[2][1]
    frame = np.stack([first, np.cross(normal, first)])
    outline = rim([_flattened(p.surface, frame, centre) for p in patches])
    boundary = Boundary(tuple(Patch(curve, "rim") for curve in outline)).elevated(DEGREE)
    boundary = boundary.refined(SPANS).graded(LEVELS, RATIO)
    on_rim = Temperature(lambda x: (x**2).sum(axis=0) / 4)
    solution = HeatProblem(boundary, 1.0, {"rim": on_rim}).solve()

    def velocity(points: Array) -> Array:
        flat = frame @ (points - centre[:, None])
        return solution.temperature_at(flat) - (flat**2).sum(axis=0) / 4

    parts = [p.quadrature(ORDER) for p in patches]
    weights = np.concatenate([w for _, w in parts])
    values = velocity(np.concatenate([p.position for p, _ in parts], axis=1))
    mean = float(values @ weights / weights.sum())
    return lambda points: velocity(points) / mean


def rim(surfaces: Sequence[Nurbs]) -> list[Nurbs]:
    """Outer edges of surfaces in the plane, each with the surface to its right; poles are none."""
    edges = [edge for surface in surfaces for edge in surface.edges()]
    size = float(np.ptp(np.concatenate([edge.points for edge in edges]), axis=0).max())
    edges = [edge for edge in edges if np.ptp(edge.points, axis=0).max() > SAME * size]
    marks = np.array([_mark(e) for e in edges])
    gaps = np.abs(marks[:, None] - marks[None]).max(axis=(2, 3))
    np.fill_diagonal(gaps, np.inf)
    unpaired = gaps.min(axis=1) > SAME * size
    return [edge for edge, alone in zip(edges, unpaired, strict=True) if alone]


def _mark(edge: Nurbs) -> Array:
    """Sum of both ends and the middle: the same for both directions of an edge."""
    low, high = edge.domain[0]
    x = edge.evaluate([low, 0.5 * (low + high), high]).T
    return np.array([0.5 * (x[0] + x[2]), x[1]])


def _flattened(surface: Nurbs, frame: Array, centre: Array) -> Nurbs:
    return surface.transformed(frame, -frame @ centre)
