"""A plane ellipse relaxes to a circle in fluid at rest (thesis Fig. 3.1).

Area 4.7126, so that the circle's radius is sqrt(4.7126 / π) = 1.2247723; semi-axes 1.5 : 1 at
first; Ca = 0.2 in the thesis's reading, Δf = (2 / Ca) c n.  Close to the circle, Taylor's D
decays at the rate γ / ((1 + λ) μ R).  The thesis takes the shape at τ = 2 for the final one and
finds its semi-axes wrong by 0.1461 % and 0.0203 %.
"""

import numpy as np

import cadbem as cb
from cadbem.post.style.plots import Curve, Plot, draw_plots
from cadbem.quadrature.closed import PolarRule
from cadbem.suspension.interface.laws import thesis_tension_2d
from cadbem.suspension.time.thesis_methods import thesis_methods

RADIUS = np.sqrt(4.7126 / np.pi)
ASPECT = 1.5
THESIS_ERRORS = (0.1461, 0.0203)  # percent at τ = 2
TOP_AND_RIGHT = np.array([[0.0, np.pi / 2]])


def semi_axes(history: cb.History) -> np.ndarray:
    """Along x and y (2, N): the ellipse's tips stay on the axes."""
    tips = [state.droplet.shape.evaluate(TOP_AND_RIGHT) for state in history.states]
    return np.abs([(tip[0, 0], tip[1, 1]) for tip in tips]).T


def main(
    output: str = "results/ellipse_relaxation",
    points: int = 32,
    degree: int = 4,
    tolerance: float = 1e-7,
    capillary: float = 0.2,
    viscosity_ratio: float = 1.0,
    end: float = 4.0,
) -> cb.History:
    folder = cb.run_folder(output)
    tension = thesis_tension_2d(capillary)
    rate = tension.tension / ((1 + viscosity_ratio) * RADIUS)
    axes = (RADIUS * np.sqrt(ASPECT), RADIUS / np.sqrt(ASPECT))

    # Ours, and the thesis's way
    def relax(degree: int, **options) -> cb.History:
        droplet = cb.Droplet(
            cb.spline_ellipse(axes, points=points, degree=degree), tension, viscosity_ratio
        )
        simulation = cb.Simulation(cb.FreeFlow(cb.at_rest(dimension=2)), droplet, **options)
        return cb.record(simulation.run(end, every=0.05))

    history = relax(degree, stepper=cb.Adaptive(tolerance), rule=PolarRule(1e-7))
    thesis = relax(2, **thesis_methods())

    runs = {"ours": history, "thesis's way": thesis}
    print(f"N = {points}, exact final radius {RADIUS:.7f}")
    report(runs, rate)

    folder.summary({"D": history.deformation[-1], "longer semi-axis": semi_axes(history)[0, -1]})
    if folder:
        picture = folder / "ellipse_relaxation.png"
        draw_plots(picture, [axes_plot(runs), decay_plot(history, rate)])
        print(f"the plot is in {picture}")
    return history


def report(runs: dict[str, cb.History], rate: float) -> None:
    """Semi-axes and their errors; the rate of decay."""
    rows = []
    for name, run in runs.items():
        for tau in np.arange(0.0, run.times[-1] + 0.5, 1.0):
            long, short = (float(a[np.isclose(run.times, tau)][0]) for a in semi_axes(run))
            errors = [f"{100 * (a / RADIUS - 1):+.5f}" for a in (long, short)]
            rows.append((name, f"{tau:.1f}", f"{long:.7f}", f"{short:.7f}", *errors))
    rows.append(("thesis", "2.0", "", "", *[f"{error:.4f}" for error in THESIS_ERRORS]))
    print(cb.text_table(("run", "τ", "R1", "R2", "error 1 (%)", "error 2 (%)"), rows))
    history = runs["ours"]
    early, late = (history.deformation[np.isclose(history.times, tau)] for tau in (0.5, 1.0))
    decay = 2 * np.log(early / late)[0]
    print(f"decay of D, τ = 0.5 to 1: {decay:.4f}, exact near the circle: {rate:.4f}")
    print(f"{history.last.evaluations} evaluations, {history.seconds:.1f} CPU s")


def axes_plot(runs: dict[str, cb.History]) -> Plot:
    curves = []
    for k, (name, run) in enumerate(runs.items()):
        long, short = semi_axes(run)
        step = slice(None) if k == 0 else slice(None, None, 4)
        look = {"colour": k, "line": k == 0, "marks": k > 0}
        curves.append(Curve(run.times[step], long[step], f"R1 and R2, {name}", **look))
        curves.append(Curve(run.times[step], short[step], **look))
    ends = runs["ours"].times[[0, -1]]
    curves.append(Curve(ends, [RADIUS, RADIUS], f"exact final radius {RADIUS:.4f}", dashed=True))
    return Plot("τ", "semi-axes", curves)


def decay_plot(history: cb.History, rate: float) -> Plot:
    line = history.deformation[0] * np.exp(-rate * history.times)
    shown = line > 1e-6
    return Plot(
        "τ",
        "D",
        [
            Curve(history.times[shown], history.deformation[shown], "ours", colour=0),
            Curve(history.times[shown], line[shown], "linear decay, exact rate", dashed=True),
        ],
        decades=True,
    )


if __name__ == "__main__":
    cb.run(main)
