"""Solving to an accuracy: solve, estimate, refine where it must be, again."""

from __future__ import annotations

import time
import warnings
from collections.abc import Callable
from math import ceil, inf, log10
from typing import TypeVar

import numpy as np

from cadbem.boundary import Boundary
from cadbem.checks import within
from cadbem.elements.initial import first_elements
from cadbem.elements.marking import Evidence, reductions, refined
from cadbem.errors import AccuracyWarning, ConditionError
from cadbem.problems.estimates import Analysis, Estimate
from cadbem.progress import notice
from cadbem.quadrature import Quadrature, Rules
from cadbem.spline.basis import Array

Solution = TypeVar("Solution")

FINEST, COARSEST = 1e-8, 0.3  # accuracies that can be asked for
MOST_POINTS = 4000
UNGRADED = 3e-3  # accuracy from which on elements are graded from the beginning
DEGREES = ((2e-3, 3), (2e-5, 4), (0.0, 5))  # accuracies above which to begin with a degree
BEND = 0.5  # tractions of degree p jump by 1.2 of a strip's bend at a joint over p²
QUADRATURE_SHARE = 1e-2  # of the accuracy: tolerance of integrals
LEFT = 0.35  # of the accuracy, for the elements that are not refined
LEAST_LEFT = 0.03  # of an error: more of it is not removed in one round
GROWTH = 1.1  # of the points in a round, at least


def adapted(
    start: Boundary,
    solve: Callable[[Boundary], tuple[Solution, Analysis]],
    accuracy: float,
    most_points: int,
    pointwise: bool = False,
) -> tuple[Solution, Analysis]:
    """The solution on elements that were refined until all estimates are below ``accuracy``.

    ``pointwise`` where tractions at points count, which need more at smooth joints.  A line a round
    says what was done.  When it would take more than ``most_points`` an ``AccuracyWarning`` says
    so, and the best solution is returned.
    """
    within("accuracy", accuracy, FINEST, COARSEST)
    if not most_points > 0:
        raise ConditionError(f"most_points={most_points}; give a positive number of points")
    degree = _degree(accuracy)
    bend = BEND * degree**2 * accuracy if pointwise else inf
    boundary = first_elements(start, _levels(accuracy), bend).elevated(degree)
    best: tuple[Solution, Analysis] | None = None
    number = 0
    while best is None or _points(boundary) <= most_points:
        number, begin = number + 1, time.process_time()
        solution, analysis = solve(boundary)
        worst = analysis.accuracy.worst
        notice(
            f"round {number}: {analysis.checks.space.count} points, estimated error "
            f"{worst.relative:.1e} ({worst.name}), {time.process_time() - begin:.1f} CPU s"
        )
        if best is None or worst.relative < best[1].accuracy.relative:
            best = solution, analysis
        if worst.relative <= accuracy:
            return solution, analysis
        boundary = _finer(boundary, analysis, accuracy)
    _warn(best[1].accuracy.worst, accuracy, _points(boundary), most_points)
    return best


def _warn(error: Estimate, accuracy: float, wanted: int, allowed: int) -> None:
    """Say that an accuracy is not reached."""
    warnings.warn(
        f"the accuracy {accuracy:g} that was asked for is not reached: the estimated error of "
        f"{error.name} is {error.relative:.1e} of its size, and the next round would take "
        f"{wanted} points; allow more by most_points={2 * allowed}",
        AccuracyWarning,
        stacklevel=5,
    )


def rules_for(rules: Rules, accuracy: float) -> Rules:
    """Integrals as accurate as an accuracy needs, if the user has left the default."""
    if rules != Quadrature():
        return rules
    return Quadrature(min(max(QUADRATURE_SHARE * accuracy, 1e-10), 1e-5))


def _levels(accuracy: float) -> int:
    """Steps of grading towards re-entrant edges with which to begin: one for a digit more."""
    return max(0, ceil(log10(UNGRADED / accuracy)))


def _degree(accuracy: float) -> int:
    """The degree with which to begin."""
    return next(degree for least, degree in DEGREES if accuracy > least)


def _points(boundary: Boundary) -> int:
    return sum(int(np.prod(p.surface.weights.shape)) for p in boundary.patches)


def _finer(boundary: Boundary, analysis: Analysis, accuracy: float) -> Boundary:
    """The boundary with those elements refined that the errors above ``accuracy`` come from."""
    errors = np.array(
        [np.linalg.norm(s, p) for s, p in zip(analysis.shares, analysis.exponents, strict=True)]
    )
    above = errors > accuracy
    # a goal of the user's own has no shares: errors that are known stand in for it
    wanted = np.where(above, np.maximum(LEFT * accuracy, LEAST_LEFT * errors), np.inf)
    allowed = wanted if above.any() else LEFT * errors
    before = _points(boundary)
    while True:
        factors = reductions(analysis.shares, analysis.exponents, allowed)
        patches = []
        for i, patch in enumerate(boundary.patches):
            if i in factors:
                patches += refined(patch, _evidence(analysis, i), max(factors[i], 2.0))
            else:
                patches.append(patch)
        finer = Boundary(tuple(patches), boundary.source, boundary.unit)
        if _points(finer) >= GROWTH * before or len(factors) == len(boundary.patches):
            return finer
        allowed = 0.6 * allowed


def _evidence(analysis: Analysis, patch: int) -> Evidence:
    """What the solution and its adjoints say of one element."""
    space, checks = analysis.checks.space, analysis.checks
    surface = space.boundary.patches[patch].surface
    shape = surface.weights.shape
    matrix, part = space.collocation_matrix(patch), space.functions(patch)
    values = [_on_grid(matrix @ f[:, part].T, shape) for f in analysis.fields]
    here = checks.patch == patch
    low = np.array([ends[0] for ends in surface.domain])[:, None]
    high = np.array([ends[1] for ends in surface.domain])[:, None]
    places = (checks.parameters[:, here] - low) / (high - low)
    spots = analysis.spots[:, here] * checks.weights[here]
    spots /= np.maximum(spots.sum(axis=1, keepdims=True), 1e-300)
    return Evidence(values, places, analysis.shares[:, patch] @ spots)


def _on_grid(values: Array, shape: tuple[int, ...]) -> Array:
    return values.T.reshape(-1, *shape)

