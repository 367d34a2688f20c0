"""The number and layout of an interface's points, chosen anew as its shape changes."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from cadbem.checks import whole, within
from cadbem.spline.basis import Array
from cadbem.spline.closed import ClosedBasis, ClosedSpline
from cadbem.spline.closed_layout import laid_out, longest_axis, relaid
from cadbem.suspension.interface.resolution import Resolution, shape_uncertainty

NEAR = 3.0  # gaps: a surface beside a gap is as accurate as one of this many gaps' size
AIM = 0.3  # of the length that is allowed, for a new layout
SPARE = 0.02  # of the length that is allowed, below which points are taken away
MOST_CHANGE = 1.5  # of the number of points in a direction at once
ENOUGH = 1.05  # times as many points are more points
TOLERATED = 10.0  # times the length that is allowed, when there cannot be more points
WORST = 1e3  # times the error of the shape, that an error of the motion counts at most
WORTH = 0.8  # of the points that the poles as they are would take: then they are moved
MOST_DEGREE = 10
FEWEST = {2: (16,), 3: (8, 12)}  # points in each direction, by dimension


@dataclass(frozen=True)
class AdaptivePoints:
    """Points are added, taken away and laid out anew, so that a droplet's surface is as accurate as
    a share ``accuracy`` of its size, and of the gap beside it, asks for.

    ``most`` is the largest number of points, ``degree`` the least degree of splines that are laid
    out anew.  Raises InputError for an accuracy that is not between 1e-8 and 0.1.
    """

    accuracy: float = 1e-3
    most: int = 2000
    degree: int = 6

    def __post_init__(self) -> None:
        within("AdaptivePoints' accuracy", self.accuracy, 1e-8, 0.1)
        whole("AdaptivePoints' most", self.most)
        whole("AdaptivePoints' degree", self.degree, 2, MOST_DEGREE)

    def allowed(self, size: float, gap: float) -> float:
        """By how much a surface of a ``size`` and with a ``gap`` may be wrong: a length."""
        return self.accuracy * min(size, NEAR * max(gap, 0.0) + self.accuracy * size)

    def adapted(
        self, spline: ClosedSpline, found: Resolution, allowed: float, fewest: int, travel: Array
    ) -> ClosedSpline:
        """The same shape with the points that it needs; the same spline if it has them.

        They are enough when ``found`` is below an ``allowed`` length, or when there are as many as
        there may be.  Where they are more than enough, at least ``fewest`` remain.  The poles go to
        the ends of the longest axis, or to those along the ``travel`` (dim,), a velocity, if fewer
        points do then.
        """
        aim = AIM * allowed
        if found.uncertainty > allowed:
            return self._finer(spline, found, aim, travel)
        basis = self._with_counts(spline.basis, found.lengths / aim, fewest)
        if found.uncertainty > SPARE * allowed or basis.count >= spline.basis.count / ENOUGH:
            return spline
        return relaid(spline, basis)

    def reason(self, found: Resolution, allowed: float, count: int) -> str:
        """Why a run cannot go on with so many points and no more, or an empty text."""
        if found.uncertainty <= TOLERATED * allowed:
            return ""
        return (
            f"its surface is uncertain by {found.uncertainty:.3g} where the accuracy asks for "
            f"{allowed:.3g}, and it has {count} points: allow more, AdaptivePoints(most=...), or a "
            "larger accuracy"
        )

    def finer(self, spline: ClosedSpline) -> ClosedSpline:
        """The same shape with more points in each direction, or the same spline if there are as
        many as there may be."""
        everywhere = np.full(len(spline.basis.shape), np.inf)
        basis = self._with_counts(spline.basis, everywhere, spline.basis.count)
        return relaid(spline, basis) if basis.count > ENOUGH * spline.basis.count else spline

    def _finer(
        self, spline: ClosedSpline, found: Resolution, aim: float, travel: Array
    ) -> ClosedSpline:
        """The layout that carries the shape with the fewest points, with as many as that takes."""
        old = spline.basis
        same = replace(old, degree=max(old.degree, self.degree))
        layouts = [relaid(spline, same)]
        if spline.dimension == 3:
            layouts += [laid_out(spline, same, axis) for axis in (longest_axis(spline), travel)]
        worse = min(found.uncertainty / max(float(found.shape.max()), 1e-300), WORST)
        needs = [worse / aim * shape_uncertainty(layout) for layout in layouts]
        counts = [self._needed(same, need).prod() for need in needs]
        best = int(np.argmin(counts)) if min(counts) < WORTH * counts[0] else 0
        basis = self._with_counts(old, needs[best], old.count)
        if best == 0 and basis.count <= ENOUGH * old.count:
            return spline
        return relaid(layouts[best], basis)

    def _needed(self, basis: ClosedBasis, ratios: Array) -> Array:
        """Points in each direction (p,) that make the error smaller by a ratio (p,)."""
        factors = ratios ** (1 / (basis.degree + 1))
        return np.maximum(factors * basis.shape, FEWEST[basis.dimension])

    def _with_counts(self, basis: ClosedBasis, ratios: Array, fewest: int) -> ClosedBasis:
        """The basis with about that many, as far as limits allow it."""
        degree = max(basis.degree, self.degree)
        shape = np.array(basis.shape)
        wanted = self._needed(replace(basis, degree=degree), ratios)
        wanted = np.clip(wanted, shape / MOST_CHANGE, shape * MOST_CHANGE)
        limits = np.array([min(fewest, self.most), self.most]) / wanted.prod()
        wanted = wanted * np.clip(1.0, *limits) ** (1 / len(shape))
        counts = [max(int(n + 0.5), degree + 2) for n in wanted]
        if len(counts) == 2:
            counts[1] += counts[1] % 2
        return ClosedBasis(degree, tuple(counts))
