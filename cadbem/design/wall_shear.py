"""The wall shear stress and its distribution over the area."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cadbem.checks import within
from cadbem.operators.compressed.layers import CompressedLayers
from cadbem.points import surface_points
from cadbem.problems.conditions import NoSlip
from cadbem.problems.functionals import WALL_SHEAR
from cadbem.problems.mixed import patches_named
from cadbem.problems.solution import StokesSolution
from cadbem.problems.stokes_accuracy import analyse
from cadbem.quadrature.gauss import tensor_rule
from cadbem.spline.basis import Array
from cadbem.spline.nurbs import Nurbs

SAMPLES = 8  # intervals an element and direction in which the peak is looked for


@dataclass(frozen=True, eq=False)
class WallShear:
    """Wall shear stress |f - (f·n) n|: its ``peak``, the ``place`` (dim,) of it, on the faces of
    which ``name`` and on which CAD ``face``; ``values`` (N,) at Gauss points with the area
    ``weights`` (N,).  ``error`` is the estimated error of the peak, nan for compressed matrices.

    At edges that the fluid goes around, such as a junction's corners, the stress of the exact flow
    is infinite: the peak there grows with the grid, whereas percentiles settle.
    """

    peak: float
    place: Array
    name: str
    face: int
    values: Array
    weights: Array
    error: float = float("nan")

    @property
    def mean(self) -> float:
        """Mean over the area."""
        return float(self.values @ self.weights / self.weights.sum())

    def percentile(self, percent: float) -> float:
        """The stress that so many percent of the area stay below."""
        within("percent", percent, 0.0, 100.0)
        order = np.argsort(self.values)
        below = np.cumsum(self.weights[order]) / self.weights.sum()
        place = int(np.searchsorted(below, percent / 100))
        return float(self.values[order[min(place, len(order) - 1)]])


def wall_shear(solution: StokesSolution, *names: str) -> WallShear:
    """The wall shear stress on the faces of some ``names``, by default all with ``NoSlip()``.

    Raises ``SelectionError`` for a name that no face has.
    """
    problem = solution.problem
    walls = names or [n for n, c in problem.conditions.items() if isinstance(c, NoSlip)]
    patches = [i for n in walls for i in patches_named(problem.boundary, n)]
    tops = [_peak(solution, i) for i in patches]
    best = int(np.argmax([value for value, _ in tops]))
    patch = problem.boundary.patches[patches[best]]
    parts = [solution.traction.quadrature(i) for i in patches]
    values = [np.linalg.norm(_along(f, points.normal), axis=0) for f, points, _ in parts]
    weights = np.concatenate([w for _, _, w in parts])
    return WallShear(
        *tops[best], patch.name, patch.face, np.concatenate(values), weights, _error(solution)
    )


def _error(solution: StokesSolution) -> float:
    """Estimated error of the largest shear on walls at rest."""
    if isinstance(solution.problem.layers, CompressedLayers):
        return float("nan")
    fields = solution.velocity, solution.traction
    found = analyse(solution.problem, *fields, solution.background, WALL_SHEAR)
    return found.accuracy.worst.error


def _peak(solution: StokesSolution, patch: int) -> tuple[float, Array]:
    """The largest stress on a patch, and where."""
    surface = solution.space.boundary.patches[patch].surface
    parameters = _samples(surface)
    points = surface_points(surface, *parameters)
    sound: NDArray[np.bool_] = points.jacobian > 1e-9 * points.jacobian.max()  # not at poles
    stress = _along(solution.traction.on_patch(patch, *parameters), points.normal)
    size = np.where(sound, np.linalg.norm(stress, axis=0), 0.0)
    top = int(size.argmax())
    return float(size[top]), points.position[:, top]


def _samples(surface: Nurbs) -> list[Array]:
    """Parameters (N,) of a lattice that has the edges of all elements."""
    lines = []
    for direction in range(len(surface.degrees)):
        breaks = surface.breaks(direction)
        steps = np.arange(SAMPLES * (len(breaks) - 1) + 1) / SAMPLES
        lines.append(np.interp(steps, np.arange(len(breaks)), breaks))
    return tensor_rule([(line, np.ones_like(line)) for line in lines])[0]


def _along(traction: Array, normal: Array) -> Array:
    return traction - (traction * normal).sum(axis=0) * normal
