"""The first elements of an adaptive solution: one a patch, about as long as the channel is wide."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from itertools import pairwise, product
from math import ceil, inf, log

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
MOST_STRIPS = 6  # towards a smooth joint
STATIONS = 16  # along a patch, where widths are measured


def first_elements(boundary: Boundary, levels: int, bend: float = inf) -> Boundary:
    """Patches of one element each that cover a boundary as it was drawn.

    Knots within patches become edges; elements are at most two widths of the channel long, and
    shrink in ``levels`` steps towards re-entrant edges.  They shrink towards smooth joints too,
    until the jump of the curvature there times the length of the element beside it is below
    ``bend``.
    """
    pieces = replace(boundary, patches=tuple(_at_knots(boundary)))
    singular = singular_parts(pieces)
    widths = Widths.of(pieces)
    patches: list[Patch] = []
    for number, patch in enumerate(pieces.patches):
        jumps = singular.bends[number].items()
        longest = {side: bend / jump for side, jump in jumps if jump > 0 and bend < inf}
        longest |= dict.fromkeys(singular.sides[number], 0.0)
        for surface in _divided(patch.surface, _cuts(patch, widths, singular.corners[number])):
            element = _Element.of(replace(patch, surface=surface), patch.surface, longest)
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
    """A patch of one element, and the ``longest`` that a strip beside some of its sides may be, 0
    for re-entrant edges, at which no strip is short enough."""

    patch: Patch
    longest: Mapping[Side, float]

    @classmethod
    def of(cls, patch: Patch, whole: Nurbs, longest: Mapping[Side, float]) -> _Element:
        """An element of a patch of which this is known."""
        domain, all_ = patch.surface.domain, whole.domain
        own = [s for s in longest if domain[s[0]][s[1]] == all_[s[0]][s[1]]]
        return cls(patch, {side: longest[side] for side in own})

    def graded(self, levels: int, widths: Widths) -> list[Patch]:
        """The element cut into strips that shrink towards such sides."""
        if not self.longest:
            return [self.patch]
        size = lengths(self.patch.surface)
        width = float(min(widths.along(self.patch, d, 1)[0] for d in range(len(size))))
        first = min(*size, width)
        steps = {side: _steps(first, most, levels) for side, most in self.longest.items()}
        steps = {side: number for side, number in steps.items() if number}
        if not steps:
            return [self.patch]
        direction = min(steps)[0]
        here = {end: number for (d, end), number in steps.items() if d == direction}
        rest = {side: most for side, most in self.longest.items() if side[0] != direction}
        strips = []
        for surface in self._strips(direction, here, first / size[direction]):
            strips += _Element(replace(self.patch, surface=surface), rest).graded(levels, widths)
        return strips

    def _strips(self, direction: int, steps: Mapping[int, int], unit: float) -> list[Nurbs]:
        """Strips towards one end or both, of which ``steps`` says how many."""
        shares = {0.0, 1.0} | ({0.5} if len(steps) == 2 else set())
        unit = min(unit, 0.5 if len(steps) == 2 else 1.0)
        for end, number in steps.items():
            cuts = [unit * RATIO ** (k + 1) for k in range(number)]
            shares |= {s if end == 0 else 1.0 - s for s in cuts}
        low, high = self.patch.surface.domain[direction]
        places: list[Array] = [np.empty(0)] * len(self.patch.surface.degrees)
        places[direction] = low + (high - low) * np.array(sorted(shares))[1:-1]
        return _divided(self.patch.surface, places)


def _steps(first: float, longest: float, levels: int) -> int:
    """How often the length ``first`` is to shrink; ``levels`` times if nothing is short enough."""
    if longest == 0.0:
        return levels
    return min(ceil(max(0.0, log(longest / first) / log(RATIO))), MOST_STRIPS)
