"""The division of a plane region into few, well-shaped four-sided parts.

A region with four corners whose inside is well covered by the Coons map of its sides is a part.
Others are divided: by a pattern (a star round the middle for three corners, a core with four
pieces around it for fewer, a ring round a hole), or by a straight cut from one point of the
border to another. Cuts end where they are best, also in the middle of a side: patches need not
meet corner to corner.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from cadbem.cad.layout.cuts import best_cuts
from cadbem.cad.layout.necks import without_necks
from cadbem.cad.layout.parts import POOR, Part, collapsed, four_sided
from cadbem.cad.layout.patterns import patterns
from cadbem.cad.layout.region import Region
from cadbem.cad.layout.short_edges import without_short_edges
from cadbem.cad.layout.tips import without_tips

DRAWN = 0.2  # quality above which a face that was drawn with four sides is left whole
GOOD = 0.5  # quality above which fewer parts are better than better ones
SAME = 1e-14  # distance, per size, within which regions are the same
ENDS = np.array([0.0, 0.31, 0.5, 1.0])  # fractions of trims that are compared
REMEMBERED = 16  # regions whose division is kept
PATCH_COST = 0.02  # quality that one more patch must gain
BRANCHES = 4
TRIALS = 16  # regions that are cut while looking for better ways
MOST_CUT = 300  # regions that are cut at all: a region that no cut divides would go on for ever
MOST_PARTS = 400


@dataclass(eq=False)
class _Search:
    """The number of regions that may still be cut in the search for better divisions."""

    trials: int


class _Figure:
    """A region as a key: regions of the same figure, as of a floor and the ceiling over it, are
    divided alike."""

    def __init__(self, region: Region) -> None:
        self.region = region
        ends = [trim.points(ENDS).T.ravel() for trim in region.trims]
        grid = SAME * 10.0 ** np.ceil(np.log10(max(region.size, 1e-300)))
        rounded = np.round(np.array(ends) / grid).tolist()
        self._key = (grid, *sorted(map(tuple, rounded)))

    def __hash__(self) -> int:
        return hash(self._key)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _Figure) and self._key == other._key


def divided(region: Region) -> list[Part] | None:
    """Parts that fill the region, or None if no way was found.

    Every part covers its area once: its quality is at least `POOR`.
    """
    found = _divided_once(_Figure(region))
    return None if found is None else list(found)


@lru_cache(maxsize=REMEMBERED)
def _divided_once(figure: _Figure) -> list[Part] | None:
    region = figure.region
    whole = collapsed(region.loops[0]) if len(region.loops) == 1 else None
    if whole and whole.quality >= DRAWN:
        return [whole]
    parts: list[Part] = []
    rest = without_necks(region)
    for rule in (without_tips, without_short_edges):
        cut = [rule(left) for left in rest]
        parts += [part for found, _ in cut for part in found]
        rest = [left for _, remaining in cut for left in remaining]
    for left in rest:
        found = _divided(left, _Search(TRIALS), MOST_PARTS)
        if not found:
            return None
        parts += found
    return parts if parts and _worst(parts) >= POOR else None


def _divided(region: Region, search: _Search, most: int) -> list[Part]:
    """The best way found; [] if there is none within `most` parts."""
    best: list[Part] = []
    if len(region.loops) == 1:
        whole = four_sided(region.loops[0]) or collapsed(region.loops[0])
        best = [whole] if whole else []
    if not _settled(best, region):
        for pattern in patterns(region):
            best = max(best, pattern, key=_score)
    if _settled(best, region):
        return best
    search.trials -= 1
    if most <= 1 or search.trials < TRIALS - MOST_CUT:
        return best
    for cut in best_cuts(region, BRANCHES):
        if best and (_settled(best, region) or search.trials <= 0 and _worst(best) >= POOR):
            break
        parts = _all_divided(region.cut(cut.first, cut.last), search, most)
        best = max(best, parts, key=_score)
    return best


def _all_divided(regions: tuple[Region, ...], search: _Search, most: int) -> list[Part]:
    parts: list[Part] = []
    for region in regions:
        found = _divided(region, search, most - len(parts) - 1)
        if not found:
            return []
        parts += found
    return parts


def _settled(parts: list[Part], region: Region) -> bool:
    """Whether parts are good and so few that searching on is not worth while: n corners ask for
    n / 2 - 1 quadrilaterals if there are four, each hole for four more."""
    if len(parts) == 1 and len(region.trims) == 4 and _worst(parts) >= DRAWN:
        return True
    if not parts or _worst(parts) < GOOD:
        return False
    corners = int((np.abs(region.angles - np.pi) > np.radians(30)).sum())
    few = 5 if corners < 4 else (corners - 1) // 2
    return len(parts) <= few + 4 * (len(region.loops) - 1)


def _worst(parts: list[Part]) -> float:
    return min(part.quality for part in parts)


def _patches(parts: list[Part]) -> int:
    return sum(part.patches for part in parts)


def _score(parts: list[Part]) -> float:
    """Quality, of which more than good counts little, less the cost of patches."""
    if not parts:
        return -np.inf
    worst = _worst(parts)
    return min(worst, GOOD) + 0.2 * max(0.0, worst - GOOD) - PATCH_COST * _patches(parts)
