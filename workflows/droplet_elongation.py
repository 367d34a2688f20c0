"""A droplet of low viscosity drawn out by shear flow (thesis Fig. 4.4).

Ca = 0.5, λ = 0.1, to τ = 12.  The thesis needs 514 points, mesh relaxation and volume correction,
and reports that the surface has grown by 48.3 % at the end.  Here a run from few points and one
from twice as many tell how far the numbers can be trusted.
"""

import cadbem as cb
from cadbem.post.style.plots import Curve, Plot, draw_plots

THESIS_GROWTH = 48.3  # percent


def simulate(
    folder: cb.RunFolder,
    capillary: float,
    ratio: float,
    points: int,
    tolerance: float,
    end: float,
) -> cb.History:
    droplet = cb.Droplet(cb.spline_sphere(points=points), cb.capillary_tension(capillary), ratio)
    simulation = cb.Simulation(cb.FreeFlow(cb.shear()), droplet, stepper=cb.Adaptive(tolerance))
    return cb.record(folder.run(simulation, end, end / 48, part=f"points_{points}"))


def main(
    output: str = "results/droplet_elongation",
    capillary: float = 0.5,
    viscosity_ratio: float = 0.1,
    points: int = 392,
    coarse: int = 200,
    tolerance: float = 1e-3,
    end: float = 12.0,
    resume: bool = False,
) -> cb.History:
    folder = cb.run_folder(output, resume=resume)
    runs = {
        count: simulate(folder, capillary, viscosity_ratio, count, tolerance, end)
        for count in sorted({coarse, points})
    }
    for run in runs.values():
        report(run, capillary, viscosity_ratio)
    as_in_thesis = (capillary, viscosity_ratio, end) == (0.5, 0.1, 12.0)
    if as_in_thesis:
        print(f"\nthesis, τ = 12: the surface has grown by {THESIS_GROWTH} %")

    history = runs[points]
    growth = 100 * (history.area[-1] / history.area[0] - 1)
    folder.summary({"D": history.deformation[-1], "growth of the surface (%)": growth})
    if folder:
        draw_plots(folder / "growth.png", plots(runs, as_in_thesis))
        for state in history.states[::16]:
            cb.draw_droplets(folder / f"shape_{state.time:04.1f}.png", [state.droplet.shape])
        print(f"the pictures are in {folder}")
    return history


def report(run: cb.History, capillary: float, ratio: float) -> None:
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
    print(cb.text_table(head, rows))
    if run.last.stopped:
        print(run.last.stopped)


def plots(runs: dict[int, cb.History], as_in_thesis: bool) -> list[Plot]:
    growth, deformation = [], []
    for k, (count, run) in enumerate(runs.items()):
        label = f"{count} points"
        look = {"dashed": k == 0, "colour": k}
        growth.append(Curve(run.times, 100 * (run.area / run.area[0] - 1), label, **look))
        deformation.append(Curve(run.times, run.deformation, label, **look))
    if as_in_thesis:
        growth.append(Curve([12], [THESIS_GROWTH], "thesis", line=False, marks=True, colour=2))
    return [Plot("τ", "growth of the surface (%)", growth), Plot("τ", "D", deformation)]


if __name__ == "__main__":
    cb.run(main)
