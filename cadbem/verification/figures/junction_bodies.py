"""A droplet and a rigid particle in a Y-junction (thesis Fig. 4.9 to 4.11)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cadbem.boundary import Boundary
from cadbem.files import Folder
from cadbem.post import draw_droplets, draw_trajectories
from cadbem.post.style.plots import Curve, Plot, draw_plots
from cadbem.problems.conditions import Condition, Inflow, NoSlip, Pressure
from cadbem.problems.stokes import StokesProblem
from cadbem.quadrature import Quadrature
from cadbem.spline.basis import Array
from cadbem.suspension.surroundings.channel_flow import ChannelFlow
from cadbem.suspension.time.history import History
from cadbem.tables import text_table
from cadbem.verification.figures.common import channel_flow, report_stopped

AXIS = 5 * np.sqrt(2)  # y of the outlet's centreline
CORNER = np.array([7 * np.sqrt(2) - 2, AXIS - 2])  # where the outer wall bends
STATIONS = (4.0, 6.0, 9.0, 12.0)  # x at which paths are compared


@dataclass(frozen=True)
class Resolution:
    """Elements a direction on each of the channel's faces, levels of grading, points on the
    droplet, elements on each of the particle's six patches."""

    spans: int = 7
    levels: int = 0
    points: int = 200
    particle_spans: int = 4


def finer(resolution: Resolution) -> list[Resolution]:
    """Others to compare with."""
    spans, levels, particle = resolution.spans, resolution.levels, resolution.particle_spans
    return [
        Resolution(spans - 2, levels, 128, particle - 1),
        Resolution(spans, 0, resolution.points, particle),
        Resolution(spans + 2, levels + 1, 288, particle + 1),
    ]


def junction_flow(channel: Boundary, resolution: Resolution) -> ChannelFlow:
    """The flow without bodies, of mean velocity 3 in both inlets, in a junction whose elements get
    smaller towards its outer corner."""
    channel = channel.elevated(2).refined(resolution.spans)
    if resolution.levels:
        channel = channel.graded(
            resolution.levels, 0.4, toward=lambda x, _: np.hypot(*(x[:2] - CORNER)) < 0.1
        )
    conditions: dict[str, Condition] = {
        "inlet_a": Inflow(mean_velocity=3.0),
        "inlet_b": Inflow(mean_velocity=3.0),
        "outlet": Pressure(0.0),
        "walls": NoSlip(),
    }
    return ChannelFlow(StokesProblem(channel, 1.0, conditions, Quadrature(1e-6)))


def off_centre(centres: np.ndarray) -> np.ndarray:
    """Distance (N,) from the centreline: of branch A, or of the outlet."""
    x, y, _ = centres
    return np.where(x < CORNER[0] - 1, (x - y) / np.sqrt(2), AXIS - y)


def report(runs: dict[tuple, History], resolution: Resolution) -> dict[str, float]:
    """A table of all runs; how far from the centreline those of one resolution are at last."""
    rows = []
    for (kind, r), run in runs.items():
        _, centres = run.track()
        beyond = [x < centres[0, -1] for x in STATIONS]
        crossings = np.interp(STATIONS, centres[0], off_centre(centres))
        last = run.last
        fluxes = [abs(state.walls.net_flux()) for state in run.states[::10]]
        gap = min(state.gaps[0].length for state in run.states)
        size = r.points if kind == "droplet" else last.responses[0].traction.space.count
        rows.append([
            kind, f"{channel_flow(run).problem.space.count}", f"{size}",
            *(f"{c:.4f}" if b else "-" for c, b in zip(crossings, beyond, strict=True)),
            f"{gap:.3f}", f"{last.time:.3f}", f"{abs(centres[2] - 2).max():.1e}",
            f"{max(fluxes):.1e}", f"{last.evaluations}", f"{run.seconds:.0f}",
        ])  # fmt: skip
    head = ["body", "channel points", "points", *(f"x = {x:g}" for x in STATIONS),
            "smallest gap", "end", "|z - 2|", "net flux", "evaluations", "CPU s"]  # fmt: skip
    print("distance from the centreline of the branch at some x; when the run ended")
    print(text_table(head, rows))
    report_stopped({kind: run for (kind, _), run in runs.items()})
    alone = {kind: run for (kind, r), run in runs.items() if r == resolution}
    return {f"{k}, last distance": off_centre(run.track()[1])[-1] for k, run in alone.items()}


def draw(
    folder: Folder, channel: Boundary, every: dict[tuple, History], resolution: Resolution
) -> None:
    """Paths, distances from the centreline, and the droplet's last shape, for one resolution."""
    runs = {kind: run for (kind, r), run in every.items() if r == resolution}
    tracks: dict[str | int, Array] = {kind: run.track()[1] for kind, run in runs.items()}
    draw_trajectories(folder / "paths.png", channel, tracks)
    curves = [
        Curve(t[0], off_centre(t), str(k), colour=i) for i, (k, t) in enumerate(tracks.items())
    ]
    draw_plots(
        folder / "distance.png",
        [Plot("x of the centre", "distance from the centreline", curves)],
    )
    if "droplet" in runs:
        draw_droplets(folder / "final_shape.png", [runs["droplet"].last.droplet.shape])
