"""A plane droplet far from a circle: mesh relaxation and how points move (thesis Fig. 3.3).

Shear flow, λ = 1, Ca = 1 in the thesis's reading, Δf = (2 / Ca) c n, which is a true Ca of 0.5.
The thesis's way is degree 2, steps of 0.01, singularity subtraction and points that move with the
normal velocity: N = 24 with and without mesh relaxation (C_r1 = C_r2 = 0.2, ten pseudo-steps after
each step), and N = 96, its ground truth.  Ours moves points as if the body were strained evenly.
"""

import numpy as np

import cadbem as cb
from cadbem.post.style.plots import Curve, Plot, draw_plots
from cadbem.quadrature.closed import PolarRule
from cadbem.suspension.interface.laws import thesis_tension_2d
from cadbem.suspension.interface.mesh import turning
from cadbem.suspension.time.thesis_methods import thesis_methods


def simulate(points: int, end: float, degree: int, capillary: float, **options) -> cb.History:
    droplet = cb.Droplet(
        cb.spline_circle(points=points, degree=degree), thesis_tension_2d(capillary)
    )
    simulation = cb.Simulation(cb.FreeFlow(cb.shear(dimension=2)), droplet, **options)
    return cb.record(simulation.run(end, every=end / 50))


def sharpest_turn(state: cb.State) -> float:
    """Largest angle in degrees between the normals of neighbouring collocation points."""
    return float(turning(state.layers[0].targets).max())


def main(
    output: str = "results/droplet_high_deformation_2d",
    points: int = 24,
    fine: int = 96,
    capillary: float = 1.0,
    end: float = 10.0,
) -> dict[str, cb.History]:
    folder = cb.run_folder(output)
    # The thesis's three runs, ours, and the truth: ours with many points of degree 6
    thesis = {"degree": 2, "capillary": capillary, **thesis_methods()}
    relaxation = cb.RelaxMesh(0.2, 0.2, steps=10, pseudo_step=0.01)
    runs = {
        f"thesis's way, N = {points}": simulate(points, end, **thesis),
        f"thesis's way, N = {points}, relaxed": simulate(
            points, end, mesh=relaxation, **thesis
        ),
        f"thesis's way, N = {fine}": simulate(fine, end, **thesis),
        f"ours, N = {points}": simulate(points, end, 4, capillary, stepper=cb.Adaptive(1e-5)),
        f"truth: ours, N = {fine}, degree 6": simulate(
            fine, end, 6, capillary, stepper=cb.Adaptive(1e-6), rule=PolarRule(1e-8)
        ),
    }
    *_, true = runs.values()

    print(f"Ca = {capillary} in the thesis's reading, {capillary / 2} true; λ = 1")
    report(runs, true)
    folder.summary({"D": runs[f"ours, N = {points}"].deformation[-1]})
    if folder:
        draw_plots(folder / "deformation.png", plots(runs, true))
        shapes = {name: [run.last.droplet.shape] for name, run in runs.items() if run is not true}
        cb.draw_outlines(folder / "shapes.png", shapes)
        print(f"the pictures are in {folder}")
    return runs


def report(runs: dict[str, cb.History], true: cb.History) -> None:
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
    print(cb.text_table(head, rows))


def plots(runs: dict[str, cb.History], true: cb.History) -> list[Plot]:
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


if __name__ == "__main__":
    cb.run(main)
