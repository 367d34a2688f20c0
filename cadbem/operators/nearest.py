"""Nearest points of a boundary to points in space, found among samples first."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from math import sqrt

import numpy as np
from numpy.typing import NDArray

from cadbem.boundary import Boundary
from cadbem.compiled import compiled
from cadbem.operators.panels import Index, Panels, split_patch
from cadbem.quadrature.panels import (
    area_vector,
    closest_on_panels,
    evaluate_panel,
    fill_bernstein,
    open_squares,
)
from cadbem.spline.basis import Array

SAME_DISTANCE = 1e-9  # share by which distances of points that are equally near may differ
ROUNDING = 1e-13  # share of the boundary's size by which they may also differ
OFF_POLE = 1e-6  # how near to a panel's edges its normal is asked for: some edges are points


@dataclass(frozen=True, eq=False)
class NearestPoints:
    """For M points: the nearest point of the boundary, and on which side of it they are.

    ``patch`` (M,) the number of its patch, -1 beyond reach; ``distance`` (M,), inf beyond reach;
    ``normal`` (dim, M) of the patch there, 0 beyond reach; ``before`` (M,) whether the point lies
    where the normal points to.
    """

    patch: Index
    distance: Array
    normal: Array
    before: NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class _Family:
    """Panels of equal degrees: their numbers among all panels (E,), and their ``nets``."""

    numbers: Index
    nets: Array

    @cached_property
    def squares(self) -> Array:
        """The panels' ``open_squares``."""
        return open_squares(self.nets)


@dataclass(frozen=True, eq=False)
class NearestSearch:
    """Search for nearest points on a ``boundary``; it is built once and used often.

    No point of a panel is farther from its nearest sample than the panel's ``cover``, so that only
    panels with a sample not much farther than the nearest one come into question.
    """

    boundary: Boundary

    @cached_property
    def _panels(self) -> list[Panels]:
        return [split_patch(p.surface) for p in self.boundary.patches]

    @cached_property
    def _owner(self) -> Index:
        """The patch of each panel: (E,)."""
        return np.repeat(np.arange(len(self._panels)), [len(p.flat_nets) for p in self._panels])

    @cached_property
    def _samples(self) -> Array:
        """Positions (E, S, dim) on all panels."""
        return np.concatenate([p.samples[2] for p in self._panels])

    @cached_property
    def _cover(self) -> Array:
        """Half the sides of the widest cell of each panel's grid of samples: (E,)."""
        side = round(self._samples.shape[1] ** (1 / (self.boundary.dimension - 1)))
        axes = range(1, self.boundary.dimension)
        grid = self._samples.reshape(len(self._samples), *[side] * len(axes), -1)
        steps = [np.linalg.norm(np.diff(grid, axis=a), axis=-1) for a in axes]
        return 0.5 * np.sum([s.reshape(len(s), -1).max(axis=1) for s in steps], axis=0)

    @cached_property
    def _balls(self) -> tuple[Array, Array]:
        """Centres (dim, E) and radii (E,) of balls that hold the panels."""
        centres, radii = zip(*[p.sphere for p in self._panels], strict=True)
        return np.concatenate(centres, axis=1), np.concatenate(radii)

    @cached_property
    def _families(self) -> list[_Family]:
        shapes = np.array([p.flat_nets.shape[1:3] for p in self._panels])[self._owner]
        first = np.concatenate([np.arange(len(p.flat_nets)) for p in self._panels])
        families = []
        for shape in np.unique(shapes, axis=0):
            numbers = np.nonzero((shapes == shape).all(axis=1))[0]
            nets = [self._panels[self._owner[e]].flat_nets[first[e]] for e in numbers]
            families.append(_Family(numbers, np.ascontiguousarray(nets)))
        return families

    def find(self, points: Array, reach: float = np.inf) -> NearestPoints:
        """The nearest points to points (dim, M), for those within ``reach`` of the boundary.

        Of several nearest points, as at an edge, the one is taken whose normal points most
        directly to the point or away from it: its side is the point's side of the boundary.
        """
        points = np.ascontiguousarray(points, dtype=float)
        target, panel = self._candidates(points, reach)
        found, normal, before = self._closest(points, target, panel)
        best = np.full(points.shape[1], np.inf)
        np.minimum.at(best, target, found)
        size = float(np.linalg.norm(np.ptp(self.boundary.bounds(), axis=0)))
        level = best * (1 + SAME_DISTANCE) + ROUNDING * size
        tied = np.nonzero((found <= level[target]) & (found <= reach))[0]
        tied = tied[np.argsort(abs(before[tied]), kind="stable")]  # the last one stays
        result = NearestPoints(
            np.full(points.shape[1], -1),
            np.full(points.shape[1], np.inf),
            np.zeros_like(points),
            np.zeros(points.shape[1], dtype=bool),
        )
        at = target[tied]
        result.patch[at] = self._owner[panel[tied]]
        result.distance[at] = found[tied]
        result.normal[:, at] = normal[:, tied]
        result.before[at] = before[tied] > 0
        return result

    def _candidates(self, points: Array, reach: float) -> tuple[Index, Index]:
        """Pairs of points and panels among which the nearest ones are."""
        room = 16 * points.shape[1]
        while True:
            pairs = np.empty((2, room), dtype=np.int64)
            count = _near_pairs(points, *self._balls, self._samples, self._cover, reach, pairs)
            if count <= room:
                return pairs[0, :count], pairs[1, :count]
            room = count

    def _closest(self, points: Array, target: Index, panel: Index) -> tuple[Array, Array, Array]:
        """Distances (pairs,), normals (dim, pairs), and cosines between these and the way."""
        distance, cosine = np.empty(len(target)), np.empty(len(target))
        normal = np.empty((len(points), len(target)))
        u, v, _ = self._panels[0].samples
        for family in self._families:
            here = np.nonzero(np.isin(panel, family.numbers))[0]
            local = np.searchsorted(family.numbers, panel[here])
            found = np.empty((3, len(here)))
            samples = self._samples[family.numbers]
            closest_on_panels(
                points, target[here], local, family.nets, family.squares, u, v, samples, found
            )
            sides = np.empty((len(points) + 1, len(here)))
            _sides_of_closest(points, target[here], local, family.nets, found, sides)
            distance[here], normal[:, here], cosine[here] = found[2], sides[:-1], sides[-1]
        return distance, normal, cosine


