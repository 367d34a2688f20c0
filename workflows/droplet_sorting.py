"""Where droplets of several sizes and starts end up in a T-junction with two outlets.

Fluid enters the stem of geometries/t_junction.py and leaves through both arms, more of it to the
right than to the left.  A point of fluid goes left or right of a dividing
surface; a droplet is no point: it feels the flow all over its surface and the walls.  Droplets of
the outer fluid's viscosity start in the stem at several distances from its axis, each alone.

Prints through which opening each droplet left and when, its largest Taylor deformation D and the
narrowest gap that it had, where that was narrow; the last column says where a tracer of the same
start goes.  Near the dividing surface droplets are driven against the wall opposite the stem; a
short-range pressure, from 20 um on, keeps them off it, for so few points do not resolve the film.
Draws the paths.
"""

from pathlib import Path

import numpy as np

import cadbem as cb

GEOMETRY = Path(__file__).parents[1] / "geometries" / "t_junction.step"


def main(
    output: str = "results/droplet_sorting",
    viscosity: str = "10 mPa s",
    flow_rate: str = "60 uL/min",
    share: float = 0.65,
    tension: str = "0.1 mN/m",
    radii: str = "100 220 um",
    starts: str = "-200 -130 -50 um",
    element_size: float = 0.5,
    points: int = 50,
    tolerance: float = 5e-2,
    every: float = 0.1,
    end: str = "20 s",
) -> list[cb.Fate]:
    folder = cb.run_folder(output, GEOMETRY)

    junction = cb.read_cad(GEOMETRY).named(stem="inlet_b", left="inlet_a", right="outlet")
    channel = junction.elevated(2).refined(size=element_size)
    u = cb.Units.of(channel)
    rate = u(flow_rate)
    flow = divided(channel, u(viscosity), rate, share)
    mean = rate / 1.0  # mm/s: the channels are 1 mm wide and high
    what = cb.numbers(viscosity=u(viscosity), velocity=mean, length=1.0, tension=u(tension))
    print(f"{flow.problem.space.count} points, mean velocity {u.show(mean, 'velocity')}, "
          f"Ca = {what.capillary:.3g}")  # fmt: skip

    # Droplets: every size from every start, at y = -1.2 mm
    places = [(x, -1.2, 0.0) for x in lengths(u, starts)]
    law, sizes = cb.SurfaceTension(u(tension)), lengths(u, radii)
    shapes = [cb.spline_sphere(radius, place, points) for radius in sizes for place in places]
    droplets = [cb.Droplet(shape, law) for shape in shapes]
    contact = cb.Repel(u("20 um"), 20 * u(tension) / min(sizes))
    simulation = cb.Simulation(flow, droplets[0], stepper=cb.Adaptive(tolerance), contact=contact)
    fates = cb.droplet_fates(simulation, droplets, u(end), every)
    tracers = cb.trace(flow.empty, np.array(places).T)
    report(u, fates, tracers)
    right = sum(fate.opening == "right" for fate in fates)
    folder.summary({"left through the right arm": right, "of droplets": len(fates)})
    if folder:
        draw(folder, u, channel, fates)
    return fates


def divided(
    channel: cb.Boundary, viscosity: float, rate: float, share: float
) -> cb.ChannelFlow:
    """The flow in through the stem, a share of it out to the right."""
    conditions = {
        "stem": cb.Inflow(flow_rate=rate),
        "right": cb.Inflow(flow_rate=-share * rate),
        "left": cb.Pressure(0.0),
        "walls": cb.NoSlip(),
    }
    return cb.ChannelFlow(cb.StokesProblem(channel, viscosity, conditions, cb.Quadrature(1e-4)))


def lengths(u: cb.Units, text: str) -> list[float]:
    """Several lengths, as in '100 200 um'."""
    *values, unit = text.split()
    return [u(f"{value} {unit}") for value in values]


def label(u: cb.Units, fate: cb.Fate) -> str:
    """The droplet's radius, from its volume."""
    return u.show((3 * fate.droplet.volume / (4 * np.pi)) ** (1 / 3), "length")


def draw(folder: cb.RunFolder, u: cb.Units, channel: cb.Boundary, fates: list[cb.Fate]) -> None:
    """The paths of all droplets."""
    tracks = {f"{label(u, f)}, x = {f.path[0, 0]:+.2f}": f.path for f in fates}
    cb.draw_trajectories(folder / "paths.png", channel, tracks)
    print(f"a picture is in {folder}")


def report(u: cb.Units, fates: list[cb.Fate], tracers: cb.Tracers) -> None:
    rows = []
    for k, fate in enumerate(fates):
        gap = u.show(fate.gap, "length") if np.isfinite(fate.gap) else "-"
        rows.append([
            label(u, fate), f"{fate.path[0, 0]:+.3f} mm", fate.opening or "none",
            u.show(fate.time, "time"), f"{fate.deformation:.3f}", gap,
            tracers.openings[k % len(tracers.openings)] or "-",
        ])  # fmt: skip
    head = ("droplet", "off the axis", "left through", "after", "largest D", "gap", "a tracer")
    print(cb.text_table(head, rows))
    for fate in fates:
        if not fate.opening:
            print(f"{label(u, fate)} from {fate.path[0, 0]:+.3f} mm: {fate.ended}")


if __name__ == "__main__":
    cb.run(main)
