"""Two plane droplets that meet between moving plates (thesis Fig. 3.5)."""

from __future__ import annotations

from typing import Any

import numpy as np

from cadbem.files import Folder
from cadbem.operators.closed.nearest import signed_distance
from cadbem.post import draw_run, draw_trajectories
from cadbem.post.style.plots import Curve, Plot, draw_plots
from cadbem.spline.basis import Array
from cadbem.spline.closed import ClosedSpline
from cadbem.suspension.multibody.measures import taylor_deformation
from cadbem.suspension.surroundings.channel_flow import ChannelFlow
from cadbem.suspension.time.history import History
from cadbem.tables import text_table
from cadbem.verification.figures.common import Runs, Simulate, channel, report_stopped
from cadbem.verification.figures.plates_2d import flux_across


def gaps(run: History) -> tuple[np.ndarray, np.ndarray]:
    """The gap between the droplets, and the narrowest between one and a plate, at each time."""
    points = 8 * run.last.droplet.shape.basis.count
    around = np.linspace(0, 2 * np.pi, points, endpoint=False)[None]
    apart, heights = [], []
    for state in run.states:
        first, second = (droplet.shape for droplet in state.droplets)
        curves = first.evaluate(around), second.evaluate(around)
        apart.append(signed_distance(second, curves[0]).min())
        heights.append(max(abs(curve[1]).max() for curve in curves))
    bounded = isinstance(run.last.flow, ChannelFlow)
    half_width = channel(run).bounds()[1, 1] if bounded else np.inf
    return np.array(apart), half_width - np.array(heights)


def area_change(run: History) -> float:
    """Largest relative change of a droplet's area."""
    areas = np.array([[d.volume for d in state.droplets] for state in run.states])
    return float(abs(areas / areas[0] - 1).max())


def tell(folder: Folder, runs: Runs) -> dict[str, float]:
    """Report and pictures of runs between plates and in unbounded fluid; smallest gaps."""
    if runs:
        report(runs)
    if folder:
        for name in {key[0] for key in runs}:
            draw(folder / name, runs[name, "plates"], runs[name, "unbounded"])
    return {
        f"smallest gap, {name}, {place}": gaps(run)[0].min() for (name, place), run in runs.items()
    }


def convergence_runs(
    simulate: Simulate, points: int, tolerance: float, known: History | None
) -> dict[tuple[int, float], History]:
    """How the end depends on points and steps, with a report; ``known`` is the run that all
    others are compared with, if there is one."""
    choices = [(points * 3 // 4, tolerance), (points * 3 // 2, tolerance)]
    choices += [(points, tolerance * 10), (points, tolerance / 10)]
    runs = {} if known is None else {(points, tolerance): known}
    runs |= {choice: simulate(*choice) for choice in choices}
    report_convergence(runs)
    return runs


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
             f"{max(map(taylor_deformation, shapes_of(run))):.4f}", flux,
             f"{area_change(run):.0e}", f"{run.last.evaluations}", f"{run.seconds:.1f}")
        )  # fmt: skip
    head = ("start", "fluid", "y of droplet 1", "y of droplet 2", "smallest gap", "at τ",
            "largest D", "net flux", "change of area", "evaluations", "CPU s")  # fmt: skip
    print(text_table(head, rows))
    report_stopped({", ".join(key): run for key, run in runs.items()})


def shapes_of(run: History) -> list[ClosedSpline]:
    """All shapes at all times."""
    return [droplet.shape for state in run.states for droplet in state.droplets]


def report_convergence(runs: dict[tuple[int, float], History]) -> None:
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
    print(text_table(head, rows))


def draw(folder: Folder, bounded: History, free: History) -> None:
    """Movie, film strip, paths, deformation and gaps of one start."""
    draw_run(folder, bounded, ("movie.gif", "filmstrip.png"))
    runs = {"": bounded, ", unbounded": free}
    tracks: dict[str | int, Array] = {
        f"droplet {n}{where}": run.track(n)[1] for where, run in runs.items() for n in (1, 2)
    }
    draw_trajectories(folder / "trajectories.png", channel(bounded), tracks)
    deformation, distance = [], []
    for where, run in runs.items():
        for n in (1, 2):
            values = run.of(taylor_deformation, n)
            look: dict[str, Any] = {"colour": n, "dashed": bool(where)}
            deformation.append(Curve(run.times, values, f"droplet {n}{where}", **look))
        look = {"colour": 0, "dashed": bool(where)}
        distance.append(Curve(run.times, gaps(run)[0], f"between the droplets{where}", **look))
    distance.append(Curve(bounded.times, gaps(bounded)[1], "to a plate", colour=2))
    draw_plots(
        folder / "history.png",
        [Plot("τ", "D", deformation), Plot("τ", "narrowest gap", distance, decades=True)],
    )
