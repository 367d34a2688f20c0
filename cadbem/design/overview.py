"""What answers to designers' questions say of themselves when they are printed."""

from __future__ import annotations

from typing import Any

import numpy as np

from cadbem.overviews import source_text
from cadbem.tables import Overview


def network_overview(network: Any) -> Overview:
    """The conductance matrix, with names at its rows and columns."""
    rows = tuple(
        (name, *(f"{value:.4g}" for value in row))
        for name, row in zip(network.names, network.conductance, strict=True)
    )
    facts = (
        "flow rate Q into the fluid = G p",
        f"viscosity {network.problem.viscosity:.4g}, asymmetry {network.asymmetry:.1e}",
    )
    title = f"Network of {len(network.names)} openings: {source_text(network.problem.boundary)}"
    return Overview(title, facts, ("G", *network.names), rows)


def tracers_overview(tracers: Any) -> Overview:
    """Where tracers left, with what share of the flow, and how long they stayed."""
    rows = []
    for name, share in tracers.shares.items():
        here = np.array([opening == name for opening in tracers.openings])
        times = tracers.times[here]
        spread = (f"{t:.4g}" for t in (times.min(), times.mean(), times.max()))
        rows.append((name or "still inside", f"{here.sum()}", f"{share:.2%}", *spread))
    head = ("left through", "tracers", "of the flow", "first", "mean", "last")
    left = f"mean residence time {tracers.mean_time:.5g}" if tracers.left.any() else "none has left"
    return Overview(f"{len(tracers.paths)} tracers, {left}", (), head, tuple(rows))
