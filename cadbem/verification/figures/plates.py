"""A droplet between moving plates (thesis Fig. 4.7 and 4.8)."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from cadbem.boundary import Boundary, Patch
from cadbem.files import Folder
from cadbem.post import draw_run
from cadbem.post.style.plots import Curve, Plot, draw_plots
from cadbem.spline.shapes import parallelogram
from cadbem.suspension.bodies.droplet import Droplet
from cadbem.suspension.interface.laws import SurfaceTension
from cadbem.suspension.multibody.measures import inclination, taylor_deformation
from cadbem.suspension.time.history import History
from cadbem.tables import text_table
from cadbem.verification.figures.common import Runs, RunsFolder, Simulate, channel, channel_flow
from cadbem.verification.theory import shapira_haber
from cadbem.verification.true_series import PLATES

TRUE_CASE = (0.2, 1.0, 0.8)  # Ca, λ, R / W of the series
PEAK = (3.4, 0.3586)  # its overshoot, τ and D
PRINTED = {"largest D": 0.3548, "steady D": 0.3461}  # the thesis, Fig. 4.8
FREE = 0.2231154  # true steady D without plates, Ca = 0.2, λ = 1


def case_of(run: History) -> tuple[float, float, float]:
    """Ca, λ and R / W of a run."""
    state = run.last
    half_width = channel(run).bounds()[1, 2]
    law = state.droplet.interface
    assert isinstance(law, SurfaceTension)
    return 1 / law.tension, state.droplet.viscosity_ratio, float(np.round(1 / half_width, 12))


def true_series(run: History) -> tuple[np.ndarray, np.ndarray]:
    """True D(τ), as long as the run lasts; nothing for other cases."""
    if not np.allclose(case_of(run), TRUE_CASE):
        return np.empty(0), np.empty(0)
    return PLATES.during(run)


def kept(run: History, times: np.ndarray) -> np.ndarray:
    """D at times of the true series."""
    return np.array([taylor_deformation(run.at(t).droplet.shape) for t in times])


def tell_time(folder: Folder, run: History) -> dict[str, float]:
    """Report and pictures of D(τ) (Fig. 4.8); the largest and the last D."""
    report_time(run)
    if folder:
        draw_time(folder, run)
        draw_motion(folder, run)
    return {"largest D": run.deformation.max(), "last D": run.deformation[-1]}


def steady_runs(
    simulate: Simulate, droplet: Droplet, confinements: list[float], folder: RunsFolder
) -> dict[float, History]:
    """Steady shapes for rising R / W (Fig. 4.7), each from the one before, in parts of the
    ``folder``; with a report and a picture."""
    runs: dict[float, History] = {}
    for share in confinements:
        keep = partial(folder.run, part=f"confinement_{share:g}")
        runs[share] = simulate(droplet, share, keep=keep)
        droplet = runs[share].last.droplet
    report_confinement(runs)
    if folder:
        draw_confinement(folder, runs)
    return runs


def resolution_runs(
    simulate: Simulate,
    droplet: Callable[..., Droplet],
    confinement: float,
    tolerance: float,
    end: float,
) -> Runs:
    """Runs that differ from the first in one thing each, with a report."""

    def run(drop: Droplet, step: float = tolerance, **plate: Any) -> History:
        return simulate(drop, confinement, step, end, **plate)

    plates = {"side": (6.0, 24.0), "spans": (4, 6, 12), "rings": (3,)}
    changes = [(name, value) for name, values in plates.items() for value in values]
    first = {("as above", ""): run(droplet())}
    finer = {(name, value): run(droplet(), **{name: value}) for name, value in changes}
    counts = {("points", n): run(droplet(points=n)) for n in (128, 392)}
    steps = {("tolerance", t): run(droplet(), t) for t in (4 * tolerance, tolerance / 4)}
    runs: Runs = first | finer | counts | steps
    report_resolution(runs)
    return runs


def report_time(run: History) -> None:
    capillary, ratio, share = case_of(run)
    top = int(run.deformation.argmax())
    state = run.last
    walls = channel_flow(run).problem.space.count
    print(f"Ca = {capillary:g}, λ = {ratio:g}, R / W = {share:g}: {walls} points on the plates, "
          f"{state.droplet.shape.basis.count} on the droplet, {state.evaluations} evaluations, "
          f"{run.seconds:.0f} CPU s")  # fmt: skip
    times, true = true_series(run)
    true_last = f"{PLATES.steady:.5f} (steady)"
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
    print(text_table(head[:columns], [row[:columns] for row in rows]))
    if true.size:
        print(f"largest difference from the true series {abs(found - true).max():.1e}")
    angle = inclination(state.droplet.shape)
    print(f"inclination at τ = {state.time:g}: {angle:.2f} degrees")
    if state.stopped:
        print(f"stopped: {state.stopped}")


def draw_time(folder: Folder, run: History) -> None:
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
                Curve(ends, [PLATES.steady] * 2, "true, steady", dashed=True, colour=1),
                *[Curve(ends, [v] * 2, f"thesis, {k}", dashed=True, colour=2 + i)
                  for i, (k, v) in enumerate(PRINTED.items()) if after],
            ]  # fmt: skip
        plots.append(Plot("τ", "D", curves))
    draw_plots(folder / "deformation.png", plots)


def draw_motion(folder: Folder, run: History) -> None:
    """A movie and a film strip, with strips of the plates."""
    half_width = channel(run).bounds()[1, 2]
    long, wide = 2.5, 0.9 * half_width
    strips = [parallelogram((-long, -wide, z), (2 * long, 0, 0), (0, 2 * wide, 0))
              for z in (-half_width, half_width)]  # fmt: skip
    plates = Boundary((Patch(strips[0], "plates"), Patch(strips[1].swapped(), "plates")))
    draw_run(folder, History(run.states[::2]), ("movie.gif", "filmstrip.png"), channel=plates)


def report_confinement(runs: dict[float, History]) -> None:
    rows = []
    for share, run in runs.items():
        capillary, ratio, _ = case = case_of(run)
        before = run.deformation[run.times > run.last.time - 1][0]
        true = f"{PLATES.steady:.5f}" if np.allclose(case, TRUE_CASE) else ""
        rows.append(
            (f"{share:g}", f"{run.deformation[-1]:.5f}", f"{run.deformation[-1] - before:+.0e}",
             f"{shapira_haber(capillary, ratio, share):.5f}", true,
             f"{inclination(run.last.droplet.shape):.2f}", f"{run.seconds:.0f}")
        )  # fmt: skip
    print(f"\nCa = {capillary:g}, λ = {ratio:g}")
    head = ("R / W", "steady D", "change over the last τ", "Shapira and Haber", "true",
            "inclination (deg)", "CPU s")  # fmt: skip
    print(text_table(head, rows))
    if np.allclose((capillary, ratio), TRUE_CASE[:2]):
        print(f"without plates: true {FREE:.5f}, Taylor {shapira_haber(capillary, ratio, 0):.5f}")


def draw_confinement(folder: Folder, runs: dict[float, History]) -> None:
    shares = np.array(list(runs))
    capillary, ratio, _ = case_of(runs[shares[0]])
    range_ = np.linspace(0, shares.max(), 60)
    curves = [
        Curve(shares, [run.deformation[-1] for run in runs.values()], "ours", marks=True, colour=0),
        Curve(range_, [shapira_haber(capillary, ratio, s) for s in range_],
              "Shapira and Haber, small deformation", dashed=True),
    ]  # fmt: skip
    if np.allclose((capillary, ratio), TRUE_CASE[:2]):
        known = [FREE, PLATES.steady]
        curves.append(Curve([0, TRUE_CASE[2]], known, "true", line=False, marks=True, colour=1))
    draw_plots(folder / "confinement.png", [Plot("R / W", "steady D", curves)])


def report_resolution(runs: Runs) -> None:
    (first, *_), rows = runs.values(), []
    for (name, value), run in runs.items():
        times, true = true_series(run)
        error = f"{abs(kept(run, times) - true).max():.1e}" if times.size else ""
        walls = channel_flow(run).problem.space.count
        rows.append(
            (name, f"{value}", f"{walls}", f"{run.last.droplet.shape.basis.count}",
             f"{run.deformation[-1]:.5f}", f"{run.deformation[-1] - first.deformation[-1]:+.1e}",
             error, f"{run.last.evaluations}", f"{run.seconds:.0f}")
        )  # fmt: skip
    head = ("changed", "to", "plate points", "droplet points", f"D({first.last.time:g})",
            "difference", "largest error", "evaluations", "CPU s")  # fmt: skip
    print("\n" + text_table(head, rows))
