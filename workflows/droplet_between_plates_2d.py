"""A plane droplet between moving plates: D(τ) for several widths (thesis Fig. 3.4).

The plates y = ±W, W being half their distance, move with u = (±W, 0): the shear rate is 1.  The
ends of the channel, which is 10 W long, carry u = (y, 0).  Radius 1, λ = 1, Ca = 0.2 in the
thesis's reading, Δf = (2 / Ca) c n, which is a true Ca of 0.1.  The parts, as words of an option:
'widths', with the unbounded droplet and a formula for plates far away; 'resolution', one thing
changed at a time for the narrowest width; 'drift', droplets that start off the middle.  'thesis'
adds all widths with the thesis's methods and numbers of points.
"""


from pathlib import Path

import numpy as np

import cadbem as cb
from cadbem.post.style.plots import Curve, Plot, draw_plots
from cadbem.suspension.interface.laws import thesis_tension_2d
from cadbem.suspension.multibody.contact import narrowest
from cadbem.suspension.time.thesis_methods import thesis_methods
from cadbem.verification.plates import between_plane_plates as between_plates
from cadbem.verification.theory import far_plates

FRAMES = 60
Runs = dict[tuple, cb.History]


def flux_across(state: cb.State, x: float) -> float:
    """∫ u dy across the channel, which shear flow and droplets do not change from 0, over what the
    shear carries to either side, W² / 2."""
    half_width = state.flow.problem.boundary.bounds()[1, 1]
    nodes, weights = np.polynomial.legendre.leggauss(120)
    points = np.stack([np.full(120, x), half_width * nodes])
    return float(state.velocity_at(points)[0] @ weights) * 2 / half_width


def simulate(
    flow: cb.ChannelFlow | cb.FreeFlow,
    capillary: float,
    ratio: float,
    points: int,
    end: float,
    centre: tuple[float, float] = (0.0, 0.0),
    degree: int = 4,
    **options,
) -> cb.History:
    """A droplet that is round at first."""
    shape = cb.spline_circle(points=points, degree=degree, centre=centre)
    droplet = cb.Droplet(shape, thesis_tension_2d(capillary), ratio)
    choice = {"stepper": cb.Adaptive(1e-4)} | options
    return cb.record(cb.Simulation(flow, droplet, **choice).run(end, every=end / FRAMES))


def main(
    output: str = "results/droplet_between_plates_2d",
    capillary: float = 0.2,
    viscosity_ratio: float = 1.0,
    widths: str = "1.25 1.5 2 3 4 8 16",
    points: int = 48,
    end: float = 8.0,
    parts: str = "widths resolution drift",
) -> Runs:
    folder = cb.run_folder(output)
    case, wanted = (capillary, viscosity_ratio), sorted(map(float, widths.split()))
    made: Runs = {}
    print(f"Ca = {capillary} in the thesis's reading, {capillary / 2} true; λ = {viscosity_ratio}")

    if "widths" in parts:
        runs = width_runs(wanted, case, points, end)
        report_widths(runs, viscosity_ratio)
        made |= {("width", w): run for w, run in runs.items()}
        if folder:
            draw_widths(folder, runs, viscosity_ratio)

    if "resolution" in parts:
        runs = resolution_runs(wanted[0], *case, points, end / 2)
        report_resolution(runs, points)
        made |= {("resolution", *key): run for key, run in runs.items()}

    if "thesis" in parts:
        runs = thesis_runs(wanted, case, end)
        report_thesis(runs)
        made |= {("thesis", w): run for w, run in runs.items()}

    if "drift" in parts:
        runs = drift_runs(case, points, 2 * end)
        report_drift(runs)
        made |= {("drift", y): run for y, run in runs.items()}
        if folder:
            draw_drift(folder, runs)
    folder.summary({f"D, {' '.join(map(str, k))}": run.deformation[-1] for k, run in made.items()})
    if folder:
        print(f"\nthe pictures are in {folder}")
    return made


