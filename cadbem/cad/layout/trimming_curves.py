"""Directed pieces of plane curves, which form the borders of faces and the cuts through them."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from math import ceil

import numpy as np
from scipy.interpolate import BSpline, CubicHermiteSpline

from cadbem.cad.faces.curves import curve_nurbs
from cadbem.cad.faces.evaluate import curve_point
from cadbem.cad.kernel.brep_geometry import CIRCLE, ELLIPSE, LINE, CurveRecord
from cadbem.quadrature.gauss import gauss_unit
from cadbem.spline.basis import Array, multiplicities
from cadbem.spline.nurbs import Nurbs

ENDS = 1e-3  # share of a trim over which its direction at an end is measured
FINEST = np.pi / 18  # turning between two samples
COLLINEAR = 1e-7  # angle (radians) between trims that are one
SHARP = 0.02  # angle (radians) from which a knot counts as a kink


class Table:
    """A spline curve of the plane made ready for many evaluations, and its length."""

    def __init__(self, curve: Nurbs) -> None:
        self._spline = BSpline(curve.knots[0], curve.homogeneous, curve.degrees[0])
        self._low, self._high = curve.domain[0]

    def points(self, t: Array) -> Array:
        """Points (2, n) at parameters (n,)."""
        found = self._spline(np.clip(t, self._low, self._high))
        return (found[:, :-1] / found[:, -1:]).T

    def parameters(self, start: float, end: float, shares: Array) -> Array:
        """Parameters at shares of the length between two of them."""
        to_length, to_parameter = self._lengths
        first, last = to_length(np.clip([start, end], self._low, self._high))
        return to_parameter(first + shares * (last - first))

    @cached_property
    def _lengths(self) -> tuple[CubicHermiteSpline, CubicHermiteSpline]:
        """Length by parameter and the other way, smooth up to 1e-9 or so of it."""
        nodes, weights = gauss_unit(6)
        breaks = np.unique(self._spline.t)
        parts = max(8, 128 // len(breaks))
        fine = breaks[:-1, None] + np.diff(breaks)[:, None] * np.arange(parts) / parts
        ends = np.append(fine.ravel(), breaks[-1])
        steps = np.diff(ends)[:, None]
        inner = self._speed((ends[:-1, None] + steps * nodes).ravel()).reshape(len(steps), -1)
        lengths = np.concatenate([[0.0], np.cumsum((inner * weights * steps).sum(axis=1))])
        speed = self._speed(ends)
        return (
            CubicHermiteSpline(ends, lengths, speed),
            CubicHermiteSpline(lengths, ends, 1 / speed),
        )

    def _speed(self, t: Array) -> Array:
        value, change = self._spline(t), self._spline.derivative()(t)
        points = value[:, :-1] / value[:, -1:]
        length = np.hypot(*((change[:, :-1] - change[:, -1:] * points) / value[:, -1:]).T)
        return np.maximum(length, 1e-6 * length.max())


@dataclass(frozen=True, eq=False)
class TrimmingCurve:
    """A plane curve from parameter `start` to `end`, which may be smaller; fractions 0 to 1 run
    along it."""

    record: CurveRecord
    start: float
    end: float
    table: Table | None = None  # of a spline, shared by pieces of one curve
    is_degenerate: bool = False  # it is a point of the face that is spread out

    def points(self, fractions: Array) -> Array:
        """Points (2, n)."""
        t = self.start + np.asarray(fractions) * (self.end - self.start)
        if self.record.spline is None:
            return curve_point(self.record, t)[0]
        return self._table.points(t)

    @cached_property
    def _table(self) -> Table:
        return self.table or Table(self._curve)

    @cached_property
    def _curve(self) -> Nurbs:
        ends = sorted((self.start, self.end))
        return curve_nurbs(self.record, (ends[0], ends[1]))

    def _piece(self, start: float, end: float) -> TrimmingCurve:
        shared = self._table if self.record.spline is not None else None
        return TrimmingCurve(self.record, start, end, shared, self.is_degenerate)

    def nurbs(self) -> Nurbs:
        """The same as an exact NURBS curve, in the trim's direction."""
        return self._curve if self.end > self.start else self._curve.reversed()

    def part(self, first: float, last: float) -> TrimmingCurve:
        """The piece between two fractions."""
        span = self.end - self.start
        end = self.end if last == 1.0 else self.start + last * span
        return self._piece(self.start + first * span, end)

    def continued(self, other: TrimmingCurve) -> TrimmingCurve | None:
        """One trim for this and one that follows it: along a line, or along the same curve."""
        if self.is_straight and other.is_straight:
            a, b, c, d = *self.samples[:, [0, -1]].T, *other.samples[:, [0, -1]].T
            off = abs(angle_between(b - a, d - c)), abs(angle_between(b - a, d - a))
            one = max(off) < COLLINEAR and self.is_degenerate == other.is_degenerate
            return line(a, d, self.is_degenerate) if one else None
        same = self.record is other.record and (self.end > self.start) == (other.end > other.start)
        gap = other.start - self.end
        if self.record.kind in (CIRCLE, ELLIPSE):
            gap -= 2 * np.pi * round(gap / (2 * np.pi))
        if not same or abs(gap) > COLLINEAR * abs(self.end - self.start):
            return None
        return self._piece(self.start, self.end + other.end - other.start)

    def reversed(self) -> TrimmingCurve:
        return self._piece(self.end, self.start)

    @cached_property
    def fractions(self) -> Array:
        """Where the trim is sampled: its ends only if it is straight."""
        if self.is_straight:
            return np.array([0.0, 1.0])
        at, turned = self._turned
        count = max(4, int(np.ceil(self.turning / FINEST)))
        if self.record.spline is None:
            return np.linspace(0, 1, count + 1)
        measure = turned + 0.5 * max(self.turning, 1e-6) * at  # close where it bends
        return np.interp(np.linspace(0, measure[-1], 3 * count // 2 + 1), measure, at)

    @cached_property
    def samples(self) -> Array:
        """Points (2, n) at `fractions`."""
        return self.points(self.fractions)

    @cached_property
    def is_straight(self) -> bool:
        if self.record.kind == LINE:
            return True
        points = self.points(np.linspace(0, 1, 17))
        chord = points[:, -1] - points[:, 0]
        length = np.hypot(*chord)
        arms = points - points[:, :1]
        off = np.abs(chord[0] * arms[1] - chord[1] * arms[0])
        return bool(length > 0 and off.max() < 1e-9 * length**2)

    @cached_property
    def turning(self) -> float:
        """Sum of the angles, taken positive, by which the direction changes."""
        return float(self._turned[1][-1])

    @cached_property
    def _turned(self) -> tuple[Array, Array]:
        """Fractions, and the turning up to each of them."""
        at = np.linspace(0, 1, 65 if self.record.spline is None else 257)
        angles = np.abs(turns(np.diff(self.points(at))))
        return at, np.concatenate([[0.0], np.cumsum(angles), [angles.sum()]])

    @property
    def arcs(self) -> int:
        """Number of pieces that meet with full multiplicity: arcs are cut at right angles."""
        if self.record.kind not in (CIRCLE, ELLIPSE):
            return 1
        return max(1, ceil(abs(self.end - self.start) / (np.pi / 2) - 1e-9))

    @cached_property
    def length(self) -> float:
        steps = np.diff(self.samples)
        return float(np.hypot(*steps).sum())

    def at_shares(self, shares: Array) -> Array:
        """Points (2, n) at shares of the length, evenly up to a smooth map: programs write splines
        whose parameter runs unevenly, with jumps of its speed that the shape does not have."""
        if self.record.spline is None:
            return self.points(shares)
        return self._table.points(self._table.parameters(self.start, self.end, shares))

    @cached_property
    def directions(self) -> tuple[Array, Array]:
        """Unit vectors along the trim at its start and its end."""
        first, second, third, last = self.points(np.array([0, ENDS, 1 - ENDS, 1])).T
        return _unit(second - first), _unit(last - third)

    def smooth_parts(self) -> list[TrimmingCurve]:
        """Cut at kinks of a spline."""
        spline = self.record.spline
        if spline is None or spline.periodic[0]:
            return [self]
        values, counts = multiplicities(spline.knots[0])
        span = self.end - self.start
        at = np.sort((values[counts >= spline.degrees[0]] - self.start) / span)
        at = at[(at > 1e-6) & (at < 1 - 1e-6)]
        parts = [self.part(a, b) for a, b in pairwise([0.0, *at.tolist(), 1.0])]
        joined = parts[:1]
        for part in parts[1:]:
            if abs(angle_between(joined[-1].directions[1], part.directions[0])) < SHARP:
                joined[-1] = self._piece(joined[-1].start, part.end)
            else:
                joined.append(part)
        return joined


def line(start: Array, end: Array, is_degenerate: bool = False) -> TrimmingCurve:
    """The straight trim between two points of the plane."""
    record = CurveRecord(LINE, np.array([start, end - start]))
    return TrimmingCurve(record, 0.0, 1.0, is_degenerate=is_degenerate)


def turns(steps: Array) -> Array:
    """Angles between successive vectors (2, n), counter-clockwise positive: (n - 1,)."""
    cross = steps[0, :-1] * steps[1, 1:] - steps[1, :-1] * steps[0, 1:]
    return np.arctan2(cross, (steps[:, :-1] * steps[:, 1:]).sum(axis=0))


def angle_between(first: Array, second: Array) -> float:
    """Angle by which the first turns into the second, counter-clockwise positive."""
    return float(np.arctan2(first[0] * second[1] - first[1] * second[0], first @ second))


def _unit(vector: Array) -> Array:
    length = np.hypot(*vector)
    return vector / length if length > 0 else vector
