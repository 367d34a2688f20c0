"""Elements of walls and of rigid bodies, small where another surface is near.

In the film between two surfaces at a distance d, one of which has the radius R, the flow varies
over lengths like √(d R), and far from it over d.  Elements are no longer than a multiple of
√(d (R + d)).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.spatial import cKDTree

from cadbem.elements.pieces import Elements, Sizes, pieces_near
from cadbem.spline.basis import Array
from cadbem.suspension.bodies.body import Placed
from cadbem.suspension.bodies.particle import PlacedParticle, RigidParticle
from cadbem.suspension.surroundings.channel_flow import ChannelFlow
from cadbem.suspension.surroundings.surroundings import Surroundings

AHEAD = (0.0, 0.25, 0.5)  # sizes that a body may go before the elements of walls are chosen anew
CLOSING = 0.6  # share of a gap that such a way leaves
SLACK = 1.25  # times the length that an element may have at which it is cut
THIN = 0.05  # radii, below which a film is thin: its pressure is steep
NEIGHBOURS = 6  # samples among which a surface's curvature is measured
THINNEST = 1e-3  # sizes of a body below which a distance counts no more
WATCHED = 3.0  # sizes of a body within which walls count


@dataclass(frozen=True, eq=False)
class Cloud:
    """Samples of a body's surface: ``points`` and ``normals`` (dim, M), and its ``size``."""

    points: Array
    normals: Array
    size: float

    @classmethod
    def of(cls, placed: Placed, size: float) -> Cloud:
        """Of a body where it is."""
        return cls(placed.samples, placed.sample_normals, size)

    @cached_property
    def _tree(self) -> cKDTree:
        return cKDTree(self.points.T)

    @cached_property
    def _around(self) -> tuple[Array, Array]:
        """Distances (M, k) of each sample's neighbours, and their numbers."""
        distance, other = self._tree.query(self.points.T, NEIGHBOURS + 1)
        return distance[:, 1:], other[:, 1:]

    @cached_property
    def radii(self) -> Array:
        """The smallest radius of curvature (M,) at each sample, at most the body's size."""
        distance, other = self._around
        turn = np.linalg.norm(self.normals[:, :, None] - self.normals[:, other], axis=0)
        curvature = (turn / np.maximum(distance, 1e-300)).max(axis=1)
        return np.minimum(1 / np.maximum(curvature, 1e-300), self.size)

    @property
    def least(self) -> float:
        """The distance below which distances count no more."""
        return THINNEST * self.size

    def distance_to(self, points: Array) -> Array:
        """Distances (N,) of points (dim, N)."""
        return self.distance(points)[0]

    def distance(self, points: Array) -> tuple[Array, Array]:
        """Distances (N,) of points (dim, N), and radii (N,) of curvature where it is nearest."""
        away, which = self._tree.query(points.T)
        arm = points - self.points[:, which]
        ahead = abs((arm * self.normals[:, which]).sum(axis=0))
        beside = np.sqrt(np.maximum(away**2 - ahead**2, 0.0))
        # beside a sample the surface is nearly its tangent plane
        off = np.maximum(beside - self._around[0][which, -1], 0.0)
        distance = np.maximum(np.hypot(ahead, off), self.least)
        return distance, self.radii[which]


@dataclass(frozen=True)
class AdaptiveElements:
    """Elements of walls and rigid bodies no longer than ``share`` times √(d (R + d)), and of at
    least the ``degree`` where they are about as long as that."""

    share: float
    degree: int

    @classmethod
    def for_accuracy(cls, accuracy: float) -> AdaptiveElements:
        """Those that make forces on bodies and their velocities about as accurate."""
        return cls(3.0, 4 if accuracy >= 1e-3 else 5)

    def flow(
        self, flow: Surroundings, clouds: Sequence[Cloud], velocities: Sequence[Array]
    ) -> Surroundings:
        """The flow on elements that suit bodies with velocities (dim,): the same one if its own
        do.  They suit the bodies some way ahead, too."""
        if not isinstance(flow, ChannelFlow):
            return flow
        still = [np.zeros((1, len(v))) for v in velocities]
        sizes = self._beside(clouds, still)
        if self._suit(flow.elements, sizes):
            return flow
        pairs = zip(clouds, velocities, strict=True)
        ways = [_ways(cloud, velocity, flow.drawn) for cloud, velocity in pairs]
        pieces = pieces_near(flow.drawn, self._beside(clouds, ways), self.degree)
        return flow if pieces.same_as(flow.pieces) else flow.with_pieces(pieces)

    def particle(
        self, number: int, placed: PlacedParticle, flow: Surroundings, clouds: Sequence[Cloud]
    ) -> RigidParticle:
        """One of several bodies on elements that suit what is near it: the same one if its own
        do."""
        body, own = placed.body, clouds[number]
        others = [c for c in clouds if c is not own]
        still = [np.zeros((1, body.dimension))] * len(others)
        beside = self._beside(others, still)

        def sizes(points: Array) -> Array:
            world = placed.world(points)
            walls = flow.nearest(world, WATCHED * own.size).distance
            lengths = self._length(np.maximum(walls, own.least), own.distance(world)[1])
            return np.minimum(lengths, beside(world))

        if self._suit(body.resistance.elements, sizes):
            return body
        pieces = pieces_near(body.drawn.elements, sizes, self.degree)
        return body if pieces.same_as(body.pieces) else body.with_pieces(pieces)

    def _suit(self, elements: Elements, sizes: Sizes) -> bool:
        """Whether elements are short enough."""
        return bool(elements.shares(sizes).max() <= SLACK)

    def _length(self, distance: Array, radius: Array) -> Array:
        thin = np.minimum(distance / (THIN * radius), 1.0) ** 0.25
        return self.share * thin * np.sqrt(distance * (radius + distance))

    def _beside(self, clouds: Sequence[Cloud], shifts: Sequence[Array]) -> Sizes:
        """Lengths of elements beside bodies, each shifted by several ``shifts`` (k, dim)."""

        def sizes(points: Array) -> Array:
            result = np.full(points.shape[1], np.inf)
            for cloud, ways in zip(clouds, shifts, strict=True):
                for shift in ways:
                    distance, radius = cloud.distance(points - shift[:, None])
                    np.minimum(result, self._length(distance, radius), out=result)
            return result

        return sizes


def _ways(cloud: Cloud, velocity: Array, elements: Elements) -> Array:
    """Shifts (k, dim) of a body ahead that leave most of its gap."""
    points = elements.points
    speed = float(np.linalg.norm(velocity))
    shifts = np.outer(AHEAD, velocity) * (cloud.size / max(speed, 1e-300))
    gaps = [float(cloud.distance(points - shift[:, None])[0].min()) for shift in shifts]
    return shifts[[gap >= CLOSING * gaps[0] for gap in gaps]]
