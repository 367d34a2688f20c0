"""A droplet in shear flow (thesis Fig. 4.1 to 4.3, Table 4.1)."""

from __future__ import annotations

from typing import Any

import numpy as np

from cadbem.files import Folder
from cadbem.post import draw_droplets
from cadbem.post.style.plots import Curve, Plot, draw_plots
from cadbem.suspension.time.stepping import Adaptive
from cadbem.tables import text_table
from cadbem.verification.figures.common import Runs, Simulate, note_pictures, report_stopped
from cadbem.verification.theory import cox
from cadbem.verification.true_series import SHEAR

TRUE = {(0.2, 1.0): 0.22312, (0.35, 1.0): 0.41240}  # D(5)
# Table 4.1: 202 points, the same with mesh relaxation, 802 points
PRINTED = {
    (0.35, 1.0): (0.3763, 0.4072, 0.4028),
    (0.40, 1.0): (0.4267, 0.4688, 0.4583),
    (0.35, 0.1): (0.3559, 0.3920, 0.3890),
    (0.40, 0.1): (0.3997, 0.4503, 0.4429),
}


def tell_shape(folder: Folder, case: tuple[float, float], runs: Runs) -> dict[str, float]:
    """Report and pictures of one droplet (Fig. 4.3); D and inclination of ours at the end."""
    report_shape(case, runs)
    if folder:
        draw_shapes(folder, case, runs)
        note_pictures(folder)
    found = runs["ours",].last.measures[0]
    return {"D": found.deformation, "inclination (degrees)": found.inclination}


def volume_runs(
    simulate: Simulate, points: int, ours: dict, thesis: dict, folder: Folder
) -> Runs:
    """What happens to the volume at Ca = 0.2 (Fig. 4.1 and 4.2), with its report and picture.

    128 points for λ = 0.1 and 2, about as many as the thesis has."""
    runs: Runs = {}
    for ratio, corrected in ((1.0, True), (1.0, False), (0.1, False), (2.0, False)):
        count = points if ratio == 1 else min(points, 128)
        choice = {} if corrected else {"volume": None}
        for name, options in (("ours", ours), ("thesis's way", thesis)):
            runs[ratio, name, corrected] = simulate(0.2, ratio, count, **options | choice)
    report_volume(runs)
    if folder:
        draw_plots(folder / "volume.png", [small_plot(runs), volume_plot(runs)])
        note_pictures(folder)
    return runs


def table_runs(simulate: Simulate, points: int, ours: dict, reference: int) -> Runs:
    """The cases of Table 4.1, and the report; again with ``reference`` points of degree 6, if
    there are any."""
    runs: Runs = {case: simulate(*case, points, **ours) for case in PRINTED}
    fine = {"degree": 6, "stepper": Adaptive(1e-5), "end": ours["end"]}
    again = PRINTED if reference else ()
    report_table(runs, {case: simulate(*case, reference, **fine) for case in again})
    return runs


def report_shape(case: tuple[float, float], runs: Runs) -> None:
    rows = []
    for (name,), run in runs.items():
        state = run.last
        found = state.measures[0]
        rows.append(
            (name, f"{state.time:g}", f"{found.deformation:.5f}", f"{found.inclination:.2f}",
             f"{found.area / run.area[0] - 1:+.4f}", f"{found.smallest_angle:.0f}",
             f"{found.size_ratio:.1f}", f"{state.evaluations}", f"{run.seconds:.1f}")
        )  # fmt: skip
    head = ("run", "τ", "D", "inclination (deg)", "change of area", "smallest angle (deg)",
            "size ratio", "evaluations", "CPU s")  # fmt: skip
    print("Ca = {}, λ = {}".format(*case))
    print(text_table(head, rows))
    report_stopped({name: run for (name,), run in runs.items()})
    if case in PRINTED:
        print("thesis, D(5): 202 points {}, relaxed {}, 802 points {}".format(*PRINTED[case]))
    if case in TRUE:
        print(f"true D(5): {TRUE[case]:.5f}")


