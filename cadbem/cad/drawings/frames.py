"""The frame of a chip in its drawing: outlines end at it, and are ports there."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from cadbem.cad.drawings.drawing import DrawnCurve, segment
from cadbem.spline.basis import Array

ON_FRAME = 1e-4  # distance of ends from the frame, per its size, that is none


def split_frame(
    curves: Sequence[DrawnCurve], others: Sequence[DrawnCurve]
) -> tuple[list[DrawnCurve], list[DrawnCurve]]:
    """Curves of the outline, and straight ones of a frame round it: from another layer, or from
    the same one if the rest of it is open."""
    box = _box(curves)
    layers = dict.fromkeys(drawn.layer for drawn in others)
    for layer in layers:
        own = [drawn for drawn in others if drawn.layer == layer]
        frame = [drawn for chain in _chains(own) if _is_frame(chain, box) for drawn in chain]
        if frame:
            return list(curves), frame
    chains = _chains(curves)
    frames = [chain for chain in chains if _is_frame(chain, box)]
    rest = [drawn for chain in chains if not _is_frame(chain, box) for drawn in chain]
    if frames and any(not _is_closed(chain) for chain in chains):
        return rest, [drawn for chain in frames for drawn in chain]
    return list(curves), []


def closed_at_frame(curves: Sequence[DrawnCurve], frame: Sequence[DrawnCurve]) -> list[DrawnCurve]:
    """The curves, and pieces of the frame between the ends of open ones: along each side of the
    frame the first end is joined to the second, the third to the fourth, and so on."""
    if not frame:
        return list(curves)
    near = ON_FRAME * float(np.ptp(_box(frame), axis=0).max())
    ends = [end for chain in _chains(curves) if not _is_closed(chain) for end in _ends(chain)]
    added: list[DrawnCurve] = []
    for side in frame:
        on_side = [end for end in ends if _distance(end, side) < near]
        along = side.ends[1] - side.ends[0]
        on_side.sort(key=lambda end, a=along: float(end @ a))  # type: ignore[misc]
        if len(on_side) % 2 == 0:
            pairs = zip(on_side[::2], on_side[1::2], strict=True)
            added += [DrawnCurve(segment(a, b), curves[0].layer) for a, b in pairs]
    return [*curves, *added]


def on_frame(ends: Array, frame: Sequence[DrawnCurve]) -> bool:
    """Whether both ends (2, 2) of a straight curve lie on one side of the frame."""
    if not frame:
        return False
    near = ON_FRAME * float(np.ptp(_box(frame), axis=0).max())
    return any(max(_distance(end, side) for end in ends) < near for side in frame)


def _is_frame(chain: Sequence[DrawnCurve], box: Array) -> bool:
    """Whether a closed chain of straight curves reaches round a box."""
    straight = all(drawn.curve.degrees == (1,) for drawn in chain)
    own = _box(chain)
    slack = ON_FRAME * float(np.ptp(own, axis=0).max())
    around = (own[0] <= box[0] + slack).all() and (own[1] >= box[1] - slack).all()
    return straight and _is_closed(chain) and bool(around)


def _is_closed(chain: Sequence[DrawnCurve]) -> bool:
    return not _ends(chain)


def _ends(chain: Sequence[DrawnCurve]) -> list[Array]:
    """Ends of curves at which no other curve of the chain ends."""
    ends = np.concatenate([drawn.ends for drawn in chain])
    near = ON_FRAME * max(float(np.ptp(_box(chain), axis=0).max()), 1e-300)
    counts = (np.abs(ends[:, None] - ends).max(axis=2) < near).sum(axis=1)
    return [end for end, count in zip(ends, counts, strict=True) if count == 1]


def _chains(curves: Sequence[DrawnCurve]) -> list[list[DrawnCurve]]:
    """Curves that hang together by their ends."""
    if not curves:
        return []
    near = ON_FRAME * float(np.ptp(_box(curves), axis=0).max())
    left, chains = list(curves), []
    while left:
        chain = [left.pop(0)]
        for drawn in chain:
            gaps = [np.abs(other.ends[:, None] - drawn.ends).max(axis=2).min() for other in left]
            joined = [other for other, gap in zip(left, gaps, strict=True) if gap < near]
            chain += joined
            left = [other for other in left if not any(other is one for one in joined)]
        chains.append(chain)
    return chains


def _box(curves: Sequence[DrawnCurve]) -> Array:
    points = np.concatenate([drawn.curve.points for drawn in curves])
    return np.stack([points.min(axis=0), points.max(axis=0)])


def _distance(point: Array, side: DrawnCurve) -> float:
    """Of a point (2,) from a straight curve."""
    start, step = side.ends[0], side.ends[1] - side.ends[0]
    share = np.clip((point - start) @ step / (step @ step), 0, 1)
    return float(np.hypot(*(point - start - share * step)))
