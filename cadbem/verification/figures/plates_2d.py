"""A plane droplet between moving plates (thesis Fig. 3.4)."""

from __future__ import annotations

from typing import Any

import numpy as np

from cadbem.files import Folder
from cadbem.post import draw_outlines, draw_run, draw_trajectories
from cadbem.post.style.plots import Curve, Plot, draw_plots
from cadbem.spline.basis import Array
from cadbem.suspension.multibody.contact import narrowest
from cadbem.suspension.multibody.measures import inclination
from cadbem.suspension.surroundings.channel_flow import ChannelFlow
from cadbem.suspension.time.history import History
from cadbem.suspension.time.state import State
from cadbem.suspension.time.stepping import Adaptive
from cadbem.suspension.time.thesis_methods import thesis_methods
from cadbem.tables import text_table
from cadbem.verification.figures.common import (
    Runs,
    Simulate,
    channel,
    channel_flow,
    note_pictures,
    report_stopped,
)
from cadbem.verification.plates import between_plane_plates
from cadbem.verification.theory import far_plates


def flux_across(state: State, x: float) -> float:
    """∫ u dy across the channel, which shear flow and droplets do not change from 0, over what the
    shear carries to either side, W² / 2."""
    assert isinstance(state.flow, ChannelFlow)
    half_width = state.flow.problem.boundary.bounds()[1, 1]
    nodes, weights = np.polynomial.legendre.leggauss(120)
    points = np.stack([np.full(120, x), half_width * nodes])
    return float(state.velocity_at(points)[0] @ weights) * 2 / half_width


def tell_widths(
    folder: Folder, runs: dict[float, History], ratio: float
) -> dict[float, History]:
    """Report and pictures of D(τ) for several widths; the same runs."""
    report_widths(runs, ratio)
    if folder:
        draw_widths(folder, runs, ratio)
        note_pictures(folder)
    return runs


def drift_runs(simulate: Simulate, folder: Folder) -> dict[float, History]:
    """Droplets that start off the middle, with a report and a picture."""
    flow = between_plane_plates(2.0)
    runs = {y: simulate(flow, centre=(-4.0, y)) for y in (0.25, 0.5, 0.75)}
    report_drift(runs)
    if folder:
        draw_drift(folder, runs)
        note_pictures(folder)
    return runs


def resolution_runs(simulate: Simulate, width: float, points: int, end: float) -> Runs:
    """Runs that differ from the first in one thing each, with a report."""

    def run(flow: dict | None = None, count: int = points, **options: Any) -> History:
        channel = between_plane_plates(width, **(flow or {}))
        return simulate(channel, points=count, end=end, **options)

    first = {("as above", ""): run()}
    counts = {("droplet points", n): run(count=n) for n in (16, 24, 32, 2 * points)}
    lengths = {("channel length / W", n): run({"length": n}) for n in (4, 6, 20)}
    finer = {("elements a half width", n): run({"parts": n}) for n in (1, 2, 4, 16)}
    steps = {("tolerance of steps", t): run(stepper=Adaptive(t)) for t in (1e-3, 1e-5)}
    runs: Runs = first | counts | lengths | finer | steps
    report_resolution(runs, points)
    return runs


def thesis_runs(simulate: Simulate, widths: list[float]) -> dict[float, History]:
    """The thesis's methods and numbers of points, with a report."""
    way = {"degree": 2, **thesis_methods()}
    runs = {w: simulate(between_plane_plates(w, parts=7), points=20, **way) for w in widths}
    report_thesis(runs)
    return runs


def report_widths(runs: dict[float, History], ratio: float) -> None:
    free, theory = runs[np.inf].deformation[-1], far_plates(ratio)
    rows = []
    for width, run in runs.items():
        state = run.last
        excess = (run.deformation[-1] / free - 1) * width**2 if width < np.inf else None
        gap = narrowest(state.flow, state.placed, (1,), everywhere=True)[0].length
        flux = "" if excess is None else f"{abs(flux_across(state, 0.7)):.0e}"
        rows.append(
            (f"{width:g}", f"{run.deformation.max():.5f}", f"{run.deformation[-1]:.5f}",
             f"{inclination(state.droplet.shape):.2f}", f"{gap:.3f}",
             "" if excess is None else f"{excess:.4f}", flux,
             f"{abs(run.volume / run.volume[0] - 1).max():.0e}", f"{run.seconds:.1f}")
        )  # fmt: skip
    head = ("W", "largest D", f"D({state.time:g})", "inclination (deg)", "gap to plates",
            "(D / D free - 1) W²", "net flux", "change of area", "CPU s")  # fmt: skip
    print(text_table(head, rows))
    print(f"plates far away: (D / D free - 1) W² = {theory:.4f} for small Ca")


def draw_widths(folder: Folder, runs: dict[float, History], ratio: float) -> None:
    """D over τ, its final values over W, shapes, and the narrowest width in motion."""
    curves = []
    for k, (width, run) in enumerate(runs.items()):
        label = f"W = {width:g}" if width < np.inf else "unbounded"
        look: dict[str, Any] = {"dashed": True} if width == np.inf else {"colour": k}
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
    draw_outlines(folder / "shapes.png", shapes)
    draw_run(folder, runs[bounded[0]], ("movie.gif", "filmstrip.png"))


def report_resolution(runs: Runs, points: int) -> None:
    (first, *_), rows = runs.values(), []
    last = first.deformation[-1]
    for (changed, value), run in runs.items():
        walls = channel_flow(run).problem.space.count
        rows.append(
            (changed, f"{value}", f"{walls}", f"{run.deformation[-1]:.5f}",
             f"{run.deformation[-1] - last:+.1e}", f"{run.last.evaluations}",
             f"{run.seconds:.1f}")
        )  # fmt: skip
    head = ("changed", "to", "wall points", f"D({first.last.time:g})", "difference",
            "evaluations", "CPU s")  # fmt: skip
    width = channel(first).bounds()[1, 1]
    print(f"\nW = {width:g}, {points} points, length 10 W, 8 elements a half width, steps to 1e-4")
    print(text_table(head, rows))


def report_thesis(runs: dict[float, History]) -> None:
    rows = [
        (f"{w:g}", f"{run.deformation.max():.5f}", f"{run.deformation[-1]:.5f}",
         f"{run.last.time:g}", f"{run.seconds:.1f}")
        for w, run in runs.items()
    ]  # fmt: skip
    print("\nthe thesis's way: 20 points of degree 2, 176 on the channel, steps of 0.01")
    print(text_table(("W", "largest D", "last D", "at", "CPU s"), rows))
    report_stopped({f"W = {width:g}": run for width, run in runs.items()})


def report_drift(runs: dict[float, History]) -> None:
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
    print(text_table(head, rows))


def draw_drift(folder: Folder, runs: dict[float, History]) -> None:
    (first, *_) = runs.values()
    tracks: dict[str | int, Array] = {
        f"from y = {start:g}": run.track()[1] for start, run in runs.items()
    }
    draw_trajectories(folder / "trajectories.png", channel(first), tracks)
