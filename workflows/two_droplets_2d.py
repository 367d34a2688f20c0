"""Two plane droplets that meet between moving plates (thesis Fig. 3.5).

Plates as in droplet_between_plates_2d with W = 2.2; radius 1, λ = 1, Ca = 0.2 in the thesis's
reading.  The parts, as words of an option: 'pass', the thesis's start with centres (0, 0) and
(-2.5, 1), where one droplet passes over the other; 'swap', centres (-1.25, 0.25) and
(1.25, -0.25), where the plates turn them back, each onto the side of the other; both are compared
with the same start in unbounded fluid.  'convergence' adds how the end of 'pass' depends on points
and steps.
"""


from pathlib import Path

import numpy as np
from droplet_between_plates_2d import between_plates, draw_motion, flux_across

import cadbem as cb
from cadbem.operators.closed.nearest import signed_distance
from cadbem.post.style.plots import Curve, Plot, draw_plots
from cadbem.suspension.interface.laws import thesis_tension_2d

STARTS = {"pass": ((0.0, 0.0), (-2.5, 1.0)), "swap": ((-1.25, 0.25), (1.25, -0.25))}
Centres = tuple[tuple[float, float], tuple[float, float]]
Runs = dict[tuple, cb.History]


def simulate(
    flow: cb.ChannelFlow | cb.FreeFlow,
    starts: Centres,
    capillary: float,
    ratio: float,
    points: int,
    tolerance: float,
    end: float,
) -> cb.History:
    tension = thesis_tension_2d(capillary)
    shapes = [cb.spline_circle(points=points, centre=centre) for centre in starts]
    droplets = [cb.Droplet(shape, tension, ratio) for shape in shapes]
    simulation = cb.Simulation(flow, droplets, stepper=cb.Adaptive(tolerance))
    return cb.record(simulation.run(end, every=0.25))


def gaps(run: cb.History) -> tuple[np.ndarray, np.ndarray]:
    """The gap between the droplets, and the narrowest between one and a plate, at each time."""
    points = 8 * run.last.droplet.shape.basis.count
    around = np.linspace(0, 2 * np.pi, points, endpoint=False)[None]
    apart, heights = [], []
    for state in run.states:
        first, second = (droplet.shape for droplet in state.droplets)
        curves = first.evaluate(around), second.evaluate(around)
        apart.append(signed_distance(second, curves[0]).min())
        heights.append(max(abs(curve[1]).max() for curve in curves))
    flow = run.last.flow
    bounded = isinstance(flow, cb.ChannelFlow)
    half_width = flow.problem.boundary.bounds()[1, 1] if bounded else np.inf
    return np.array(apart), half_width - np.array(heights)


def area_change(run: cb.History) -> float:
    """Largest relative change of a droplet's area."""
    areas = np.array([[d.volume for d in state.droplets] for state in run.states])
    return float(abs(areas / areas[0] - 1).max())


