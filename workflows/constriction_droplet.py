"""A droplet squeezes through a smooth constriction that is read from a STEP file.

The side walls of the channel, which is 1 mm high, go from 2 mm apart to 0.8 mm and back.  Gaps are
0.7 to 1.6 times the distance of the droplet's points, and the extra pressure drop, small beside the
355 Pa of the empty channel, scatters by about 3 Pa in the throat.
"""

from pathlib import Path

import cadbem as cb

GEOMETRY = Path(__file__).parents[1] / "geometries" / "constriction.step"


def empty_channel(size: float, viscosity: float, mean_velocity: float) -> cb.ChannelFlow:
    channel = cb.read_cad(GEOMETRY).elevated(2).refined(size=size)
    inlet = cb.Inflow(mean_velocity=mean_velocity)
    conditions = {"inlet": inlet, "outlet": cb.Pressure(0.0), "walls": cb.NoSlip()}
    flow = cb.ChannelFlow(cb.StokesProblem(channel, viscosity, conditions, cb.Quadrature(1e-4)))
    drop = flow.empty.mean_pressure("inlet") - flow.empty.mean_pressure("outlet")
    print(f"{flow.problem.space.count} points, net flux / inflow {flow.empty.net_flux():.1e}, "
          f"pressure drop of the empty channel {drop:.2f} Pa")  # fmt: skip
    return flow


def main(
    output: str = "results/constriction_droplet", radius: float = 0.36, start: float = -2.5,
    mean_velocity: float = 1.0, viscosity: float = 1.0, tension: float = 20.0,
    viscosity_ratio: float = 1.0, element_size: float = 0.33, points: int = 200,
    tolerance: float = 1e-2, end: float = 10.0, every: float = 0.05, resume: bool = False,
) -> cb.History:  # fmt: skip
    """A round droplet on the centreline.

    radius: of the droplet (mm); start: x of its centre at first (mm)
    mean_velocity: at the inlet (mm/s)
    viscosity: of the outer fluid (Pa s); viscosity_ratio: inner over outer viscosity
    tension: of the interface (mN/m)
    element_size: longest elements of the channel (mm); points: on the droplet
    tolerance: error of a time step, as a share of the droplet's size
    end: of the run (s); every: time between states that are kept (s)
    """
    folder = cb.run_folder(output, GEOMETRY, resume=resume)
    flow = empty_channel(element_size, viscosity, mean_velocity)
    speed = mean_velocity * 2.0 / 0.8
    print(f"throat: mean velocity {speed:g} mm/s, Ca = {viscosity * speed / tension:g}")
    shape = cb.spline_sphere(radius, (start, 0.0, 0.0), points)
    droplet = cb.Droplet(shape, cb.SurfaceTension(tension), viscosity_ratio)
    simulation = cb.Simulation(flow, droplet, stepper=cb.Adaptive(tolerance))
    run = cb.record(folder.run(simulation, end, every))
    course, units = run.course(), cb.Units("mm")
    print(cb.course_report(run, units))
    found = {"largest D": course.deformation.max(), "narrowest gap (mm)": course.gap.min()}
    most = course.extra_drop().max()
    folder.summary(found | {"largest extra pressure (Pa)": most, "end (s)": run.last.time})
    cb.draw_run(folder, run, units=units)
    return run


if __name__ == "__main__":
    cb.run(main)
