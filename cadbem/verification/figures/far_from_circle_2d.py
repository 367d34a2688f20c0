"""A plane droplet far from a circle (thesis Fig. 3.3)."""

from __future__ import annotations

import numpy as np

from cadbem.post.style.plots import Curve, Plot
from cadbem.suspension.interface.mesh import turning
from cadbem.suspension.time.history import History
from cadbem.suspension.time.state import State
from cadbem.tables import text_table


def sharpest_turn(state: State) -> float:
    """Largest angle in degrees between the normals of neighbouring collocation points."""
    return float(turning(state.layers[0].targets).max())


def report(runs: dict[str, History], true: History) -> None:
    """D on the way, its largest error, and how much neighbouring normals differ at the end."""
    picked = [int(np.argmin(abs(true.times - true.times[-1] * share))) for share in (0.2, 0.4, 1.0)]
    rows = []
    for name, run in runs.items():
        count = len(run.times)  # fewer when a run ends early
        values = [f"{run.deformation[i]:.5f}" if i < count else "-" for i in picked]
        error = abs(run.deformation - true.deformation[:count]).max()
        rows.append(
            (name, *values, f"{error:.1e}" if run is not true else "",
             f"{sharpest_turn(run.last):.0f}", f"{run.last.evaluations}", f"{run.seconds:.1f}")
        )  # fmt: skip
    head = ("run", *[f"D({true.times[i]:g})" for i in picked], "largest error", "turn (deg)",
            "evaluations", "CPU s")  # fmt: skip
    print(text_table(head, rows))


def plots(runs: dict[str, History], true: History) -> list[Plot]:
    """D over τ, and its error."""
    values, errors = [], []
    for k, (name, run) in enumerate(runs.items()):
        if run is true:
            values.append(Curve(run.times, run.deformation, name, dashed=True))
            continue
        values.append(Curve(run.times, run.deformation, name, colour=k))
        error = abs(run.deformation - true.deformation[: len(run.times)])
        errors.append(Curve(run.times[1:], error[1:], colour=k))
    return [Plot("τ", "D", values), Plot("τ", "error of D", errors, decades=True)]
