"""A plane droplet far from a circle: mesh relaxation and how points move (thesis Fig. 3.3).

Shear flow, λ = 1, Ca in the thesis's reading, Δf = (2 / Ca) c n, twice the true one.  The thesis's
way is degree 2, steps of 0.01, singularity subtraction and points that move with the normal
velocity: from few points with and without mesh relaxation (C_r1 = C_r2 = 0.2, ten pseudo-steps
after each step), and from many, its ground truth.  Ours moves points as if the body were strained
evenly.
"""

import cadbem as cb
from cadbem.post.style.plots import draw_plots
from cadbem.quadrature.closed import PolarRule
from cadbem.suspension.interface.laws import thesis_tension_2d
from cadbem.suspension.time.thesis_methods import thesis_methods
from cadbem.verification.figures import far_from_circle_2d


def simulate(points: int, end: float, degree: int, capillary: float, **options) -> cb.History:
    shape = cb.spline_circle(points=points, degree=degree)
    droplet = cb.Droplet(shape, thesis_tension_2d(capillary))
    simulation = cb.Simulation(cb.FreeFlow(cb.shear(dimension=2)), droplet, **options)
    return cb.record(simulation.run(end, every=end / 50))


def main(
    output: str = "results/droplet_high_deformation_2d", points: int = 24, fine: int = 96,
    capillary: float = 1.0, end: float = 10.0,
) -> dict[str, cb.History]:  # fmt: skip
    """The thesis's three runs, ours, and the truth: ours with many points of degree 6.

    points: few points on the droplet; fine: many points on the droplet
    capillary: Ca in the thesis's reading
    end: time τ, in units of 1 / rate
    """
    folder = cb.run_folder(output)
    thesis = {"degree": 2, "capillary": capillary, **thesis_methods()}
    relaxed = thesis | {"mesh": cb.RelaxMesh(0.2, 0.2, steps=10, pseudo_step=0.01)}
    precise = {"stepper": cb.Adaptive(1e-6), "rule": PolarRule(1e-8)}
    runs = {
        f"thesis's way, N = {points}": simulate(points, end, **thesis),
        f"thesis's way, N = {points}, relaxed": simulate(points, end, **relaxed),
        f"thesis's way, N = {fine}": simulate(fine, end, **thesis),
        f"ours, N = {points}": simulate(points, end, 4, capillary, stepper=cb.Adaptive(1e-5)),
        f"truth: ours, N = {fine}, degree 6": simulate(fine, end, 6, capillary, **precise),
    }
    *found, true = runs.values()
    print(f"Ca = {capillary} in the thesis's reading, {capillary / 2} true; λ = 1")
    far_from_circle_2d.report(runs, true)
    folder.summary({"D": found[-1].deformation[-1]})
    if folder:
        draw_plots(folder / "deformation.png", far_from_circle_2d.plots(runs, true))
        shapes = [[run.last.droplet.shape] for run in found]
        cb.draw_outlines(folder / "shapes.png", dict(zip(runs, shapes, strict=False)))
        print(f"the pictures are in {folder}")
    return runs


if __name__ == "__main__":
    cb.run(main)
