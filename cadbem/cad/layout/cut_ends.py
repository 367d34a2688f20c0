"""Where cuts through a region may begin and end.

Sources are the joints of its border and points between them on curved trims. A cut goes from a
source to another one, to the nearest point of a trim, or to where a ray meets the border that
goes on in the border's direction or leaves it at a right angle; and between two holes from one
side to the other.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations

import numpy as np

from cadbem.cad.layout.region import BorderPoint, Region, distance
from cadbem.spline.basis import Array

FEET = 10  # nearest trims that a source is connected with
AHEAD = 1e-4  # share of a trim over which its direction is measured
EDGE = 0.01  # fractions closer than this to a joint are left to the joint
NEIGHBOURS = 4  # nearest holes of a hole between which cuts are tried


@dataclass(frozen=True, eq=False)
class BorderPoints:
    """Points of the border, as arrays (n,) unless said."""

    loop: np.ndarray
    trim: np.ndarray
    fraction: Array
    point: Array  # (2, n)
    onward: Array  # (2, n): unit direction of the border after the point
    angle: Array  # interior
    to_joint: Array  # distance along the border to the trim's nearer end; inf at a joint

    def border_point(self, index: int) -> BorderPoint:
        return BorderPoint(int(self.trim[index]), float(self.fraction[index]))


def candidates(region: Region) -> tuple[BorderPoints, np.ndarray, np.ndarray]:
    """Points of the border, pairs (n, 2) of them, and which pairs separate holes."""
    trim, fraction = _sources(region)
    sources = described(region, trim, fraction)
    count = len(trim)
    first, second = np.tril_indices(count, -1)
    extra = [*_feet(region, sources), *_hits(region, sources)]
    between = _between_holes(region) if len(region.loops) > 2 else []
    places = [place for _, place in extra] + [place for pair in between for place in pair]
    trim = np.concatenate([trim, np.array([p.trim for p in places], dtype=int)])
    fraction = np.concatenate([fraction, np.array([p.fraction for p in places])])
    start = count + len(extra)
    pairs = np.concatenate([
        np.stack([first, second], axis=1),
        np.array([(index, count + k) for k, (index, _) in enumerate(extra)]).reshape(-1, 2),
        start + np.arange(2 * len(between)).reshape(-1, 2),
    ]).astype(int)  # fmt: skip
    separating = np.arange(len(pairs)) >= len(pairs) - len(between)
    return described(region, trim, fraction), pairs, separating


def described(region: Region, trim: np.ndarray, fraction: Array) -> BorderPoints:
    """Points of the border at fractions of trims."""
    point, onward = np.empty((2, len(trim))), np.empty((2, len(trim)))
    angle, to_joint = np.full(len(trim), np.pi), np.full(len(trim), np.inf)
    for k in np.unique(trim):
        here = trim == k
        piece, f = region.trims[k], fraction[here]
        point[:, here] = piece.points(f)
        step = piece.points(f + AHEAD) - point[:, here]
        onward[:, here] = step / np.maximum(np.hypot(*step), 1e-300)
        to_joint[here] = np.where(f == 0, np.inf, np.minimum(f, 1 - f) * piece.length)
    joint = fraction == 0
    angle[joint] = region.angles[trim[joint]]
    onward[:, joint] = np.array([region.trims[k].directions[0] for k in trim[joint]]).T
    return BorderPoints(region.owner[trim], trim, fraction, point, onward, angle, to_joint)


def _sources(region: Region) -> tuple[np.ndarray, Array]:
    """Joints of trims, and points between on curved ones."""
    parts = [max(1, round(trim.turning / (np.pi / 4))) for trim in region.trims]
    trim = np.repeat(np.arange(len(parts)), parts)
    return trim, np.concatenate([np.arange(n) / n for n in parts])


def _feet(region: Region, sources: BorderPoints) -> list[tuple[int, BorderPoint]]:
    """For each source the nearest points of trims about it, if between their ends."""
    squares, shares = distance(sources.point, region.segments), region.shares(sources.point)
    feet = []
    starts = np.searchsorted(region.segment_curve, np.arange(len(region.trims)))
    closest = np.minimum.reduceat(squares, starts, axis=1)
    for index in range(squares.shape[0]):
        for k in np.argsort(closest[index], kind="stable")[: FEET + 1]:
            if k == sources.trim[index]:
                continue
            stop = starts[k + 1] if k + 1 < len(starts) else squares.shape[1]
            segment = int(starts[k] + np.argmin(squares[index, starts[k] : stop]))
            place = region.border_point(segment, float(shares[index, segment]))
            if EDGE < place.fraction < 1 - EDGE:
                feet.append((index, place))
    return _polished(region, sources, feet)


def _polished(
    region: Region, sources: BorderPoints, feet: list[tuple[int, BorderPoint]]
) -> list[tuple[int, BorderPoint]]:
    """Feet on curved trims moved to the curves' nearest points, by parabolas through three
    squared distances."""
    kept = [foot for foot in feet if region.trims[foot[1].trim].is_straight]
    curved = [foot for foot in feet if not region.trims[foot[1].trim].is_straight]
    for k in sorted({place.trim for _, place in curved}):
        trim = region.trims[k]
        index = [i for i, place in curved if place.trim == k]
        fraction = np.array([place.fraction for _, place in curved if place.trim == k])
        points, width = sources.point[:, index], 0.5 / (len(trim.fractions) - 1)
        for _ in range(3):
            low, middle, high = (
                ((trim.points(np.clip(fraction + d, 0, 1)) - points) ** 2).sum(axis=0)
                for d in (-width, 0, width)
            )
            bend = low - 2 * middle + high
            move = np.where(bend > 0, 0.5 * width * (low - high) / np.where(bend > 0, bend, 1), 0)
            fraction = np.clip(fraction + np.clip(move, -2 * width, 2 * width), EDGE, 1 - EDGE)
            width *= 0.1
        kept += [(i, BorderPoint(k, float(f))) for i, f in zip(index, fraction, strict=True)]
    return kept


def _hits(region: Region, sources: BorderPoints) -> list[tuple[int, BorderPoint]]:
    """Where rays end that continue the border into the region, or leave it at right angles."""
    hits = []
    for index, angle in enumerate(sources.angle):
        onward = sources.onward[:, index]
        for turn in _ray_turns(float(angle)):
            cosine, sine = np.cos(turn), np.sin(turn)
            ray = np.array([[cosine, -sine], [sine, cosine]]) @ onward
            place = region.hit(sources.point[:, index], ray)
            if place is not None and EDGE < place.fraction < 1 - EDGE:
                hits.append((index, place))
    return hits


def _ray_turns(angle: float) -> list[float]:
    """Angles from the onward direction of rays from a corner."""
    if angle < np.radians(100):
        return []
    if angle < np.radians(190):
        return [angle / 2]
    return [angle - np.pi, np.pi, angle / 2]


def _between_holes(region: Region) -> list[tuple[BorderPoint, BorderPoint]]:
    """Both ends of lines that pass between two holes: at right angles to their connection, and
    along and across the longest straight trim of the outer loop."""
    boxes = [np.concatenate([s.samples for s in loop], axis=1) for loop in region.loops[1:]]
    centres = np.array([0.5 * (box.max(axis=1) + box.min(axis=1)) for box in boxes])
    sizes = np.array([0.5 * np.ptp(box, axis=1) for box in boxes])
    longest = max(region.loops[0], key=lambda s: s.length if s.is_straight else 0.0)
    axis = longest.directions[0]
    pairs: list[tuple[BorderPoint, BorderPoint]] = []
    for i, j in combinations(range(len(boxes)), 2):
        step = centres[j] - centres[i]
        near = np.sort(np.linalg.norm(centres - centres[i], axis=1))
        if np.hypot(*step) > near[min(NEIGHBOURS, len(near) - 1)] * 1.01:
            continue
        length = np.hypot(*step)
        ahead = 0.5 * (length + sizes[i].max() - sizes[j].max())  # the middle of the gap
        middle = centres[i] + ahead * step / length
        normal = np.array([-step[1], step[0]]) / length
        for ray in (normal, axis, np.array([-axis[1], axis[0]])):
            ends = region.hit(middle, ray), region.hit(middle, -ray)
            if all(end is not None and region.owner[end.trim] == 0 for end in ends):
                pairs.append(ends)  # type: ignore[arg-type]
    return pairs
