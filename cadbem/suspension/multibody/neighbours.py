"""Neighbours: gaps between many bodies."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.spatial import cKDTree

from cadbem.operators.far.equivalent import Ball, ball_around
from cadbem.spline.basis import Array
from cadbem.suspension.bodies.body import Placed


@dataclass(frozen=True, eq=False)
class Neighbours:
    """Bodies, and what finds those near each other quickly.

    The samples of a body lie so close together that no point of its surface is farther than its
    spacing from one; this says which few points come into question for the narrowest gap.
    """

    bodies: Sequence[Placed]

    @cached_property
    def _balls(self) -> list[Ball]:
        """Balls that hold the bodies' surfaces."""
        balls = [ball_around(body.samples) for body in self.bodies]
        pairs = zip(balls, self.bodies, strict=True)
        return [Ball(ball.centre, ball.radius + body.spacing) for ball, body in pairs]

    @cached_property
    def _trees(self) -> list[cKDTree]:
        return [cKDTree(body.samples.T) for body in self.bodies]

    @cached_property
    def _apart(self) -> Array:
        """Distances between the bodies' balls, negative if they overlap."""
        centres = np.array([ball.centre for ball in self._balls])
        radii = np.array([ball.radius for ball in self._balls])
        ways = np.linalg.norm(centres[:, None] - centres, axis=2)
        return ways - radii - radii[:, None]

    def nearest(self, number: int, reach: float) -> tuple[float, int]:
        """The narrowest gap of a body to another, and which; inf beyond reach."""
        best, which = float("inf"), -1
        for other in np.argsort(self._apart[number]).tolist():
            if self._apart[number, other] > min(best, reach):
                break
            if other != number and (length := self.between(number, other, reach)) < best:
                best, which = length, other
        return best, which

    def between(self, number: int, other: int, reach: float) -> float:
        """Narrowest gap from a body's samples to another, negative if they overlap, inf beyond
        reach."""
        points, tree, body = self.bodies[number].samples, self._trees[other], self.bodies[other]
        low = self._from_ball(points, other)
        if low.min() > reach:
            return float("inf")
        bound = tree.query(points[:, low.argmin()])[0]
        points = points[:, low <= min(bound, reach)]
        away = tree.query(points.T)[0]
        return float(body.distance(points[:, away <= away.min() + body.spacing]).min())

    def gaps(self, number: int, points: Array, reach: float) -> Array:
        """Distances (M,) of points (dim, M) of one body from the others, inf beyond reach."""
        gaps = np.full(points.shape[1], np.inf)
        for other in np.nonzero(self._apart[number] < reach)[0].tolist():
            near = self._from_ball(points, other) < reach
            if other != number and near.any():
                distance = self.bodies[other].distance(points[:, near])
                gaps[near] = np.minimum(gaps[near], distance)
        return gaps

    def _from_ball(self, points: Array, body: int) -> Array:
        """Distances (M,) of points (dim, M) from a body, at least."""
        ball = self._balls[body]
        return np.linalg.norm(points - ball.centre[:, None], axis=0) - ball.radius
