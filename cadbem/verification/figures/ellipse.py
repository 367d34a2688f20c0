"""A plane ellipse that relaxes to a circle (thesis Fig. 3.1)."""

from __future__ import annotations

from typing import Any

import numpy as np

from cadbem.post.style.plots import Curve, Plot
from cadbem.suspension.time.history import History
from cadbem.tables import text_table

RADIUS = np.sqrt(4.7126 / np.pi)
THESIS_ERRORS = (0.1461, 0.0203)  # percent at τ = 2
TOP_AND_RIGHT = np.array([[0.0, np.pi / 2]])


def semi_axes(history: History) -> np.ndarray:
    """Along x and y (2, N): the ellipse's tips stay on the axes."""
    tips = [state.droplet.shape.evaluate(TOP_AND_RIGHT) for state in history.states]
    return np.abs([(tip[0, 0], tip[1, 1]) for tip in tips]).T


def report(runs: dict[str, History], rate: float) -> None:
    """Semi-axes and their errors; the rate of decay."""
    rows = []
    for name, run in runs.items():
        for tau in np.arange(0.0, run.times[-1] + 0.5, 1.0):
            long, short = (float(a[np.isclose(run.times, tau)][0]) for a in semi_axes(run))
            errors = [f"{100 * (a / RADIUS - 1):+.5f}" for a in (long, short)]
            rows.append((name, f"{tau:.1f}", f"{long:.7f}", f"{short:.7f}", *errors))
    rows.append(("thesis", "2.0", "", "", *[f"{error:.4f}" for error in THESIS_ERRORS]))
    print(text_table(("run", "τ", "R1", "R2", "error 1 (%)", "error 2 (%)"), rows))
    history = runs["ours"]
    early, late = (history.deformation[np.isclose(history.times, tau)] for tau in (0.5, 1.0))
    decay = 2 * np.log(early / late)[0]
    print(f"decay of D, τ = 0.5 to 1: {decay:.4f}, exact near the circle: {rate:.4f}")
    print(f"{history.last.evaluations} evaluations, {history.seconds:.1f} CPU s")


def axes_plot(runs: dict[str, History]) -> Plot:
    curves = []
    for k, (name, run) in enumerate(runs.items()):
        long, short = semi_axes(run)
        step = slice(None) if k == 0 else slice(None, None, 4)
        look: dict[str, Any] = {"colour": k, "line": k == 0, "marks": k > 0}
        curves.append(Curve(run.times[step], long[step], f"R1 and R2, {name}", **look))
        curves.append(Curve(run.times[step], short[step], **look))
    ends = runs["ours"].times[[0, -1]]
    curves.append(Curve(ends, [RADIUS, RADIUS], f"exact final radius {RADIUS:.4f}", dashed=True))
    return Plot("τ", "semi-axes", curves)


def decay_plot(history: History, rate: float) -> Plot:
    line = history.deformation[0] * np.exp(-rate * history.times)
    shown = line > 1e-6
    return Plot(
        "τ",
        "D",
        [
            Curve(history.times[shown], history.deformation[shown], "ours", colour=0),
            Curve(history.times[shown], line[shown], "linear decay, exact rate", dashed=True),
        ],
        decades=True,
    )
