"""A droplet between parallel plates in shear flow u = (z, 0, 0) (thesis Fig. 4.7 and 4.8).

The plates z = ±W, W being half their distance, move with u = (±W, 0, 0).  Radius R = 1, Ca =
μ × rate × R / γ; D is Taylor's.  Plates are open squares that end in unbounded fluid, with small
elements near the droplet.  The parts, as words of an option: 'time', D(τ) for one confinement R / W
from a round droplet; 'confinement', steady D for several, beside the theory of Shapira and Haber
for small deformation; 'resolution', D(τ) with one thing changed at a time.  True values for
Ca = 0.2, λ = 1, R / W = 0.8 come from a spectral computation.
"""

import json
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path

import numpy as np

import cadbem as cb
from cadbem.boundary import Boundary, Patch
from cadbem.post.style.plots import Curve, Plot, draw_plots
from cadbem.spline.shapes import parallelogram
from cadbem.verification.plates import between_plates
from cadbem.verification.theory import shapira_haber

SERIES = json.loads((Path(__file__).parents[1] / "tests/data/reference.json").read_text())[
    "drop_3d_between_plates_Ca0.2_lambda1_RW0.8"
]
TRUE_CASE = (0.2, 1.0, 0.8)  # Ca, λ, R / W of the series
PEAK = (3.4, 0.3586)  # its overshoot, τ and D
PRINTED = {"largest D": 0.3548, "steady D": 0.3461}  # the thesis, Fig. 4.8
FREE = 0.2231154  # true steady D without plates, Ca = 0.2, λ = 1
PLATE = {"side": 12.0, "spans": 8, "rings": 2}  # the side in W; elements across and outwards
EVERY = 0.1  # τ between states that are kept
Runs = dict[tuple, cb.History]
Keep = Callable[[cb.Simulation, float, float], Iterator[cb.State]]


def simulate(
    keep: Keep, droplet: cb.Droplet, confinement: float, tolerance: float, end: float, plate: dict
) -> cb.History:
    flow = between_plates(1 / confinement, **plate)
    simulation = cb.Simulation(flow, droplet, stepper=cb.Adaptive(tolerance))
    return cb.record(keep(simulation, end, EVERY))


def main(
    output: str = "results/droplet_between_plates",
    capillary: float = 0.2,
    viscosity_ratio: float = 1.0,
    confinement: float = 0.8,
    confinements: str = "0.1 0.2 0.4 0.5 0.6 0.7 0.8",
    points: int = 200,
    degree: int = 6,
    tolerance: float = 1e-3,
    end: float = 14.0,
    settle: float = 8.0,
    parts: str = "time",
    resume: bool = False,
) -> Runs:
    folder = cb.run_folder(output, resume=resume)
    made: Runs = {}

    def droplet(count: int = points) -> cb.Droplet:
        shape = cb.spline_sphere(points=count, degree=degree)
        return cb.Droplet(shape, cb.capillary_tension(capillary), viscosity_ratio)

    # Fig. 4.8: overshoot and slow retraction
    if "time" in parts:
        run = simulate(folder.run, droplet(), confinement, tolerance, end, PLATE)
        made["time", confinement] = run
        report_time(folder, run)

    # Fig. 4.7
    if "confinement" in parts:
        shares = sorted(map(float, confinements.split()))
        runs = confinement_runs(folder, droplet(), shares, tolerance, settle)
        report_confinement(folder, runs)
        made |= {("confinement", share): run for share, run in runs.items()}

    if "resolution" in parts:  # what the numbers above depend on
        runs = resolution_runs(droplet, confinement, tolerance, min(end, 4.0))
        report_resolution(runs)
        made |= {("resolution", *key): run for key, run in runs.items()}
    if folder:
        print(f"\nthe pictures are in {folder}")
    return made


def confinement_runs(
    folder: cb.RunFolder,
    droplet: cb.Droplet,
    shares: list[float],
    tolerance: float,
    settle: float,
) -> dict[float, cb.History]:
    """Each droplet starts from the steady shape of the one before."""
    runs = {}
    for share in shares:
        keep = partial(folder.run, part=f"confinement_{share:g}")
        runs[share] = simulate(keep, droplet, share, tolerance, settle, PLATE)
        droplet = runs[share].last.droplet
    return runs


