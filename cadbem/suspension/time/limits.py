"""Limits of a step in time: how far bodies may go, and which have left."""

from __future__ import annotations

import numpy as np

from cadbem.suspension.time.checkpoint import Checkpoint, ends
from cadbem.suspension.time.state import State

ROOM = 2.0  # gaps, or spacings if these are larger, that a body may go in one step
COMFORTABLE = 1.0  # spacings from which on a gap may close as fast as it likes


def too_far(before: State, after: State) -> bool:
    """Whether a step made surfaces overlap, or left less than half of a narrow gap."""
    return any(
        now.length <= 0 or now.share < COMFORTABLE and now.length < gap.length / 2
        for gap, now in zip(before.gaps, after.gaps, strict=True)
    )


def longest(checkpoint: Checkpoint) -> float:
    """The time in which a body goes ``ROOM`` times as far as its gap or spacing: longer steps
    might cut corners."""
    state = checkpoint.state
    parts = zip(state.bodies, state.gaps, np.split(checkpoint.slope, ends(state)), strict=True)
    return min(
        ROOM * max(gap.length, gap.spacing) / max(float(np.linalg.norm(b.shift(part))), 1e-300)
        for b, gap, part in parts
    )


def leaving(state: State) -> dict[int, str]:
    """Bodies that have reached an opening, by their number, and what to say of them."""
    return {
        gap.body: f"body {gap.body} left through '{gap.opening}' at time {state.time:.4g}"
        for gap in state.gaps
        if gap.at_opening
    }