def shape_plot(case: tuple[float, float], runs: Runs, after: float) -> Plot:
    """D over τ from a time on, and the thesis's final values."""
    curves = []
    for k, ((name,), run) in enumerate(runs.items()):
        shown = run.times > after - 1e-9
        curves.append(
            Curve(run.times[shown], run.deformation[shown], "" if after else name, colour=k)
        )
    values = zip(("202 points", "relaxed", "802 points"), PRINTED.get(case, ()), strict=False)
    marks = [(f"thesis, {name}", value, k + 3) for k, (name, value) in enumerate(values)]
    marks += [("true", TRUE[case], 6)] if case in TRUE else []
    if after:
        look: dict[str, Any] = {"line": False, "marks": True}
        curves += [Curve([5], [v], name, colour=k, **look) for name, v, k in marks]
    return Plot("τ", "D", curves)


def draw_shapes(folder: Folder, case: tuple[float, float], runs: Runs) -> None:
    end = runs["ours",].last.time
    draw_plots(folder / "deformation.png", [shape_plot(case, runs, t) for t in (0, 0.6 * end)])
    for (name,), run in runs.items():
        picture = name.replace("'s way", "").replace(", ", "_")
        draw_droplets(folder / f"shape_{picture}.png", [run.last.droplet.shape])


def report_volume(runs: Runs) -> None:
    rows = []
    for (ratio, name, corrected), run in runs.items():
        change = 100 * (run.volume[-1] / run.volume[0] - 1)
        rows.append(
            (f"{ratio:g}", f"{run.last.droplet.shape.basis.count}", name,
             "yes" if corrected else "no", f"{run.deformation[-1]:.5f}", f"{change:+.4f}")
        )  # fmt: skip
    best = runs[1.0, "ours", True]
    times, true = SHEAR.during(best)
    print("\nCa = 0.2")
    head = ("λ", "points", "run", "corrected", f"D({best.last.time:g})", "volume (%)")
    print(text_table(head, rows))
    print("thesis, not corrected: volume (%) off by 5.4 for λ = 1, 18.5 for λ = 0.1")
    print(f"λ = 1: Cox's steady D {cox(0.2, 1.0):.5f}, true steady D {SHEAR.steady:.5f}")
    if times.size:
        error = abs(np.interp(times, best.times, best.deformation) - true).max()
        print(f"λ = 1, ours: true D({times[-1]:g}) {true[-1]:.5f}, largest error {error:.1e}")


def small_plot(runs: Runs) -> Plot:
    """D over τ for λ = 1."""
    curves = []
    for k, (name, corrected) in enumerate(
        (("ours", True), ("thesis's way", True), ("thesis's way", False))
    ):
        run = runs[1.0, name, corrected]
        label = name if corrected else f"{name}, not corrected"
        look: dict[str, Any] = {"dashed": not corrected, "colour": min(k, 1)}
        curves.append(Curve(run.times, run.deformation, label, **look))
    true = SHEAR.during(run)
    curves.append(Curve(*true, "true", line=False, marks=True, colour=2))
    level = [cox(0.2, 1.0)] * 2
    curves.append(Curve(run.times[[0, -1]], level, "Cox, small deformation", dashed=True))
    return Plot("τ", "D for λ = 1", curves)


def volume_plot(runs: Runs) -> Plot:
    curves = []
    for key, colour in (
        ((0.1, "ours", False), None),
        ((0.1, "thesis's way", False), 0),
        ((1.0, "thesis's way", False), 1),
        ((1.0, "thesis's way", True), 1),
        ((2.0, "thesis's way", False), 2),
    ):
        run, (ratio, name, corrected) = runs[key], key
        label = f"λ = {ratio:g}, {name}{'' if corrected else ', not corrected'}"
        volume = run.volume / run.volume[0]
        curves.append(Curve(run.times, volume, label, dashed=corrected, colour=colour))
    return Plot("τ", "volume / initial volume", curves)


def report_table(runs: Runs, fine: Runs) -> None:
    rows = []
    for case, run in runs.items():
        best = f"{fine[case].deformation[-1]:.5f}" if fine else "-"
        true = f"{TRUE[case]:.5f}" if case in TRUE else "-"
        rows.append(
            (*map(str, case), *[f"{value:.4f}" for value in PRINTED[case]],
             f"{run.deformation[-1]:.5f}", best, true, f"{cox(*case):.4f}",
             f"{run.last.evaluations}", f"{run.seconds:.1f}")
        )  # fmt: skip
    head = ("Ca", "λ", "thesis 202", "relaxed", "thesis 802", "ours", "ours, fine", "true",
            "Cox, steady", "evaluations", "CPU s")  # fmt: skip
    count = run.last.droplet.shape.basis.count
    print(f"\nTable 4.1: D({run.last.time:g}), ours from {count} points")
    print(text_table(head, rows))