def resolution_runs(
    droplet: Callable[..., cb.Droplet], confinement: float, tolerance: float, end: float
) -> Runs:
    """Each differs from the first in one thing."""

    def run(drop: cb.Droplet, step: float = tolerance, **plate) -> cb.History:
        return simulate(cb.Simulation.run, drop, confinement, step, end, PLATE | plate)

    plates = {"side": (6.0, 24.0), "spans": (4, 6, 12), "rings": (3,)}
    changes = [(name, value) for name, values in plates.items() for value in values]
    finer = {(name, value): run(droplet(), **{name: value}) for name, value in changes}
    counts = {("points", n): run(droplet(n)) for n in (128, 392)}
    steps = {("tolerance", t): run(droplet(), t) for t in (4 * tolerance, tolerance / 4)}
    return {("as above", ""): run(droplet())} | finer | counts | steps


def case_of(run: cb.History) -> tuple[float, float, float]:
    """Ca, λ and R / W of a run."""
    state = run.last
    half_width = state.flow.problem.boundary.bounds()[1, 2]
    tension = state.droplet.interface.tension
    return 1 / tension, state.droplet.viscosity_ratio, float(np.round(1 / half_width, 12))


def true_series(run: cb.History) -> tuple[np.ndarray, np.ndarray]:
    """True D(τ), as long as the run lasts; nothing for other cases."""
    times, deformation = (np.array(SERIES[key]) for key in ("tau", "D"))
    known = np.allclose(case_of(run), TRUE_CASE)
    shown = (times < run.last.time + 1e-9) & known
    return times[shown], deformation[shown]


def kept(run: cb.History, times: np.ndarray) -> np.ndarray:
    """D at times of the true series."""
    return np.array([cb.taylor_deformation(run.at(t).droplet.shape) for t in times])


def report_time(folder: cb.RunFolder, run: cb.History) -> None:
    folder.summary({"largest D": run.deformation.max(), "last D": run.deformation[-1]})
    capillary, ratio, share = case_of(run)
    top = int(run.deformation.argmax())
    state = run.last
    walls = state.flow.problem.space.count
    print(f"Ca = {capillary:g}, λ = {ratio:g}, R / W = {share:g}: {walls} points on the plates, "
          f"{state.droplet.shape.basis.count} on the droplet, {state.evaluations} evaluations, "
          f"{run.seconds:.0f} CPU s")  # fmt: skip
    times, true = true_series(run)
    true_last = f"{SERIES['D_steady']:.5f} (steady)"
    printed_top, printed_last = map(str, PRINTED.values())
    rows = [
        ("largest D", f"{run.deformation[top]:.5f}", f"{PEAK[1]:.4f}", printed_top),
        ("at τ", f"{run.times[top]:.1f}", f"{PEAK[0]:.1f}", ""),
        ("last D", f"{run.deformation[-1]:.5f}", true_last, printed_last),
    ]
    found = kept(run, times)
    rows += [
        (f"D({t:g})", f"{f:.5f}", f"{d:.5f}", "")
        for t, f, d in zip(times, found, true, strict=True)
    ]
    columns = 4 if true.size else 2
    head = ("", "ours", "true", "thesis")
    print(cb.text_table(head[:columns], [row[:columns] for row in rows]))
    if true.size:
        print(f"largest difference from the true series {abs(found - true).max():.1e}")
    angle = cb.inclination(state.droplet.shape)
    print(f"inclination at τ = {state.time:g}: {angle:.2f} degrees")
    if state.stopped:
        print(f"stopped: {state.stopped}")
    if folder:
        draw_time(folder, run)
        draw_motion(folder, run)


def draw_time(folder: cb.RunFolder, run: cb.History) -> None:
    """D over τ, and the same from the overshoot on."""
    times, true = true_series(run)
    plots = []
    for after in (0.0, run.last.time / 7):
        ours, theirs = run.times > after - 1e-9, times > after - 1e-9
        curves = [Curve(run.times[ours], run.deformation[ours], "ours")]
        if theirs.any():
            ends = run.times[ours][[0, -1]]
            curves += [
                Curve(times[theirs], true[theirs], "true", line=False, marks=True, colour=1),
                Curve(ends, [SERIES["D_steady"]] * 2, "true, steady", dashed=True, colour=1),
                *[Curve(ends, [v] * 2, f"thesis, {k}", dashed=True, colour=2 + i)
                  for i, (k, v) in enumerate(PRINTED.items()) if after],
            ]  # fmt: skip
        plots.append(Plot("τ", "D", curves))
    draw_plots(folder / "deformation.png", plots)


