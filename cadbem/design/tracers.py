"""Passive tracers: dx/dt = u(x) in a steady flow, until they leave through an opening.

All tracers step together, each with its own step (order 5 of Dormand and Prince): the velocity at
many points at once costs far less than one by one.  Openings continue the flow that they have
straight outwards, so that a step may end beyond one; the moment of crossing is found on the cubic
that fits both ends of the step.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cadbem.checks import positive, shaped, within
from cadbem.design.overview import tracers_overview
from cadbem.design.release_points import OPEN, ReleasePoints
from cadbem.errors import ConditionError
from cadbem.operators.compressed.layers import CompressedLayers
from cadbem.problems.enclosure import Enclosure
from cadbem.problems.profiles import Port, port
from cadbem.problems.solution import StokesSolution
from cadbem.progress import progress
from cadbem.quadrature import Quadrature
from cadbem.spline.basis import Array
from cadbem.suspension.time.stepping import dormand_prince
from cadbem.units import check

STRIDE = 0.5  # longest step, in widths of the narrowest opening
PATIENCE = 200.0  # default time limit, in mean residence times V / Q
STEPS = 5000  # a tracer that takes more does not get on
STUCK = 1e-7  # widths: a step that has to be shorter, or ends in a wall, does not get on
PARTS = (0.25, 0.5, 0.75, 1.0)  # of each step that are kept
BISECTIONS = 50
ACCURACY = 1e-4  # of the velocity, relative


@dataclass(frozen=True, eq=False)
class Tracers:
    """N tracers that have been followed: their ``paths``, arrays (dim, n), at the ``moments`` (n,).

    ``openings`` (N names) through which they left, "" for those that did not; ``ended`` (N texts)
    says why each is followed no further.  Near walls, where the fluid is almost at rest, the
    computed flow may lead into a wall.  ``flow_rates`` (N,) are those that each represents.
    ``velocity_error`` is the estimated error of the velocity in the mean square, over its size; nan
    for compressed matrices.
    """

    paths: tuple[Array, ...]
    moments: tuple[Array, ...]
    openings: tuple[str, ...]
    ended: tuple[str, ...]
    flow_rates: Array
    velocity_error: float = float("nan")

    def __repr__(self) -> str:
        return tracers_overview(self).text()

    def _repr_html_(self) -> str:
        return tracers_overview(self).html()

    @property
    def times(self) -> Array:
        """Residence times (N,); for a tracer that is still inside how long it was followed."""
        return np.array([m[-1] for m in self.moments])

    @property
    def left(self) -> NDArray[np.bool_]:
        """Which tracers (N,) have left."""
        return np.array([bool(name) for name in self.openings])

    @property
    def mean_time(self) -> float:
        """Mean residence time of those that left, weighted by flow: V / Q if all did, from Gauss
        points of all inlets."""
        rates = self.flow_rates[self.left]
        return float(self.times[self.left] @ rates / rates.sum())

    @property
    def shares(self) -> dict[str, float]:
        """The share of the flow that left through each opening, "" for what is still inside."""
        whole = self.flow_rates.sum()
        names = dict.fromkeys(self.openings)
        chosen = {n: np.array([o == n for o in self.openings]) for n in names}
        return {n: float(self.flow_rates[c].sum() / whole) for n, c in chosen.items()}

    @property
    def distribution(self) -> tuple[Array, Array]:
        """Residence times in order (M,) and the share of the flow (M,) that left up to each."""
        times, rates = self.times[self.left], self.flow_rates[self.left]
        order = np.argsort(times)
        return times[order], np.cumsum(rates[order]) / self.flow_rates.sum()


def trace(
    solution: StokesSolution,
    release_points: ReleasePoints | ArrayLike,
    time_limit: float | None = None,
    tolerance: float = 1e-4,
) -> Tracers:
    """Follow tracers from ``release_points``, those of an inlet or an array (dim, N), until they
    leave.

    ``time_limit``, by default 200 V / Q with the volume V and the flow rate Q, ends those that do
    not.  ``tolerance`` bounds the error of each step relative to the narrowest opening's width.
    Raises ``ConditionError`` when there is no opening, for release points outside the fluid or of
    another dimension; ``UnitsError`` for a limit that is no time.
    """
    check("time_limit", time_limit, "time")
    if time_limit is not None:
        positive("time_limit", time_limit)
    within("tolerance", tolerance, 1e-12, 0.1)
    dimension = solution.space.boundary.dimension
    if not isinstance(release_points, ReleasePoints):
        points = shaped("release_points", release_points, dimension, None)
        release_points = ReleasePoints(points, np.ones(points.shape[-1]))
    flow = _Flow(solution)
    points = shaped("release_points", release_points.points, dimension, None)
    outside = flow.in_walls(points, np.inf)
    if outside.any():
        place = ", ".join(f"{x:.4g}" for x in points[:, int(outside.argmax())])
        raise ConditionError(f"a tracer starts at ({place}), outside the fluid; move it inside")
    march = _March(flow, flow.turnover * PATIENCE if time_limit is None else time_limit, tolerance)
    march.follow(points)
    compressed = isinstance(solution.problem.layers, CompressedLayers)
    return Tracers(
        tuple(np.array(p).T for p in march.paths), tuple(map(np.array, march.moments)),
        tuple(march.openings), tuple(march.ended), release_points.flow_rates,
        np.nan if compressed else solution.accuracy.of("velocity in the mean square").relative,
    )  # fmt: skip


@dataclass(frozen=True, eq=False)
class _Flow:
    """The velocity of a solution, continued straight through its openings."""

    solution: StokesSolution

    @cached_property
    def ports(self) -> list[Port]:
        problem = self.solution.problem
        names = [n for n, c in problem.conditions.items() if isinstance(c, OPEN)]
        if not names:
            raise ConditionError(
                "tracers cannot leave: no name has an Inflow, Pressure or Traction"
            )
        return [port(n, [p for p in problem.boundary.patches if p.name == n]) for n in names]

    @property
    def width(self) -> float:
        """Of the narrowest opening."""
        return min(p.area ** (1 / (len(p.centre) - 1)) for p in self.ports)

    @property
    def turnover(self) -> float:
        """V / Q."""
        entering = sum(max(self.solution.flow_rate(p.name), 0.0) for p in self.ports)
        if not entering:
            raise ConditionError("nothing flows in through openings; give trace a time_limit")
        return self.solution.space.boundary.volume() / entering

    def behind(self, points: Array, opening: Port) -> NDArray[np.bool_]:
        """Which points (dim, M) lie behind an opening, as far as its size."""
        arm = points - opening.centre[:, None]
        height = opening.normal @ arm
        aside = np.linalg.norm(arm - opening.normal[:, None] * height, axis=0)
        radius = np.linalg.norm(opening.outline - opening.centre[:, None], axis=0).max()
        return (height < 0) & (height > -2 * radius) & (aside <= radius)

    @cached_property
    def _enclosure(self) -> Enclosure:
        return Enclosure(self.solution.space.boundary)

    def in_walls(self, points: Array, reach: float) -> NDArray[np.bool_]:
        """Which points (dim, M) within reach lie neither in the fluid nor behind an opening."""
        outside = self._enclosure.clearance(points, reach).distance < -STUCK * self.width
        for opening in self.ports:
            outside &= ~self.behind(points, opening)
        return outside

    def __call__(self, points: Array) -> Array:
        """Velocity (dim, M)."""
        inside = points.copy()
        for opening in self.ports:
            height = opening.normal @ (points - opening.centre[:, None])
            inside -= opening.normal[:, None] * np.where(self.behind(points, opening), height, 0.0)
        return self.solution.velocity_at(inside, Quadrature(ACCURACY))


@dataclass(frozen=True, eq=False)
class _Steps:
    """Tracers ``who`` (M,) on their way: times, positions, velocities and the next steps."""

    who: NDArray[np.int64]
    time: Array
    position: Array
    velocity: Array
    length: Array

    def only(self, kept: NDArray[np.bool_]) -> _Steps:
        return _Steps(
            self.who[kept], self.time[kept], self.position[:, kept], self.velocity[:, kept],
            self.length[kept],
        )  # fmt: skip


@dataclass(eq=False)
class _March:
    """Follows tracers, and writes down where they came along."""

    flow: _Flow
    limit: float
    tolerance: float
    paths: list[list[Array]] = field(default_factory=list)
    moments: list[list[float]] = field(default_factory=list)
    openings: list[str] = field(default_factory=list)
    ended: list[str] = field(default_factory=list)

    def follow(self, points: Array) -> None:
        count = points.shape[1]
        self.paths = [[p] for p in points.T]
        self.moments, self.openings = [[0.0] for _ in range(count)], [""] * count
        self.ended = [f"still inside after {STEPS} steps"] * count
        zero = np.zeros(count)
        now = _Steps(np.arange(count), zero, points, self.flow(points), zero + self.limit)
        with progress(total=count, label="tracers") as bar:
            for _ in range(STEPS):
                now = self._stepped(now)
                bar.update(count - len(now.who) - bar.n)
                if not len(now.who):
                    return

    def _stepped(self, now: _Steps) -> _Steps:
        """The tracers that are still inside after a step of each."""
        speed = np.linalg.norm(now.velocity, axis=0)
        length = np.minimum(now.length, self.limit - now.time)
        length = np.minimum(length, STRIDE * self.flow.width / np.maximum(speed, 1e-300))
        step = dormand_prince(self.flow, now.position, now.velocity, length)
        assert step.slope is not None
        error = np.linalg.norm(step.error, axis=0) / (self.tolerance * self.flow.width)
        outside = self.flow.in_walls(step.state, self.flow.width)
        done = (error <= 1) & ~outside
        factor = np.clip(0.9 * np.maximum(error, 1e-12) ** -0.2, 0.2, 5.0)
        after = _Steps(
            now.who,
            np.where(done, now.time + length, now.time),
            np.where(done, step.state, now.position),
            np.where(done, step.slope, now.velocity),
            length * np.where(outside, np.minimum(factor, 0.25), factor),
        )
        gone = self._advanced(now.only(done), after.only(done))
        left = np.isin(now.who, gone)
        held = ~done & (after.length * speed < STUCK * self.flow.width)
        over = ~left & (after.time >= self.limit * (1 - 1e-12))
        for which, why in ((held, "ran into a wall"), (over, "still inside at the time limit")):
            for i in now.who[which]:
                self.ended[i] = why
        return after.only(~(left | held | over))

    def _advanced(self, before: _Steps, after: _Steps) -> NDArray[np.int64]:
        """Write down where steps went; the tracers that left in them."""
        share, gone = np.ones(len(before.who)), np.zeros(len(before.who), dtype=bool)
        for opening in self.flow.ports:
            out = self.flow.behind(after.position, opening) & ~gone
            out &= opening.normal @ after.velocity < 0
            share[out] = _crossing(before.only(out), after.only(out), opening)
            gone |= out
            for i in before.who[out]:
                self.openings[i], self.ended[i] = opening.name, f"left through '{opening.name}'"
        for part in PARTS:
            times = before.time + part * share * (after.time - before.time)
            positions = _between(before, after, part * share).T
            for i, time, position in zip(before.who, times, positions, strict=True):
                self.moments[i].append(float(time))
                self.paths[i].append(position)
        return before.who[gone]


def _between(before: _Steps, after: _Steps, share: Array) -> Array:
    """Positions (dim, M) within steps, by cubic Hermite interpolation."""
    length, s = after.time - before.time, share
    return (
        (1 + 2 * s) * (1 - s) ** 2 * before.position
        + s**2 * (3 - 2 * s) * after.position
        + length * s * (1 - s) * ((1 - s) * before.velocity - s * after.velocity)
    )


def _crossing(before: _Steps, after: _Steps, opening: Port) -> Array:
    """Shares (M,) of steps at which tracers go through an opening, by bisection."""
    low, high = np.zeros(len(before.who)), np.ones(len(before.who))
    for _ in range(BISECTIONS):
        middle = 0.5 * (low + high)
        arm = _between(before, after, middle) - opening.centre[:, None]
        inside = opening.normal @ arm > 0
        low, high = np.where(inside, middle, low), np.where(inside, high, middle)
    return 0.5 * (low + high)
