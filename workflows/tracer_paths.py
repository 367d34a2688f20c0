"""Passive tracers through a T-junction: where they go, and how long they stay.

Two streams enter geometries/t_junction.py, the main one at 'inlet_a', the other at the side
('inlet_b'), and leave through 'outlet'.  Tracers start all over both inlets, each for its part of
the flow, and are followed until they leave.  Prints how long those of each stream stay; over
everything that enters, the mean residence time is the volume over the flow rate.  Draws some paths
in mid-height, and the distribution of residence times.
"""

from pathlib import Path

import numpy as np

import cadbem as cb
from cadbem.post.style.plots import Curve, Plot, draw_plots

GEOMETRY = Path(__file__).parents[1] / "geometries" / "t_junction.step"


def main(
    output: str = "results/tracer_paths",
    viscosity: str = "1 mPa s",
    main_rate: str = "40 uL/min",
    side_rate: str = "20 uL/min",
    element_size: float = 0.4,
    levels: int = 3,
    tracers: int = 36,
    paths: int = 5,
) -> dict[str, cb.Tracers]:
    folder = cb.run_folder(output, GEOMETRY)

    # Geometry and flow
    channel = cb.read_cad(GEOMETRY).elevated(2).refined(size=element_size)
    # finer towards the two edges that the flow goes around
    channel = channel.graded(
        levels, 0.4, toward=lambda x, _: np.hypot(abs(x[0]) - 0.5, x[1] + 0.5) < 0.1
    )
    u = cb.Units.of(channel)
    rates = {"inlet_a": u(main_rate), "inlet_b": u(side_rate)}
    conditions = {name: cb.Inflow(flow_rate=rate) for name, rate in rates.items()}
    conditions |= {"outlet": cb.Pressure(0.0), "walls": cb.NoSlip()}
    rules = cb.Quadrature(1e-5)
    solution = cb.StokesProblem(channel, u(viscosity), conditions, rules).solve()

    # Tracers that stand for the flow of either inlet
    found = {n: cb.trace(solution, cb.inlet_points(solution, n, count=tracers)) for n in rates}
    report(u, found)
    whole = sum(g.mean_time * g.flow_rates.sum() for g in found.values()) / sum(rates.values())
    exact = channel.volume() / sum(rates.values())
    print(f"mean of all {u.show(whole, 'time')}, volume / flow rate {u.show(exact, 'time')}")
    folder.summary({"mean residence time (s)": whole, "volume / flow rate (s)": exact})

    if folder:
        draw(folder, u, solution, found, paths, exact)
        print(f"pictures are in {folder}")
    return found


def report(u: cb.Units, found: dict[str, cb.Tracers]) -> None:
    """Residence times of the tracers of each stream."""
    rows = []
    for name, group in found.items():
        times, shares = group.distribution
        middle = float(np.interp(0.5, shares, times))
        inside = group.shares.get("", 0.0)
        rows.append([name, f"{len(group.paths)}", u.show(times[0], "time"), u.show(middle, "time"),
                     u.show(group.mean_time, "time"), f"{inside:.2%}"])  # fmt: skip
    head = ("from", "tracers", "first", "median", "mean", "of the flow still inside")
    print(cb.text_table(head, rows))


def draw(
    folder: cb.RunFolder,
    u: cb.Units,
    solution: cb.StokesSolution,
    found: dict[str, cb.Tracers],
    paths: int,
    mean_time: float,
) -> None:
    """Some paths at mid-height, and the distribution of residence times."""
    across = np.linspace(-0.45, 0.45, paths)
    rows_of_starts = [np.stack([np.full(paths, -3.0), across, 0 * across]),
                      np.stack([across, np.full(paths, -3.0), 0 * across])]  # fmt: skip
    shown = cb.trace(solution, np.concatenate(rows_of_starts, axis=1))
    look = {"values": shown.moments, "label": "time", "units": u}
    cb.draw_paths(folder / "paths.png", solution.space.boundary, shown.paths, **look)
    curves = []
    for k, (name, group) in enumerate(found.items()):
        early = group.distribution[0] < 5 * mean_time
        curves.append(Curve(*(d[early] for d in group.distribution), name, colour=k))
    label = "share of the stream that has left"
    draw_plots(folder / "residence_times.png", [Plot("time (s)", label, curves)])


if __name__ == "__main__":
    cb.run(main)
