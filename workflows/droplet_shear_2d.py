"""A plane droplet in shear flow: area and Taylor's D against time (thesis Fig. 3.2).

Ca = 0.2, viscosity ratio λ = 0.2, 1 and 2, without and with correction of the area.  The thesis's
Δf = (2 / Ca) c n makes its Ca twice the true one, μ × rate × R / γ: 'thesis's reading' is a true
Ca of 0.1, 'physical reading' one of 0.2.  True steady D from a spectral computation; for λ = 1 and
a true Ca of 0.1 there is a series in time as well.
"""

import cadbem as cb
from cadbem.post.style.plots import draw_plots
from cadbem.quadrature.closed import PolarRule
from cadbem.suspension.interface.laws import thesis_tension_2d
from cadbem.suspension.time.thesis_methods import thesis_methods
from cadbem.verification.figures import shear_2d

CAPILLARY = 0.2
READINGS = {"thesis's": thesis_tension_2d(CAPILLARY), "physical": cb.capillary_tension(CAPILLARY)}
OURS = {"degree": 4, "stepper": cb.Adaptive(1e-5), "rule": PolarRule(1e-7)}
THESIS = {"degree": 2, **thesis_methods()}
WAYS = (OURS, OURS | {"volume": None}, THESIS, THESIS | {"volume": None})
VARIANTS = dict(zip(shear_2d.VARIANTS, WAYS, strict=True))
CASES = [("thesis's", ratio, variant) for ratio in (0.2, 1.0, 2.0) for variant in VARIANTS]
CASES += [("physical", ratio, "ours") for ratio in (0.2, 1.0, 2.0)]


def simulate(
    tension: cb.SurfaceTension, ratio: float, points: int, end: float, degree: int, **options
) -> cb.History:
    droplet = cb.Droplet(cb.spline_circle(points=points, degree=degree), tension, ratio)
    simulation = cb.Simulation(cb.FreeFlow(cb.shear(dimension=2)), droplet, **options)
    return cb.record(simulation.run(end, every=0.2))


def main(
    output: str = "results/droplet_shear_2d", points: int = 24, end: float = 8.0
) -> shear_2d.Runs:
    """Each variant in the thesis's reading of Ca, ours in the physical one too.

    points: on the droplet
    end: time τ, in units of 1 / rate
    """
    folder = cb.run_folder(output)
    runs = {
        (reading, ratio, variant): simulate(
            READINGS[reading], ratio, points, end, **VARIANTS[variant]
        )
        for reading, ratio, variant in CASES
    }
    shear_2d.report(runs, CAPILLARY, points, end)
    ours = runs["thesis's", 1.0, "ours"]
    error = shear_2d.series_error(ours)
    folder.summary({"D": ours.deformation[-1], "largest error of D": error})
    if folder:
        draw_plots(folder / "droplet_shear_2d.png", shear_2d.plots(runs, end))
        print(f"the plot is in {folder}")
    return runs


if __name__ == "__main__":
    cb.run(main)
