"""What bounds a step of bodies, and what takes bodies out of a run."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from cadbem.suspension.time.checkpoint import Checkpoint, ends
from cadbem.suspension.time.state import State
from cadbem.suspension.time.stepping import Lengths

ROOM = 2.0  # gaps, or spacings if these are larger, that a body may go in one step
STRIDE = 1 / 8  # sizes that a body may go in one implicit step
COMFORTABLE = 1.0  # spacings from which on a gap may close as fast as it likes


def too_far(before: State, after: State) -> bool:
    """Whether a step made surfaces overlap, or left less than half of a narrow gap."""
    return any(
        now.length <= 0 or now.share < COMFORTABLE and now.length < gap.length / 2
        for gap, now in zip(before.gaps, after.gaps, strict=True)
    )


def longest_step(checkpoint: Checkpoint) -> float:
    """The time in which a body goes ``ROOM`` times as far as its gap or spacing: longer steps
    might cut corners."""
    pairs = zip(checkpoint.state.gaps, _speeds(checkpoint), strict=True)
    return min(ROOM * max(gap.length, gap.spacing) / speed for gap, speed in pairs)


def bounded(checkpoint: Checkpoint, known: bool) -> Lengths:
    """The lengths that the next step may have: no implicit one if it is not ``known`` how shapes
    relax, nor one in which a body goes farther than ``STRIDE`` times its size: its shape follows at
    once what it meets, and a longer step might jump over it."""
    pairs = zip(checkpoint.state.bodies, _speeds(checkpoint), strict=True)
    stride = min(STRIDE * b.size / speed for b, speed in pairs) if known else 0.0
    return replace(checkpoint.lengths, implicit=min(checkpoint.lengths.implicit, stride))


def _speeds(checkpoint: Checkpoint) -> list[float]:
    """Speed of each body's middle, never quite zero."""
    parts = zip(
        checkpoint.state.bodies, np.split(checkpoint.slope, ends(checkpoint.state)), strict=True
    )
    return [max(float(np.linalg.norm(b.shift(part))), 1e-300) for b, part in parts]


def leaving(state: State) -> dict[int, str]:
    """Bodies that have reached an opening, by their number, and what to say of them."""
    return {
        gap.body: f"body {gap.body} left through '{gap.opening}' at time {state.time:.4g}"
        for gap in state.gaps
        if gap.at_opening
    }


def output_times(end: float, every: float | None) -> list[float]:
    """Multiples of ``every`` up to ``end``, and that; none at all without ``every``."""
    if every is None:
        return []
    count = int(np.floor(end / every * (1 + 1e-12)))
    times = [every * k for k in range(1, count + 1)]
    return times if times and times[-1] > end * (1 - 1e-9) else [*times, end]