def draw_motion(folder: cb.RunFolder, run: cb.History) -> None:
    """A movie and a film strip, with strips of the plates."""
    half_width = run.last.flow.problem.boundary.bounds()[1, 2]
    long, wide = 2.5, 0.9 * half_width
    strips = [parallelogram((-long, -wide, z), (2 * long, 0, 0), (0, 2 * wide, 0))
              for z in (-half_width, half_width)]  # fmt: skip
    plates = Boundary((Patch(strips[0], "plates"), Patch(strips[1].swapped(), "plates")))
    frames = [cb.Frame(state.time, state.shapes) for state in run.states[::2]]
    cb.draw_movie(folder / "movie.gif", plates, frames)
    cb.filmstrip(folder / "strip.png", plates, frames)


def report_confinement(folder: cb.RunFolder, runs: dict[float, cb.History]) -> None:
    rows = []
    for share, run in runs.items():
        capillary, ratio, _ = case = case_of(run)
        before = run.deformation[run.times > run.last.time - 1][0]
        true = f"{SERIES['D_steady']:.5f}" if np.allclose(case, TRUE_CASE) else ""
        rows.append(
            (f"{share:g}", f"{run.deformation[-1]:.5f}", f"{run.deformation[-1] - before:+.0e}",
             f"{shapira_haber(capillary, ratio, share):.5f}", true,
             f"{cb.inclination(run.last.droplet.shape):.2f}", f"{run.seconds:.0f}")
        )  # fmt: skip
    print(f"\nCa = {capillary:g}, λ = {ratio:g}")
    head = ("R / W", "steady D", "change over the last τ", "Shapira and Haber", "true",
            "inclination (deg)", "CPU s")  # fmt: skip
    print(cb.text_table(head, rows))
    if np.allclose((capillary, ratio), TRUE_CASE[:2]):
        print(f"without plates: true {FREE:.5f}, Taylor {shapira_haber(capillary, ratio, 0):.5f}")
    if folder:
        draw_confinement(folder, runs)


def draw_confinement(folder: cb.RunFolder, runs: dict[float, cb.History]) -> None:
    shares = np.array(list(runs))
    capillary, ratio, _ = case_of(runs[shares[0]])
    range_ = np.linspace(0, shares.max(), 60)
    curves = [
        Curve(shares, [run.deformation[-1] for run in runs.values()], "ours", marks=True, colour=0),
        Curve(range_, [shapira_haber(capillary, ratio, s) for s in range_],
              "Shapira and Haber, small deformation", dashed=True),
    ]  # fmt: skip
    if np.allclose((capillary, ratio), TRUE_CASE[:2]):
        known = [FREE, SERIES["D_steady"]]
        curves.append(Curve([0, TRUE_CASE[2]], known, "true", line=False, marks=True, colour=1))
    draw_plots(folder / "confinement.png", [Plot("R / W", "steady D", curves)])


def report_resolution(runs: Runs) -> None:
    (first, *_), rows = runs.values(), []
    for (name, value), run in runs.items():
        times, true = true_series(run)
        error = f"{abs(kept(run, times) - true).max():.1e}" if times.size else ""
        walls = run.last.flow.problem.space.count
        rows.append(
            (name, f"{value}", f"{walls}", f"{run.last.droplet.shape.basis.count}",
             f"{run.deformation[-1]:.5f}", f"{run.deformation[-1] - first.deformation[-1]:+.1e}",
             error, f"{run.last.evaluations}", f"{run.seconds:.0f}")
        )  # fmt: skip
    head = ("changed", "to", "plate points", "droplet points", f"D({first.last.time:g})",
            "difference", "largest error", "evaluations", "CPU s")  # fmt: skip
    print("\n" + cb.text_table(head, rows))


if __name__ == "__main__":
    cb.run(main)
