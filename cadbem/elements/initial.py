"""The first elements of an adaptive solution: one a patch, about as long as the channel is wide."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import pairwise, product

import numpy as np

from cadbem.boundary import Boundary, Patch
from cadbem.elements.reentrant import singular_parts
from cadbem.elements.shape import Side, Widths, lengths, turning
from cadbem.spline.basis import Array
from cadbem.spline.nurbs import Nurbs

LONGEST = 2.0  # length of an element, in widths of the channel beside it
WIDEST_TURN = np.deg2rad(95.0)  # of an element's lines
RATIO = 0.2  # of the lengths of neighbours in a graded sequence
CLOSE = 0.05  # share of a patch within which two cuts become one
STATIONS = 16  # along a patch, where widths are measured


def first_elements(boundary: Boundary, levels: int) -> Boundary:
    """Patches of one element each that cover a boundary as it was drawn.

    Knots within patches become edges; elements are at most two widths of the channel long, and
    shrink in ``levels`` steps towards re-entrant edges.
    """
    pieces = replace(boundary, patches=tuple(_at_knots(boundary)))
    singular = singular_parts(pieces)
    widths = Widths.of(pieces)
    patches: list[Patch] = []
    for patch, sides, corners in zip(pieces.patches, singular.sides, singular.corners, strict=True):
        cuts = _cuts(patch, widths, corners)
        for surface in _divided(patch.surface, cuts):
            element = _Element.of(replace(patch, surface=surface), patch.surface, sides, corners)
            patches += element.graded(levels, widths)
    return replace(boundary, patches=tuple(patches))


def _at_knots(boundary: Boundary) -> Iterator[Patch]:
    for patch in boundary.patches:
        for piece in patch.surface.bezier_pieces():
            yield replace(patch, surface=piece)


def _cuts(patch: Patch, widths: Widths, corners: tuple[Array, ...]) -> list[Array]:
    """Parameters in each direction at which a patch is cut for its size and its corners."""
    result = []
    for direction, (low, high) in enumerate(patch.surface.domain):
        length = lengths(patch.surface)[direction]
        sizes = _reaching(widths.along(patch, direction, STATIONS), length)
        # a patch without anything opposite is as large as it likes
        number = np.concatenate([[0.0], np.cumsum(length / STATIONS / (LONGEST * sizes))])
        parts = max(
            int(np.ceil(number[-1] - 1e-6)),
            int(np.ceil(turning(patch.surface, direction) / WIDEST_TURN - 1e-6)),
            1,
        )
        if number[-1] > 0:
            stations = np.linspace(low, high, STATIONS + 1)
            cuts = np.interp(np.arange(1, parts) / parts * number[-1], number, stations)
        else:
            cuts = np.linspace(low, high, parts + 1)[1:-1]
        fixed = np.array([place[direction] for place in corners])
        result.append(_merged(cuts, fixed, low, high))
    return result


def _reaching(sizes: Array, length: float) -> Array:
    """At each station the largest width among those that reach it: walls that end the channel make
    widths small near by."""
    places = (np.arange(len(sizes)) + 0.5) / len(sizes) * length
    away = abs(places[:, None] - places)
    return np.where(away <= sizes, sizes, 0.0).max(axis=1)


def _merged(cuts: Array, fixed: Array, low: float, high: float) -> Array:
    """Cuts of which those near ``fixed`` ones, or near the ends, give way."""
    room = CLOSE * (high - low)
    inside = np.unique(fixed[(fixed - low > 1e-4 * room) & (high - fixed > 1e-4 * room)])
    kept = [c for c in cuts if not len(inside) or abs(inside - c).min() > room]
    return np.unique(np.concatenate([kept, inside]))


def _divided(surface: Nurbs, cuts: list[Array]) -> list[Nurbs]:
    """The pieces of a surface between cuts."""
    ends = [
        list(pairwise([low, *c, high]))
        for (low, high), c in zip(surface.domain, cuts, strict=True)
    ]
    return [surface.restricted(*bounds) for bounds in product(*ends)]


@dataclass(frozen=True, eq=False)
class _Element:
    """A patch of one element, its singular ``sides``, and ``corners``: for each direction the end
    at which an edge of others meets it."""

    patch: Patch
    sides: frozenset[Side]
    corners: tuple[tuple[int, ...], ...]

    @classmethod
    def of(
        cls, patch: Patch, whole: Nurbs, sides: frozenset[Side], corners: tuple[Array, ...]
    ) -> _Element:
        """An element of a patch whose singular parts are known."""
        domain, all_ = patch.surface.domain, whole.domain
        own = frozenset(s for s in sides if domain[s[0]][s[1]] == all_[s[0]][s[1]])
        ends = set()
        for place in corners:
            at = [_end(value, bounds) for value, bounds in zip(place, domain, strict=True)]
            if all(end is not None for end in at):
                ends.add(tuple(int(end) for end in at if end is not None))
        return cls(patch, own, tuple(sorted(ends)))

    def graded(self, levels: int, widths: Widths) -> list[Patch]:
        """The element cut into smaller ones towards its singular sides and corners."""
        if not levels or not (self.sides or self.corners):
            return [self.patch]
        size = lengths(self.patch.surface)
        width = float(min(widths.along(self.patch, d, 1)[0] for d in range(len(size))))
        step = min(*size, width) if len(size) > 1 else min(size[0], width)
        if self.sides:
            direction = min(self.sides)[0]
            return self._strips(direction, levels, step / size[direction], widths)
        return self._towards(self.corners[0], levels, [step / s for s in size])

    def _strips(
        self, direction: int, levels: int, unit: float, widths: Widths
    ) -> list[Patch]:
        ends = [end for d, end in self.sides if d == direction]
        shares = {0.0, 1.0}
        room = 0.5 if len(ends) == 2 else 1.0
        for end in ends:
            steps = [min(unit, room) * RATIO ** (k + 1) for k in range(levels)]
            shares |= {s if end == 0 else 1.0 - s for s in steps}
            shares |= {0.5} if len(ends) == 2 else set()
        low, high = self.patch.surface.domain[direction]
        cuts: list[Array] = [np.empty(0)] * len(self.patch.surface.degrees)
        cuts[direction] = low + (high - low) * np.array(sorted(shares))[1:-1]
        rest = frozenset(s for s in self.sides if s[0] != direction)
        strips = []
        for surface in _divided(self.patch.surface, cuts):
            strip = _Element(replace(self.patch, surface=surface), rest, ())
            strips += strip.graded(levels, widths) if rest else [strip.patch]
        return strips

    def _towards(self, corner: tuple[int, ...], levels: int, units: list[float]) -> list[Patch]:
        """Nested pieces: two beside each step, one at the corner."""
        near, result = self.patch.surface, []
        whole = near.domain
        for level in range(levels):
            for direction, end in enumerate(corner):
                low, high = whole[direction]
                share = min(units[direction], 1.0) * RATIO ** (level + 1)
                cut = low + (high - low) * (share if end == 0 else 1.0 - share)
                bounds = list(near.domain)
                a, b = bounds[direction]
                bounds[direction] = (cut, b) if end == 0 else (a, cut)
                result.append(replace(self.patch, surface=near.restricted(*bounds)))
                bounds[direction] = (a, cut) if end == 0 else (cut, b)
                near = near.restricted(*bounds)
        return [*result, replace(self.patch, surface=near)]


def _end(value: float, bounds: tuple[float, float]) -> int | None:
    """Which end of an interval a value is at, if any."""
    low, high = bounds
    near = 1e-6 * (high - low)
    return 0 if abs(value - low) < near else 1 if abs(value - high) < near else None
