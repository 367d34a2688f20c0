"""A droplet and, apart, a rigid particle carried through a Y-junction (thesis Fig. 4.9 to 4.11).

Radius 1, branches 4 wide and high, mean velocity 3 in both inlets, Ca = μ / γ = 0.05; both start
at (2.8284, 2, 2), 0.586 off the centreline of their branch towards its outer wall.  See
geometries/y_junction.py for the drawing, y_junction_flow.py for the flow without bodies.

The parts, as words of an option: 'droplet', 'particle', and 'table', both again on coarser and
finer channels and bodies.  At the bend the outer corner is in the particle's way, and fluid alone
would let it come nearer than a hundredth of its radius, which no such number of points resolves.  A
short-range pressure, 1000 (1 - gap / 0.1)², keeps it off (--strength; 0: the run ends there); the
walls' elements are graded towards that corner (--levels).  The droplet gives way and needs no such
rule.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np

import cadbem as cb
from cadbem.post.style.plots import Curve, Plot, draw_plots

GEOMETRY = Path(__file__).parents[1] / "geometries" / "y_junction.step"
AXIS = 5 * np.sqrt(2)  # y of the outlet's centreline
CORNER = np.array([7 * np.sqrt(2) - 2, AXIS - 2])  # where the outer wall bends
START = (2.8284, 2.0, 2.0)
REACH = 0.1  # of the pressure that keeps the particle off the walls
Keep = Callable[[cb.Simulation, float, float], Iterator[cb.State]]
STATIONS = (4.0, 6.0, 9.0, 12.0)  # x at which paths are compared


@dataclass(frozen=True)
class Resolution:
    """Elements a direction on each of the channel's faces, levels of grading, points on the
    droplet, elements on each of the particle's six patches."""

    spans: int = 7
    levels: int = 0
    points: int = 200
    particle_spans: int = 4


def junction(resolution: Resolution) -> cb.ChannelFlow:
    channel = cb.read_cad(GEOMETRY).elevated(2).refined(resolution.spans)
    if resolution.levels:
        channel = channel.graded(
            resolution.levels, 0.4, toward=lambda x, _: np.hypot(*(x[:2] - CORNER)) < 0.1
        )
    conditions = {
        "inlet_a": cb.Inflow(mean_velocity=3.0),
        "inlet_b": cb.Inflow(mean_velocity=3.0),
        "outlet": cb.Pressure(0.0),
        "walls": cb.NoSlip(),
    }
    return cb.ChannelFlow(cb.StokesProblem(channel, 1.0, conditions, cb.Quadrature(1e-6)))


def simulate(
    keep: Keep,
    kind: str,
    resolution: Resolution,
    capillary: float,
    strength: float,
    tolerance: float,
    end: float,
) -> cb.History:
    """One body through the junction, with a state every 0.05."""
    body: cb.Droplet | cb.RigidParticle
    if kind == "droplet":
        shape = cb.spline_sphere(centre=START, points=resolution.points)
        body = cb.Droplet(shape, cb.SurfaceTension(1 / capillary))
    else:
        body = cb.rigid_sphere(1.0, START, spans=resolution.particle_spans)
    repelled = kind == "particle" and strength > 0
    contact = cb.Repel(REACH, strength) if repelled else cb.StopAtGap(0.1)
    simulation = cb.Simulation(
        junction(resolution), body, stepper=cb.Adaptive(tolerance), contact=contact
    )
    return cb.record(keep(simulation, end, min(0.05, end)))


def main(
    output: str = "results/y_junction_bodies",
    spans: int = 7,
    levels: int = 3,
    points: int = 200,
    particle_spans: int = 4,
    capillary: float = 0.05,
    strength: float = 1000.0,
    tolerance: float = 1e-3,
    end: float = 2.0,
    parts: str = "droplet particle",
    resume: bool = False,
) -> dict[tuple, cb.History]:
    folder = cb.run_folder(output, GEOMETRY, resume=resume)
    resolution = Resolution(spans, levels, points, particle_spans)
    kinds = [kind for kind in ("droplet", "particle") if kind in parts]
    case = capillary, strength, tolerance, end
    keep = {kind: partial(folder.run, part=kind) for kind in kinds}
    runs = {(k, resolution): simulate(keep[k], k, resolution, *case) for k in kinds}
    if "table" in parts:
        finer = [
            Resolution(spans - 2, levels, 128, particle_spans - 1),
            Resolution(spans, 0, points, particle_spans),
            Resolution(spans + 2, levels + 1, 288, particle_spans + 1),
        ]
        runs |= {(k, r): simulate(cb.Simulation.run, k, r, *case) for r in finer for k in kinds}
    report(runs)
    last = {kind: runs[kind, resolution].track()[1] for kind in kinds}
    folder.summary({f"{kind}, last distance": off_centre(last[kind])[-1] for kind in kinds})
    if folder and kinds:
        draw(folder, {k: runs[k, resolution] for k in kinds})
        print(f"pictures and ParaView files are in {folder}")
    return runs


def off_centre(centres: np.ndarray) -> np.ndarray:
    """Distance (N,) from the centreline: of branch A, or of the outlet."""
    x, y, _ = centres
    return np.where(x < CORNER[0] - 1, (x - y) / np.sqrt(2), AXIS - y)


def report(runs: dict[tuple, cb.History]) -> None:
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
            kind, f"{last.flow.problem.space.count}", f"{size}",
            *(f"{c:.4f}" if b else "-" for c, b in zip(crossings, beyond, strict=True)),
            f"{gap:.3f}", f"{last.time:.3f}", f"{abs(centres[2] - 2).max():.1e}",
            f"{max(fluxes):.1e}", f"{last.evaluations}", f"{run.seconds:.0f}",
        ])  # fmt: skip
    head = ["body", "channel points", "points", *(f"x = {x:g}" for x in STATIONS),
            "smallest gap", "end", "|z - 2|", "net flux", "evaluations", "CPU s"]  # fmt: skip
    print("distance from the centreline of the branch at some x; when the run ended")
    print(cb.text_table(head, rows))
    for (kind, _), run in runs.items():
        if run.last.stopped:
            print(f"{kind}: {run.last.stopped}")


def draw(folder: cb.RunFolder, runs: dict[str, cb.History]) -> None:
    channel = cb.read_cad(GEOMETRY)
    tracks = {kind: run.track()[1] for kind, run in runs.items()}
    cb.draw_trajectories(folder / "paths.png", channel, tracks)
    curves = [
        Curve(t[0], off_centre(t), k, colour=i) for i, (k, t) in enumerate(tracks.items())
    ]
    draw_plots(
        folder / "distance.png",
        [Plot("x of the centre", "distance from the centreline", curves)],
    )
    cb.render(folder)
    if "droplet" in runs:
        cb.draw_droplets(folder / "final_shape.png", [runs["droplet"].last.droplet.shape])


if __name__ == "__main__":
    cb.run(main)
