"""Velocities that many bodies induce at many points, with far pairs at low cost.

Targets are gathered in clusters, such as the collocation points of a body, or those of a part of a
wall.  A body and a cluster whose balls are some radii apart interact through equivalent sources:
the body's few Stokeslets act at the cluster's few inner points, and the velocity that arrives there
from all such bodies is translated to the cluster's own points at once.  Nearer pairs are divided
point by point.  At the nearest points the body's layers themselves must be integrated.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from cadbem.kernels.kernel import Index
from cadbem.operators.far.equivalent import Ball, Expansion, Sources, ball_around, point_sources
from cadbem.operators.parallel import in_shares
from cadbem.spline.basis import Array

CLUSTER = 128  # points of a cluster, at most
NEAR, OWN = -1, -2

Flags = NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class TargetCluster:
    """Some targets: their ``numbers`` among all, and the ``owner``, a body, or -1."""

    numbers: Index
    owner: int = -1


def target_clusters(points: Array, first: int = 0) -> list[TargetCluster]:
    """Points (dim, M), numbered from ``first`` on, parted into neighbours."""
    parts, done = [np.arange(points.shape[1])], []
    while parts:
        part = parts.pop()
        if len(part) > CLUSTER:
            here = points[:, part]
            order = np.argsort(here[np.ptp(here, axis=1).argmax()], kind="stable")
            parts += np.array_split(part[order], 2)
        elif len(part):
            done.append(TargetCluster(first + part))
    return done


@dataclass(frozen=True, eq=False)
class FarInteractions:
    """Interactions of bodies in ``balls`` with ``clusters`` of ``points`` (dim, M), by
    ``expansions`` from the finest to the coarsest; without any, all pairs are near."""

    expansions: Sequence[Expansion]
    balls: Sequence[Ball]
    points: Array
    clusters: Sequence[TargetCluster]

    def near(self, body: int) -> Index:
        """Numbers of the points at which a body's layers themselves must be integrated."""
        return self._parts[body][0]

    def apply(self, bodies: Iterable[int], sources: Callable[[int], Sources]) -> Array:
        """The velocity of ``bodies`` (their numbers) far away, ∫ G q dS + ∫ u·T·n dS (dim, M), zero
        at points near them; ``sources`` gives the nodes of each."""
        out = np.zeros(self.points.shape)
        present = np.zeros(len(self.balls), dtype=bool)
        present[list(bodies)] = True
        present &= self._expanded
        if not present.any():
            return out
        equivalent = self._equivalent_sources(sources, present)
        received = in_shares(lambda j: self._received(j, equivalent), range(len(self.clusters)))
        for cluster, part in zip(self.clusters, received, strict=True):
            out[:, cluster.numbers] = part
        parted = [i for i in np.nonzero(present)[0].tolist() if len(self._parts[i][1])]
        parts = in_shares(lambda i: self._at(self._parts[i][1], equivalent.of(0, [i])), parted)
        for i, part in zip(parted, parts, strict=True):
            out[:, self._parts[i][1]] += part
        return out

    def _equivalent_sources(
        self, sources: Callable[[int], Sources], present: Flags
    ) -> _EquivalentSources:
        """Equivalent sources of each body that is present and has distant targets."""

        def strengths(i: int) -> tuple[list[Array], float]:
            body = sources(i)
            finest, *others = self.expansions
            first = finest.equivalent(body.in_units_of(self.balls[i]))
            return [first, *(e.lowered(finest, first) for e in others)], body.flux

        numbers = np.nonzero(present)[0].tolist()
        fluxes = np.zeros(len(present))
        strength_arrays = [np.zeros_like(p) for p in self._places]
        for i, (parts, flux) in zip(numbers, in_shares(strengths, numbers), strict=True):
            fluxes[i] = flux
            for all_bodies, part in zip(strength_arrays, parts, strict=True):
                all_bodies[:, i] = part
        centres = np.stack([ball.centre for ball in self.balls], axis=1)
        return _EquivalentSources(present, self._places, strength_arrays, centres, fluxes)

    def _received(self, number: int, equivalent: _EquivalentSources) -> Array:
        """Velocity (dim, M) at a cluster's points of all bodies that are far from it as a whole."""
        cluster, ball, levels = self.clusters[number], self._around[number], self._levels[:, number]
        total = np.zeros((len(self.points), len(cluster.numbers)))
        for k, expansion in enumerate(self.expansions):
            which = np.nonzero((levels == k) & equivalent.present)[0]
            if not len(which):
                continue
            arriving, count = equivalent.of(k, which), total.shape[1]
            few, many = expansion.inner.shape[1], expansion.outer.shape[1]
            if len(which) * few * few + many * count > len(which) * few * count:
                total += self._at(cluster.numbers, arriving)
                continue
            incident = _sum(ball.world(expansion.inner), arriving)
            local = Sources(expansion.outer, expansion.incoming(incident))
            total += _sum(ball.unit(self.points[:, cluster.numbers]), [local])
        return total

    def _at(self, numbers: Index, sources: list[Sources]) -> Array:
        return _sum(self.points[:, numbers], sources)

    @cached_property
    def _around(self) -> list[Ball]:
        return [ball_around(self.points[:, cluster.numbers]) for cluster in self.clusters]

    @cached_property
    def _places(self) -> list[Array]:
        """Places (dim, bodies, E) of all bodies' Stokeslets, by each expansion."""
        return [np.stack([b.world(e.inner) for b in self.balls], axis=1) for e in self.expansions]

    @cached_property
    def _levels(self) -> Index:
        """The expansion that serves a body and a cluster as a whole (bodies, clusters), or
        ``NEAR``, or ``OWN`` if the cluster belongs to that body."""
        levels = np.full((len(self.balls), len(self.clusters)), NEAR)
        owners = np.array([cluster.owner for cluster in self.clusters], dtype=np.int64)
        if not len(self.clusters):
            return levels
        centres = np.array([ball.centre for ball in self._around])
        radii = np.array([max(ball.radius, 1e-300) for ball in self._around])
        for i, ball in enumerate(self.balls):
            apart = np.linalg.norm(centres - ball.centre, axis=1)
            share = np.minimum((apart - radii) / ball.radius, (apart - ball.radius) / radii)
            for number, expansion in enumerate(self.expansions):
                levels[i, share >= expansion.reach] = number
            levels[i, owners == i] = OWN
        return levels

    @cached_property
    def _parts(self) -> list[tuple[Index, Index]]:
        """Points near each body, and those beyond its finest reach in clusters that are not."""
        return [self._part(i) for i in range(len(self.balls))]

    def _part(self, body: int) -> tuple[Index, Index]:
        close = self._numbers(np.nonzero(self._levels[body] == NEAR)[0])
        if not self.expansions:
            return close, close[:0]
        away = np.linalg.norm(self.balls[body].unit(self.points[:, close]), axis=0)
        far = away >= self.expansions[0].reach
        rest = self._numbers(np.nonzero(self._levels[body] >= 0)[0])
        if len(rest) + far.sum() <= self.expansions[0].outer.shape[1]:
            return np.concatenate([close, rest]), close[:0]
        return close[~far], close[far]

    def _numbers(self, clusters: Index) -> Index:
        none = np.zeros(0, dtype=np.int64)
        return np.concatenate([none, *(self.clusters[j].numbers for j in clusters)])

    @cached_property
    def _expanded(self) -> Flags:
        """Bodies that have so many points far away that equivalent sources pay."""
        distant = np.array([(w != OWN) @ self._counts for w in self._levels], dtype=np.int64)
        return distant > np.array([len(near) for near, _ in self._parts])

    @cached_property
    def _counts(self) -> Index:
        return np.array([len(cluster.numbers) for cluster in self.clusters], dtype=np.int64)


@dataclass(frozen=True, eq=False)
class _EquivalentSources:
    """Equivalent Stokeslets of all bodies, (dim, bodies, E) by each expansion, and point sources at
    their centres (dim, bodies); zero for those that are not ``present`` (bodies,)."""

    present: Flags
    places: list[Array]
    strengths: list[Array]
    centres: Array
    fluxes: Array

    def of(self, expansion: int, bodies: Sequence[int] | Index) -> list[Sources]:
        """The sources of some of the bodies."""
        dim = len(self.centres)
        pair = (a[expansion][:, bodies].reshape(dim, -1) for a in (self.places, self.strengths))
        found = [Sources(*pair)]
        if self.fluxes[bodies].any():
            found.append(point_sources(self.centres[:, bodies], self.fluxes[bodies]))
        return found


def _sum(targets: Array, sources: list[Sources]) -> Array:
    total = np.zeros(targets.shape)
    for part in sources:
        part.add_to(targets, total)
    return total