def width_runs(
    widths: list[float], case: tuple[float, float], points: int, end: float
) -> dict[float, cb.History]:
    """One droplet for each width, and one in unbounded fluid."""
    free = cb.FreeFlow(cb.shear(dimension=2))
    flows = {w: between_plates(w) for w in widths} | {np.inf: free}
    return {w: simulate(flow, *case, points, end) for w, flow in flows.items()}


def thesis_runs(
    widths: list[float], case: tuple[float, float], end: float
) -> dict[float, cb.History]:
    """The same by the methods of the thesis."""
    options = {"degree": 2, **thesis_methods()}
    return {w: simulate(between_plates(w, parts=7), *case, 20, end, **options) for w in widths}


def drift_runs(case: tuple[float, float], points: int, end: float) -> dict[float, cb.History]:
    """Droplets off the middle, which drift towards it."""
    flow = between_plates(2.0)
    starts = (0.25, 0.5, 0.75)
    return {y: simulate(flow, *case, points, end, (-4.0, y)) for y in starts}


def report_widths(runs: dict[float, cb.History], ratio: float) -> None:
    free, theory = runs[np.inf].deformation[-1], far_plates(ratio)
    rows = []
    for width, run in runs.items():
        state = run.last
        excess = (run.deformation[-1] / free - 1) * width**2 if width < np.inf else None
        gap = narrowest(state.flow, state.placed, (1,), everywhere=True)[0].length
        flux = "" if excess is None else f"{abs(flux_across(state, 0.7)):.0e}"
        rows.append(
            (f"{width:g}", f"{run.deformation.max():.5f}", f"{run.deformation[-1]:.5f}",
             f"{cb.inclination(state.droplet.shape):.2f}", f"{gap:.3f}",
             "" if excess is None else f"{excess:.4f}", flux,
             f"{abs(run.volume / run.volume[0] - 1).max():.0e}", f"{run.seconds:.1f}")
        )  # fmt: skip
    head = ("W", "largest D", f"D({state.time:g})", "inclination (deg)", "gap to plates",
            "(D / D free - 1) W²", "net flux", "change of area", "CPU s")  # fmt: skip
    print(cb.text_table(head, rows))
    print(f"plates far away: (D / D free - 1) W² = {theory:.4f} for small Ca")


def draw_widths(folder: cb.RunFolder, runs: dict[float, cb.History], ratio: float) -> None:
    """D over τ, its final values over W, shapes, and the narrowest width in motion."""
    curves = []
    for k, (width, run) in enumerate(runs.items()):
        label = f"W = {width:g}" if width < np.inf else "unbounded"
        look = {"dashed": True} if width == np.inf else {"colour": k}
        if not 4 < width < np.inf:  # wider ones look like the unbounded one
            curves.append(Curve(run.times, run.deformation, label, **look))
    bounded = np.array([w for w in runs if w < np.inf])
    free = runs[np.inf].deformation[-1]
    excess = [runs[w].deformation[-1] / free - 1 for w in bounded]
    theory = far_plates(ratio) / bounded**2
    changes = [
        Curve(bounded, excess, f"at τ = {runs[np.inf].last.time:g}", marks=True, line=False),
        Curve(bounded, theory, "plates far away, small Ca", dashed=True),
    ]
    draw_plots(
        folder / "deformation.png",
        [Plot("τ", "D", curves), Plot("W / R", "D / D unbounded - 1", changes, logarithmic=True)],
    )
    names = {f"W = {w:g}" if w < np.inf else "unbounded": run for w, run in runs.items()}
    chosen = [*list(names)[:3], "unbounded"]
    shapes = {name: [names[name].last.droplet.shape] for name in chosen}
    cb.draw_outlines(folder / "shapes.png", shapes)
    draw_motion(folder, runs[bounded[0]])


