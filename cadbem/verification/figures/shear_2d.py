"""A plane droplet in shear flow (thesis Fig. 3.2)."""

from __future__ import annotations

from typing import Any

import numpy as np

from cadbem.post.style.plots import Curve, Plot
from cadbem.suspension.time.history import History
from cadbem.tables import text_table
from cadbem.verification.true_series import PLANE_SHEAR

# steady D for each viscosity ratio, by how Ca is read
STEADY = {
    "thesis's": {0.2: 0.09987, 1.0: 0.09927, 2.0: 0.09731},
    "physical": {0.2: 0.19907, 1.0: 0.19458, 2.0: 0.18218},
}
VARIANTS = ("ours", "ours, not corrected", "thesis's way", "thesis's way, not corrected")
Runs = dict[tuple[str, float, str], History]


def series_error(history: History) -> float:
    """Largest error of D against the true series for λ = 1."""
    true = np.interp(history.times, PLANE_SHEAR.times, PLANE_SHEAR.deformation)
    return float(abs(history.deformation - true).max())


def report(runs: Runs, capillary: float, points: int, end: float) -> None:
    """Final values against the true steady ones; λ = 1 against the true series."""
    rows = []
    for (reading, ratio, variant), run in runs.items():
        change = run.volume[-1] / run.volume[0] - 1
        steady = STEADY[reading][ratio]
        rows.append(
            (reading, f"{ratio:g}", variant, f"{run.deformation[-1]:.5f}", f"{steady:.5f}",
             f"{change:+.1e}", f"{run.last.evaluations}", f"{run.seconds:.1f}")
        )  # fmt: skip
    head = ("reading", "λ", "variant", f"D({end:g})", "true steady D", "change of area",
            "evaluations", "CPU s")  # fmt: skip
    print(f"Ca = {capillary}, N = {points}; the thesis reports a steady D of about 0.1")
    print(text_table(head, rows))
    for variant in VARIANTS:
        error = series_error(runs["thesis's", 1.0, variant])
        print(f"λ = 1, {variant}: largest error of D(τ) {error:.1e}")


def plots(runs: Runs, end: float) -> list[Plot]:
    """Area and D over τ, and D towards the end."""
    return [area_plot(runs), deformation_plot(runs), deformation_plot(runs, 0.2 * end)]


def area_plot(runs: Runs) -> Plot:
    ours = runs["thesis's", 0.2, "ours, not corrected"]
    curves = [Curve(ours.times, ours.volume / ours.volume[0], "λ = 0.2, ours, not corrected")]
    for k, ratio in ((0, 0.2), (2, 2.0)):
        for variant in ("thesis's way", "thesis's way, not corrected"):
            run = runs["thesis's", ratio, variant]
            label, dashed = f"λ = {ratio:g}, {variant}", "not" in variant
            area = run.volume / run.volume[0]
            curves.append(Curve(run.times, area, label, dashed=dashed, colour=k))
    return Plot("τ", "area / initial area", curves)


def deformation_plot(runs: Runs, after: float = 0.0) -> Plot:
    """D over τ, from a time on."""
    curves = []
    for k, ratio in enumerate((0.2, 1.0, 2.0)):
        ours = runs["thesis's", ratio, "ours"]
        shown = ours.times > after - 1e-9
        label = "" if after else f"λ = {ratio:g}, ours"
        curves.append(Curve(ours.times[shown], ours.deformation[shown], label, colour=k))
        thesis = runs["thesis's", ratio, "thesis's way, not corrected"]
        where = slice(int(np.argmax(shown)), None, 3)
        label = "" if after else "thesis's way, not corrected"
        look: dict[str, Any] = {"line": False, "marks": True, "colour": k}
        curves.append(Curve(thesis.times[where], thesis.deformation[where], label, **look))
        steady = [STEADY["thesis's"][ratio]] * 2
        label = "" if k or not after else "true steady D"
        curves.append(Curve(ours.times[shown][[0, -1]], steady, label, dashed=True))
    return Plot("τ", f"D after τ = {after:g}" if after else "D", curves)
