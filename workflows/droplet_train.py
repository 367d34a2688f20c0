"""A train of droplets through a flow-focusing cross that is read from a STEP file.

Oil of viscosity μ carries droplets from 'inlet'; oil from both sides, 'side_a' and 'side_b', joins
it and squeezes the train through the orifice (geometries/flow_focusing.py); the droplets leave at
'outlet' one after another, and the run ends with the last.

Units: mm, s, Pa s, Pa, hence mm³/s = µL/s for flow rates and mN/m = Pa mm for surface tension.  By
default it is a viscous silicone oil, 1 Pa s, at 1 µL/s and twice 0.5 µL/s, tension 10 mN/m.  Then
Ca = μ U / γ is 0.4 with the mean velocity U in the throat, 0.5 × 1 mm.  There, gaps to the walls
are as narrow as the droplets' points are apart; --throat-size makes the walls' elements smaller.

Prints what becomes of each droplet, and draws D(t), paths, a film strip and a movie into a folder.
"""

from dataclasses import replace
from pathlib import Path

import numpy as np

import cadbem as cb
from cadbem.post.style.plots import Curve, Plot, draw_plots

GEOMETRY = Path(__file__).parents[1] / "geometries" / "flow_focusing.step"
THROAT_AREA = 0.5  # mm²
THROAT_FACES = 0.6, 2.1  # mm: x between which the middles of its faces lie


def main(
    output: str = "results/droplet_train",
    droplets: int = 3,
    radius: float = 0.2,
    front: float = -1.0,
    distance: float = 0.75,
    flow_rate: float = 1.0,
    side_flow_rate: float = 0.5,
    viscosity: float = 1.0,
    tension: float = 10.0,
    viscosity_ratio: float = 1.0,
    element_size: float = 0.5,
    throat_size: float = 0.5,
    points: int = 98,
    tolerance: float = 1e-2,
    end: float = 10.0,
    every: float = 0.05,
    resume: bool = False,
) -> cb.History:
    folder = cb.run_folder(output, GEOMETRY, resume=resume)
    channel = finer_in_throat(element_size, throat_size)
    flow = branches(channel, viscosity, flow_rate, side_flow_rate)
    speed = (flow_rate + 2 * side_flow_rate) / THROAT_AREA
    print(f"throat: mean velocity {speed:g} mm/s, Ca = {viscosity * speed / tension:g}")

    # Round droplets on the centreline, the first at x = front, the others behind it
    places = [(front - k * distance, 0.0, 0.0) for k in range(droplets)]
    shapes = [cb.spline_sphere(radius, place, points) for place in places]
    train = [cb.Droplet(s, cb.SurfaceTension(tension), viscosity_ratio) for s in shapes]
    simulation = cb.Simulation(flow, train, stepper=cb.Adaptive(tolerance))
    run = cb.record(folder.run(simulation, end, every))

    report(run)
    found = [run.of(cb.taylor_deformation, n).max() for n in run.states[0].numbers]
    folder.summary({"largest D": max(found), "end (s)": run.last.time})
    if folder:
        draw(folder, channel, run)
        print(f"the pictures are in {folder}")
    return run


def finer_in_throat(element_size: float, throat_size: float) -> cb.Boundary:
    """The channel with smaller elements where droplets come near its walls."""
    # Geometry: 34 four-sided faces with the names that the CAD file gives them
    channel = cb.read_cad(GEOMETRY).elevated(2)
    coarse, fine = (channel.refined(size=size).patches for size in (element_size, throat_size))
    low, high = THROAT_FACES
    patches = [
        f if low < p.middle().position[0, 0] < high else c
        for p, c, f in zip(channel.patches, coarse, fine, strict=True)
    ]
    return replace(channel, patches=tuple(patches))


def branches(
    channel: cb.Boundary, viscosity: float, flow_rate: float, side_flow_rate: float
) -> cb.ChannelFlow:
    """The flow without droplets: three branches in, one out."""
    # Problem: developed inflow in three branches, pressure zero at the outlet
    side = cb.Inflow(flow_rate=side_flow_rate)
    conditions = {
        "inlet": cb.Inflow(flow_rate=flow_rate),
        "side_a": side,
        "side_b": side,
        "outlet": cb.Pressure(0.0),
        "walls": cb.NoSlip(),
    }
    problem = cb.StokesProblem(channel, viscosity, conditions, cb.Quadrature(1e-4))
    flow = cb.ChannelFlow(problem)
    print(f"{problem.space.count} points, net flux / inflow {flow.empty.net_flux():.1e}")
    return flow


def report(run: cb.History) -> None:
    """What became of each droplet: its largest D and where, its narrowest gap and where."""
    rows = []
    for number in run.states[0].numbers:
        times, centres = run.track(number)
        found = run.of(cb.taylor_deformation, number)
        most = int(found.argmax())
        gaps = [
            (gap.length, gap.other, s.time)
            for s in run.states
            for gap in s.gaps
            if gap.body == number
        ]
        length, other, moment = min(gaps)
        near = "-" if np.isinf(length) else f"{length:.3f} to {other} at {moment:.2f}"
        rows.append(
            (f"{number}", f"{found[most]:.3f}", f"{centres[0, most]:.2f}", f"{found[-1]:.3f}",
             near, run.last.left.get(number, f"still there at time {times[-1]:g}"))
        )  # fmt: skip
    head = ("droplet", "largest D", "at x (mm)", "last D", "narrowest gap (mm)", "fate")
    print(cb.text_table(head, rows))
    last = run.last
    print(f"{last.steps} steps, {last.evaluations} evaluations, {run.seconds:.0f} CPU s")
    if last.stopped:
        print(f"ended: {last.stopped}")


def draw(folder: cb.RunFolder, channel: cb.Boundary, run: cb.History) -> None:
    """D(t), D(x), the paths, a film strip and a movie."""
    tracks = {n: run.track(n) for n in run.states[0].numbers}
    over_time, over_way = [], []
    for n, (times, centres) in tracks.items():
        found, label = run.of(cb.taylor_deformation, n), f"droplet {n}"
        over_time.append(Curve(times, found, label, colour=n))
        over_way.append(Curve(centres[0], found, label, colour=n))
    draw_plots(
        folder / "deformation.png",
        [Plot("t (s)", "D", over_time), Plot("x of the centre (mm)", "D", over_way)],
    )
    cb.draw_trajectories(
        folder / "paths.png", channel, {n: centres for n, (_, centres) in tracks.items()}
    )
    frames = [cb.Frame(s.time, s.shapes) for s in run.states]
    cb.filmstrip(folder / "filmstrip.png", channel, frames)
    cb.draw_movie(folder / "movie.gif", channel, frames)


if __name__ == "__main__":
    cb.run(main)
