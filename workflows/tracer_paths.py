"""Passive tracers through a T-junction: where they go, and how long they stay.

Two streams enter geometries/t_junction.py, the main one at 'inlet_a', the other at 'inlet_b', and
leave through 'outlet'.  Tracers start all over both inlets, each for its part of the flow.  Over
all that enters, the mean residence time is the volume over the flow rate.
"""

from pathlib import Path

import numpy as np

import cadbem as cb
from cadbem.post.style.plots import Curve, Plot, draw_plots

GEOMETRY = Path(__file__).parents[1] / "geometries" / "t_junction.step"


def main(
    output: str = "results/tracer_paths", viscosity: str = "1 mPa s", main_rate: str = "40 uL/min",
    side_rate: str = "20 uL/min", accuracy: float = 1e-2, tracers: int = 36, paths: int = 5,
) -> dict[str, cb.Tracers]:  # fmt: skip
    """Elements get finer by themselves towards the two edges that the flow goes around.

    viscosity: of the fluid, with any units
    main_rate: into 'inlet_a', with any units; side_rate: into 'inlet_b', with any units
    accuracy: relative error of the flow that you accept, such as 1e-3
    tracers: from either inlet; paths: from either inlet to be drawn
    """
    folder = cb.run_folder(output, GEOMETRY)
    channel = cb.read_cad(GEOMETRY)
    u = cb.Units.of(channel)
    rates = {"inlet_a": u(main_rate), "inlet_b": u(side_rate)}
    conditions = {name: cb.Inflow(flow_rate=rate) for name, rate in rates.items()}
    conditions |= {"outlet": cb.Pressure(0.0), "walls": cb.NoSlip()}
    solution = cb.StokesProblem(channel, u(viscosity), conditions).solve(accuracy)
    found = {n: cb.trace(solution, cb.inlet_points(solution, n, count=tracers)) for n in rates}
    print(cb.residence_report(found, u))
    whole = sum(g.mean_time * g.flow_rates.sum() for g in found.values()) / sum(rates.values())
    exact = channel.volume() / sum(rates.values())
    print(f"mean of all {u.show(whole, 'time')}, volume / flow rate {u.show(exact, 'time')}")
    folder.summary({"mean residence time (s)": whole, "volume / flow rate (s)": exact})
    if folder:
        x, far = np.linspace(-0.45, 0.45, paths), np.full(paths, -3.0)
        shown = cb.trace(solution, np.hstack([[far, x, 0 * x], [x, far, 0 * x]]))
        look = {"values": shown.moments, "label": "time", "units": u}
        cb.draw_paths(folder / "paths.png", channel, shown.paths, **look)
        known = [(name, np.array(group.distribution)) for name, group in found.items()]
        curves = [Curve(*d[:, d[0] < 5 * exact], n, colour=k) for k, (n, d) in enumerate(known)]
        plot = Plot("time (s)", "share of the stream that has left", curves)
        draw_plots(folder / "residence_times.png", [plot])
    return found


if __name__ == "__main__":
    cb.run(main)