def main(
    output: str = "results/two_droplets_2d",
    capillary: float = 0.2,
    viscosity_ratio: float = 1.0,
    half_width: float = 2.2,
    points: int = 32,
    tolerance: float = 1e-3,
    end: float = 10.0,
    parts: str = "pass swap",
) -> Runs:
    folder = cb.run_folder(output)
    plates, free = between_plates(half_width, parts=6), cb.FreeFlow(cb.shear(dimension=2))
    case = (capillary, viscosity_ratio)
    print(f"Ca = {capillary} in the thesis's reading, {capillary / 2} true; λ = {viscosity_ratio}")
    made: Runs = {}
    found: dict[str, float] = {}
    for name in (n for n in STARTS if n in parts):
        for place, flow in (("plates", plates), ("unbounded", free)):
            made[name, place] = simulate(flow, STARTS[name], *case, points, tolerance, end)
    if made:
        report(made)
        for (name, place), run in made.items():
            found[f"smallest gap, {name}, {place}"] = gaps(run)[0].min()
    folder.summary(found)
    if folder:
        for name in {key[0] for key in made}:
            draw(folder / name, made[name, "plates"], made[name, "unbounded"])

    if "convergence" in parts:
        choices = [(points * 3 // 4, tolerance), (points * 3 // 2, tolerance)]
        choices += [(points, tolerance * 10), (points, tolerance / 10)]
        more = {c: simulate(plates, STARTS["pass"], *case, *c, end) for c in choices}
        if ("pass", "plates") in made:
            more = {(points, tolerance): made["pass", "plates"]} | more
        report_convergence(more)
        made |= {("convergence", *key): run for key, run in more.items()}
    if folder:
        print(f"\nthe pictures are in {folder}")
    return made


def report(runs: Runs) -> None:
    rows = []
    for (name, place), run in runs.items():
        tracks = [run.track(number)[1] for number in (1, 2)]
        moves = [f"{y[0]:g} → {y[-1]:.4f}" for _, y in tracks]
        flux = ""
        if place == "plates":
            flux = f"{max(abs(flux_across(state, 0.7)) for state in run.states[::10]):.0e}"
        apart = gaps(run)[0]
        rows.append(
            (name, place, *moves, f"{apart.min():.4f}", f"{run.times[apart.argmin()]:.1f}",
             f"{max(map(cb.taylor_deformation, shapes_of(run))):.4f}", flux,
             f"{area_change(run):.0e}", f"{run.last.evaluations}", f"{run.seconds:.1f}")
        )  # fmt: skip
    head = ("start", "fluid", "y of droplet 1", "y of droplet 2", "smallest gap", "at τ",
            "largest D", "net flux", "change of area", "evaluations", "CPU s")  # fmt: skip
    print(cb.text_table(head, rows))
    for key, run in runs.items():
        if run.last.stopped:
            print(f"{', '.join(key)}: {run.last.stopped}")


def shapes_of(run: cb.History) -> list[cb.ClosedSpline]:
    """All shapes at all times."""
    return [droplet.shape for state in run.states for droplet in state.droplets]


def report_convergence(runs: dict[tuple[int, float], cb.History]) -> None:
    rows = []
    for (points, tolerance), run in runs.items():
        first, second = (run.track(number)[1][:, -1] for number in (1, 2))
        rows.append(
            (f"{points}", f"{tolerance:g}", f"{first[1]:.5f}", f"{second[1]:.5f}",
             f"{second[1] - first[1]:.5f}", f"{gaps(run)[0].min():.5f}",
             f"{run.last.evaluations}", f"{run.seconds:.1f}")
        )  # fmt: skip
    time = run.last.time
    head = ("points", "tolerance", f"y1({time:g})", f"y2({time:g})", "y2 - y1", "smallest gap",
            "evaluations", "CPU s")  # fmt: skip
    print("\n'pass' between plates; droplets started with y2 - y1 = 1")
    print(cb.text_table(head, rows))


def draw(folder: Path, bounded: cb.History, free: cb.History) -> None:
    """Movie, film strip, paths, deformation and gaps of one start."""
    folder.mkdir()
    draw_motion(folder, bounded)
    channel = bounded.last.flow.problem.boundary
    runs = {"": bounded, ", unbounded": free}
    tracks = {f"droplet {n}{where}": run.track(n)[1] for where, run in runs.items() for n in (1, 2)}
    cb.draw_trajectories(folder / "trajectories.png", channel, tracks)
    deformation, distance = [], []
    for where, run in runs.items():
        for n in (1, 2):
            values = [cb.taylor_deformation(state.shapes[n]) for state in run.states]
            look = {"colour": n, "dashed": bool(where)}
            deformation.append(Curve(run.times, values, f"droplet {n}{where}", **look))
        look = {"colour": 0, "dashed": bool(where)}
        distance.append(Curve(run.times, gaps(run)[0], f"between the droplets{where}", **look))
    distance.append(Curve(bounded.times, gaps(bounded)[1], "to a plate", colour=2))
    draw_plots(
        folder / "history.png",
        [Plot("τ", "D", deformation), Plot("τ", "narrowest gap", distance, decades=True)],
    )


if __name__ == "__main__":
    cb.run(main)