@compiled
def _near_pairs(targets, centres, radii, samples, cover, reach, pairs):
    """Fill ``pairs`` (2, room) with targets and panels that may be nearest; returns how many.

    The distance of a panel's nearest sample is at most ``cover`` more than the panel's own.
    """
    dim, panels = centres.shape
    low, gap = np.empty(panels), np.empty(panels)
    count = 0
    for t in range(targets.shape[1]):
        bound = np.inf
        for e in range(panels):
            square = 0.0
            for c in range(dim):
                square += (targets[c, t] - centres[c, e]) ** 2
            low[e] = sqrt(square) - radii[e]
            bound = min(bound, low[e] + 2.0 * radii[e])
        nearest = np.inf
        for e in range(panels):
            gap[e] = np.inf
            if low[e] > min(bound, reach):
                continue
            for s in range(samples.shape[1]):
                square = 0.0
                for c in range(dim):
                    square += (targets[c, t] - samples[e, s, c]) ** 2
                gap[e] = min(gap[e], square)
            gap[e] = sqrt(gap[e])
            nearest = min(nearest, gap[e])
            bound = min(bound, nearest)
        for e in range(panels):
            if gap[e] <= min(nearest, reach) + (1.0 + 1e-9) * cover[e]:
                if count < pairs.shape[1]:
                    pairs[0, count], pairs[1, count] = t, e
                count += 1
    return count


@compiled
def _sides_of_closest(targets, target_of, panel_of, nets, found, sides):
    """Normals, and the cosine between them and the way to the target, at closest points.

    ``found`` (3, pairs) as of ``closest_on_panels``; ``sides`` (dim + 1, pairs).
    """
    p, q, dim = nets.shape[1] - 1, nets.shape[2] - 1, targets.shape[0]
    bu, du = np.empty(p + 1), np.empty(p + 1)
    bv, dv = np.empty(q + 1), np.empty(q + 1)
    point, tu, tv, unit = np.empty(dim), np.empty(dim), np.empty(dim), np.empty(dim)
    foot = np.empty(dim)
    for k in range(len(target_of)):
        net = nets[panel_of[k]]
        u, v = found[0, k], found[1, k]
        fill_bernstein(p, u, bu, du)
        fill_bernstein(q, v, bv, dv)
        evaluate_panel(net, bu, bv, du, dv, foot, tu, tv)
        fill_bernstein(p, min(max(u, OFF_POLE), 1.0 - OFF_POLE), bu, du)
        fill_bernstein(q, min(max(v, OFF_POLE), 1.0 - OFF_POLE), bv, dv)
        evaluate_panel(net, bu, bv, du, dv, point, tu, tv)
        area_vector(tu, tv, unit)
        along = 0.0
        for c in range(dim):
            along += unit[c] * (targets[c, target_of[k]] - foot[c])
            sides[c, k] = unit[c]
        sides[dim, k] = along / found[2, k] if found[2, k] > 0.0 else 0.0
