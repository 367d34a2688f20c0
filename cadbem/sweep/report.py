"""The table and the plot of a sweep."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from cadbem.files import csv_lines, names_of, write_whole
from cadbem.post.style.plots import Curve, Plot, draw_plots
from cadbem.sweep.point import Point

SIDE_BY_SIDE = 3  # plots in a picture


def write_table(path: Path, points: Sequence[Point]) -> None:
    """A row for each point that has ended: the swept values, what was found, and its folder."""
    rows = [_row(point) for point in points]
    write_whole(path, csv_lines(rows, names_of(rows)))


def _row(point: Point) -> dict[str, Any]:
    found = point.summary
    state = "done" if found is not None else "not done"
    last = {"state": state, "folder": Path(point.folder).name}
    taken = point.values.keys() | last.keys()
    renamed = {f"{n} found" if n in taken else n: value for n, value in (found or {}).items()}
    return {**point.values, **renamed, **last}


def draw_table(path: Path, points: Sequence[Point]) -> list[Path]:
    """Every number that was found over the first swept option, a curve for each value of the
    others; a few plots a picture.  Returns the pictures."""
    done = [(point.values, point.summary) for point in points if point.summary]
    names = [n for n, v in (done[0][1] if done else {}).items() if isinstance(v, float)]
    if not names:
        return []
    plots = [_plot(done, name) for name in names]
    groups = [plots[k : k + SIDE_BY_SIDE] for k in range(0, len(plots), SIDE_BY_SIDE)]
    made = []
    for k, group in enumerate(groups):
        made.append(path if k == 0 else path.with_stem(f"{path.stem}_{k + 1}"))
        draw_plots(made[-1], group)
    return made


def _plot(done: Sequence[tuple[dict[str, str], dict[str, Any]]], name: str) -> Plot:
    along = next(iter(done[0][0]))
    curves: dict[str, list[tuple[float, float]]] = {}
    for values, found in done:
        number, _, unit = values[along].partition(" ")
        rest = ", ".join(f"{k} = {v}" for k, v in values.items() if k != along)
        value = found.get(name)
        if isinstance(value, float):
            curves.setdefault(rest, []).append((float(number), value))
    label = along.replace("-", " ") + (f" ({unit})" if unit else "")
    drawn = []
    for rest, pairs in curves.items():
        x, y = np.array(sorted(pairs)).T
        drawn.append(Curve(x, y, rest, marks=True))
    return Plot(label, name, drawn)
