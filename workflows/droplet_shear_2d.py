"""A plane droplet in shear flow: area and Taylor's D against time (thesis Fig. 3.2).

N = 24, Ca = 0.2, viscosity ratio λ = 0.2, 1 and 2, without and with correction of the area.  The
thesis's Δf = (2 / Ca) c n makes its Ca twice the true one, μ × rate × R / γ: 'thesis's reading' is
a true Ca of 0.1, 'physical reading' one of 0.2.  True steady D from a spectral computation; for
λ = 1 and a true Ca of 0.1 there is a series in time as well.
"""

import json
from pathlib import Path

import numpy as np

import cadbem as cb
from cadbem.post.style.plots import Curve, Plot, draw_plots
from cadbem.quadrature.closed import PolarRule
from cadbem.suspension.interface.laws import thesis_tension_2d
from cadbem.suspension.time.thesis_methods import thesis_methods

CAPILLARY = 0.2
SERIES = json.loads((Path(__file__).parents[1] / "tests/data/reference.json").read_text())[
    "drop_2d_shear"
]["Cat0.1_l1"]
READINGS = {
    "thesis's": (thesis_tension_2d(CAPILLARY), {0.2: 0.09987, 1.0: 0.09927, 2.0: 0.09731}),
    "physical": (cb.capillary_tension(CAPILLARY), {0.2: 0.19907, 1.0: 0.19458, 2.0: 0.18218}),
}
OURS = {"degree": 4, "stepper": cb.Adaptive(1e-5), "rule": PolarRule(1e-7)}
THESIS = {"degree": 2, **thesis_methods()}
VARIANTS = {
    "ours": OURS,
    "ours, not corrected": OURS | {"volume": None},
    "thesis's way": THESIS,
    "thesis's way, not corrected": THESIS | {"volume": None},
}
CASES = [("thesis's", ratio, variant) for ratio in (0.2, 1.0, 2.0) for variant in VARIANTS]
CASES += [("physical", ratio, "ours") for ratio in (0.2, 1.0, 2.0)]
Runs = dict[tuple[str, float, str], cb.History]


def simulate(
    tension: cb.SurfaceTension, ratio: float, points: int, end: float, degree: int, **options
) -> cb.History:
    droplet = cb.Droplet(cb.spline_circle(points=points, degree=degree), tension, ratio)
    simulation = cb.Simulation(cb.FreeFlow(cb.shear(dimension=2)), droplet, **options)
    return cb.record(simulation.run(end, every=0.2))


def series_error(history: cb.History) -> float:
    """Largest error of D against the true series for λ = 1."""
    true = np.interp(history.times, SERIES["tau"], SERIES["D"])
    return float(abs(history.deformation - true).max())


def main(output: str = "results/droplet_shear_2d", points: int = 24, end: float = 8.0) -> Runs:
    folder = cb.run_folder(output)
    # Each variant in the thesis's reading of Ca, ours in the physical one too
    runs = {}
    for reading, ratio, variant in CASES:
        tension = READINGS[reading][0]
        runs[reading, ratio, variant] = simulate(
            tension, ratio, points, end, **VARIANTS[variant]
        )

    # Final values against the true steady ones; λ = 1 against the true series
    rows = []
    for (reading, ratio, variant), run in runs.items():
        change = run.volume[-1] / run.volume[0] - 1
        steady = READINGS[reading][1][ratio]
        rows.append(
            (reading, f"{ratio:g}", variant, f"{run.deformation[-1]:.5f}", f"{steady:.5f}",
             f"{change:+.1e}", f"{run.last.evaluations}", f"{run.seconds:.1f}")
        )  # fmt: skip
    head = ("reading", "λ", "variant", f"D({end:g})", "true steady D", "change of area",
            "evaluations", "CPU s")  # fmt: skip
    print(f"Ca = {CAPILLARY}, N = {points}; the thesis reports a steady D of about 0.1")
    print(cb.text_table(head, rows))
    for variant in VARIANTS:
        error = series_error(runs["thesis's", 1.0, variant])
        print(f"λ = 1, {variant}: largest error of D(τ) {error:.1e}")

    folder.summary({
        "D": runs["thesis's", 1.0, "ours"].deformation[-1],
        "largest error of D": series_error(runs["thesis's", 1.0, "ours"]),
    })
    if folder:
        picture = folder / "droplet_shear_2d.png"
        plots = [area_plot(runs), deformation_plot(runs), deformation_plot(runs, 0.2 * end)]
        draw_plots(picture, plots)
        print(f"the plot is in {picture}")
    return runs


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
        look = {"line": False, "marks": True, "colour": k}
        curves.append(Curve(thesis.times[where], thesis.deformation[where], label, **look))
        steady = [READINGS["thesis's"][1][ratio]] * 2
        label = "" if k or not after else "true steady D"
        curves.append(Curve(ours.times[shown][[0, -1]], steady, label, dashed=True))
    return Plot("τ", f"D after τ = {after:g}" if after else "D", curves)


if __name__ == "__main__":
    cb.run(main)
