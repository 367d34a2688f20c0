"""A plane ellipse relaxes to a circle in fluid at rest (thesis Fig. 3.1).

Area 4.7126, so that the circle's radius is sqrt(4.7126 / π) = 1.2247723; semi-axes 1.5 : 1 at
first; Ca in the thesis's reading, Δf = (2 / Ca) c n.  Close to the circle, Taylor's D
decays at the rate γ / ((1 + λ) μ R).  The thesis takes the shape at τ = 2 for the final one and
finds its semi-axes wrong by 0.1461 % and 0.0203 %.
"""

import numpy as np

import cadbem as cb
from cadbem.post.style.plots import draw_plots
from cadbem.quadrature.closed import PolarRule
from cadbem.suspension.interface.laws import thesis_tension_2d
from cadbem.suspension.time.thesis_methods import thesis_methods
from cadbem.verification.figures import ellipse

ASPECT = 1.5


def main(
    output: str = "results/ellipse_relaxation", points: int = 32, degree: int = 4,
    tolerance: float = 1e-7, capillary: float = 0.2, viscosity_ratio: float = 1.0,
    end: float = 4.0,
) -> cb.History:  # fmt: skip
    """Ours, and the thesis's way, which has degree 2.

    points: on the ellipse; degree: of its spline
    tolerance: error of a time step, as a share of the ellipse's size
    capillary: Ca in the thesis's reading
    viscosity_ratio: λ, inner over outer viscosity
    end: time τ
    """
    folder = cb.run_folder(output)
    tension = thesis_tension_2d(capillary)
    rate = tension.tension / ((1 + viscosity_ratio) * ellipse.RADIUS)
    axes = (ellipse.RADIUS * np.sqrt(ASPECT), ellipse.RADIUS / np.sqrt(ASPECT))

    def relax(degree: int, **options) -> cb.History:
        shape = cb.spline_ellipse(axes, points=points, degree=degree)
        droplet = cb.Droplet(shape, tension, viscosity_ratio)
        simulation = cb.Simulation(cb.FreeFlow(cb.at_rest(dimension=2)), droplet, **options)
        return cb.record(simulation.run(end, every=0.05))

    history = relax(degree, stepper=cb.Adaptive(tolerance), rule=PolarRule(1e-7))
    runs = {"ours": history, "thesis's way": relax(2, **thesis_methods())}
    print(f"N = {points}, exact final radius {ellipse.RADIUS:.7f}")
    ellipse.report(runs, rate)
    longer = ellipse.semi_axes(history)[0, -1]
    folder.summary({"D": history.deformation[-1], "longer semi-axis": longer})
    if folder:
        plots = [ellipse.axes_plot(runs), ellipse.decay_plot(history, rate)]
        draw_plots(folder / "ellipse_relaxation.png", plots)
        print(f"the plot is in {folder}")
    return history


if __name__ == "__main__":
    cb.run(main)
