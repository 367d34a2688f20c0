"""How long tracers of several streams stay, as a table."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from cadbem.design.tracers import Tracers
from cadbem.tables import text_table
from cadbem.units import Units


def residence_report(streams: Mapping[str, Tracers], units: Units) -> str:
    """A table of residence times: the first, the median and the mean of each stream's flow, and
    its share that is still inside."""
    rows = []
    for name, group in streams.items():
        times, shares = group.distribution
        middle = float(np.interp(0.5, shares, times))
        shown = [units.show(t, "time") for t in (times[0], middle, group.mean_time)]
        rows.append([name, f"{len(group.paths)}", *shown, f"{group.shares.get('', 0.0):.2%}"])
    head = ("from", "tracers", "first", "median", "mean", "of the flow still inside")
    return text_table(head, rows)