def draw_motion(folder: Path | cb.RunFolder, run: cb.History) -> None:
    """A movie, and a film strip."""
    channel = run.last.flow.problem.boundary
    frames = [cb.Frame(state.time, state.shapes) for state in run.states]
    cb.draw_movie(folder / "movie.gif", channel, frames)
    cb.filmstrip(folder / "strip.png", channel, frames)


def resolution_runs(width: float, capillary: float, ratio: float, points: int, end: float) -> Runs:
    """Each differs from the first in one thing."""

    def run(channel: dict, count: int = points, **options) -> cb.History:
        flow = between_plates(width, **channel)
        return simulate(flow, capillary, ratio, count, end, **options)

    counts = {("droplet points", n): run({}, n) for n in (16, 24, 32, 2 * points)}
    lengths = {("channel length / W", n): run({"length": n}) for n in (4, 6, 20)}
    finer = {("elements a half width", n): run({"parts": n}) for n in (1, 2, 4, 16)}
    steps = {("tolerance of steps", t): run({}, stepper=cb.Adaptive(t)) for t in (1e-3, 1e-5)}
    return {("as above", ""): run({})} | counts | lengths | finer | steps


def report_resolution(runs: Runs, points: int) -> None:
    (first, *_), rows = runs.values(), []
    last = first.deformation[-1]
    for (changed, value), run in runs.items():
        walls = run.last.flow.problem.space.count
        rows.append(
            (changed, f"{value}", f"{walls}", f"{run.deformation[-1]:.5f}",
             f"{run.deformation[-1] - last:+.1e}", f"{run.last.evaluations}",
             f"{run.seconds:.1f}")
        )  # fmt: skip
    head = ("changed", "to", "wall points", f"D({first.last.time:g})", "difference",
            "evaluations", "CPU s")  # fmt: skip
    width = first.last.flow.problem.boundary.bounds()[1, 1]
    print(f"\nW = {width:g}, {points} points, length 10 W, 8 elements a half width, steps to 1e-4")
    print(cb.text_table(head, rows))


def report_thesis(runs: dict[float, cb.History]) -> None:
    rows = [
        (f"{w:g}", f"{run.deformation.max():.5f}", f"{run.deformation[-1]:.5f}",
         f"{run.last.time:g}", f"{run.seconds:.1f}")
        for w, run in runs.items()
    ]  # fmt: skip
    print("\nthe thesis's way: 20 points of degree 2, 176 on the channel, steps of 0.01")
    print(cb.text_table(("W", "largest D", "last D", "at", "CPU s"), rows))
    for width, run in runs.items():
        if run.last.stopped:
            print(f"W = {width:g}: {run.last.stopped}")


def report_drift(runs: dict[float, cb.History]) -> None:
    """Positions and the rate at which the droplet nears the middle."""
    rows = []
    for start, run in runs.items():
        times, (x, y) = run.track()
        middle = len(times) // 2
        rate = np.log(y[middle] / y[-1]) / (times[-1] - times[middle])
        flux = max(abs(flux_across(s, s.droplet.centre[0] + 0.7)) for s in run.states[::15])
        rows.append(
            (f"{start:g}", f"{y[middle]:.4f}", f"{x[-1]:.3f}", f"{y[-1]:.4f}", f"{rate:.4f}",
             f"{run.deformation[-1]:.5f}", f"{flux:.0e}", f"{run.seconds:.1f}")
        )  # fmt: skip
    head = ("start y", f"y({times[middle]:g})", f"x({times[-1]:g})", f"y({times[-1]:g})",
            "-d ln y / dτ", "D", "net flux", "CPU s")  # fmt: skip
    print("\nW = 2, from x = -4 off the middle")
    print(cb.text_table(head, rows))


def draw_drift(folder: cb.RunFolder, runs: dict[float, cb.History]) -> None:
    (first, *_) = runs.values()
    channel = first.last.flow.problem.boundary
    tracks = {f"from y = {start:g}": run.track()[1] for start, run in runs.items()}
    cb.draw_trajectories(folder / "trajectories.png", channel, tracks)


if __name__ == "__main__":
    cb.run(main)
