"""Where droplets of several sizes and starts end up in a T-junction with two outlets.

Fluid enters the stem and leaves through both arms.  A droplet near the surface that divides the
flow is driven against the wall opposite the stem; a short-range pressure keeps it off.
"""

from pathlib import Path

import numpy as np

import cadbem as cb

GEOMETRY = Path(__file__).parents[1] / "geometries" / "t_junction.step"


def main(
    output: str = "results/droplet_sorting", viscosity: str = "10 mPa s",
    flow_rate: str = "60 uL/min", share: float = 0.65, tension: str = "0.1 mN/m",
    radii: str = "100 220 um", starts: str = "-200 -130 -50 um", accuracy: float = 1e-2,
    points: int = 50, tolerance: float = 5e-2, every: float = 0.1, end: str = "20 s",
) -> list[cb.Fate]:  # fmt: skip
    """Every size from every start, 1.2 mm before the middle of the junction.

    viscosity: of all fluid, with any units; tension: of interfaces, with any units
    flow_rate: of what enters, with any units; share: of the flow, to the right
    radii: of the droplets, with a unit; starts: how far off the axis they start, with a unit
    accuracy: relative error of the flow without droplets; points: on each droplet
    tolerance: error of a time step, as a share of a droplet's size
    every: time between points of a path (s); end: time limit of a droplet, with any unit
    """
    folder = cb.run_folder(output, GEOMETRY)
    junction = cb.read_cad(GEOMETRY).named(stem="inlet_b", left="inlet_a", right="outlet")
    u = cb.Units.of(junction)
    rate, sizes, law = u(flow_rate), u.several(radii), cb.SurfaceTension(u(tension))
    conditions = {"stem": cb.Inflow(flow_rate=rate), "right": cb.Inflow(flow_rate=-share * rate)}
    conditions |= {"left": cb.Pressure(0.0), "walls": cb.NoSlip()}
    empty = cb.StokesProblem(junction, u(viscosity), conditions).solve(accuracy)
    flow = cb.ChannelFlow(empty.problem)
    mean = rate / 1.0  # mm/s: the channels are 1 mm wide and high
    what = cb.numbers(viscosity=u(viscosity), velocity=mean, length=1.0, tension=u(tension))
    print(f"{flow.problem.space.count} points, mean velocity {u.show(mean, 'velocity')}, "
          f"Ca = {what.capillary:.3g}")  # fmt: skip
    places = [(x, -1.2, 0.0) for x in u.several(starts)]
    shapes = [cb.spline_sphere(size, place, points) for size in sizes for place in places]
    droplets = [cb.Droplet(shape, law) for shape in shapes]
    contact = cb.Repel(u("20 um"), 20 * u(tension) / min(sizes))
    simulation = cb.Simulation(flow, droplets[0], stepper=cb.Adaptive(tolerance), contact=contact)
    fates = cb.droplet_fates(simulation, droplets, u(end), every)
    tracers = cb.trace(flow.empty, np.array(places).T).openings * len(sizes)
    print(cb.fates_report(fates, u, tracers))
    right = [fate.opening for fate in fates].count("right")
    folder.summary({"left through the right arm": right, "of droplets": len(fates)})
    if folder:
        tracks = {f"{u.show(f.radius, 'length')}, x = {f.path[0, 0]:+.2f}": f.path for f in fates}
        cb.draw_trajectories(folder / "paths.png", junction, tracks)
    return fates


if __name__ == "__main__":
    cb.run(main)
