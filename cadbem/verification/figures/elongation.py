"""A droplet drawn out by shear flow (thesis Fig. 4.4)."""

from __future__ import annotations

from typing import Any

from cadbem.post.style.plots import Curve, Plot
from cadbem.suspension.time.history import History
from cadbem.tables import text_table

THESIS_GROWTH = 48.3  # percent


def report(run: History, capillary: float, ratio: float) -> None:
    """Shape and mesh at four times."""
    rows = []
    for state in run.states[::16]:
        found = state.measures[0]
        tilt = f"{found.inclination:.2f}" if found.deformation > 1e-3 else "-"
        rows.append(
            (f"{state.time:g}", f"{found.deformation:.5f}", f"{found.longest:.4f}",
             f"{found.shortest:.4f}", tilt,
             f"{100 * (found.area / run.area[0] - 1):.2f}", f"{found.smallest_angle:.0f}",
             f"{found.size_ratio:.1f}", f"{state.evaluations}")
        )  # fmt: skip
    head = ("τ", "D", "longest", "shortest", "inclination (deg)", "growth (%)",
            "smallest angle (deg)", "size ratio", "evaluations")  # fmt: skip
    count = run.last.droplet.shape.basis.count
    print(f"\nCa = {capillary}, λ = {ratio}, {count} points, {run.seconds:.1f} CPU s")
    print(text_table(head, rows))
    if run.last.stopped:
        print(run.last.stopped)


def plots(runs: dict[int, History], as_in_thesis: bool) -> list[Plot]:
    growth, deformation = [], []
    for k, (count, run) in enumerate(runs.items()):
        label = f"{count} points"
        look: dict[str, Any] = {"dashed": k == 0, "colour": k}
        growth.append(Curve(run.times, 100 * (run.area / run.area[0] - 1), label, **look))
        deformation.append(Curve(run.times, run.deformation, label, **look))
    if as_in_thesis:
        growth.append(Curve([12], [THESIS_GROWTH], "thesis", line=False, marks=True, colour=2))
    return [Plot("τ", "growth of the surface (%)", growth), Plot("τ", "D", deformation)]
