"""A train of droplets through a flow-focusing cross that is read from a STEP file.

Oil, by default viscous silicone oil, carries droplets from 'inlet'; oil from both sides squeezes
the train through the orifice; the run ends when the last has left at 'outlet'.  In the throat, gaps
to the walls are as narrow as the droplets' points are apart.
"""

from pathlib import Path

import numpy as np

import cadbem as cb

GEOMETRY = Path(__file__).parents[1] / "geometries" / "flow_focusing.step"


def main(
    output: str = "results/droplet_train", droplets: int = 3, radius: float = 0.2,
    front: float = -1.0, distance: float = 0.75, flow_rate: float = 1.0,
    side_flow_rate: float = 0.5, viscosity: float = 1.0, tension: float = 10.0,
    viscosity_ratio: float = 1.0, element_size: float = 0.5, throat_size: float = 0.5,
    points: int = 98, tolerance: float = 1e-2, end: float = 10.0, every: float = 0.05,
    resume: bool = False,
) -> cb.History:  # fmt: skip
    """Round droplets on the centreline, the first in front, the others behind it.

    droplets: how many; radius: of each droplet (mm); points: on each droplet
    front: x of the first centre (mm); distance: between centres (mm)
    flow_rate: into 'inlet' (mm³/s = µL/s); side_flow_rate: into each side (mm³/s)
    viscosity: of the oil (Pa s); viscosity_ratio: of droplets over that of the oil
    tension: of the interfaces (mN/m)
    element_size: longest elements of the channel (mm); throat_size: those in the throat (mm)
    tolerance: error of a time step, as a share of a droplet's size
    end: of the run (s); every: time between states that are kept (s)
    """
    folder = cb.run_folder(output, GEOMETRY, resume=resume)
    rates = {"inlet": flow_rate, "side_a": side_flow_rate, "side_b": side_flow_rate}
    conditions = {name: cb.Inflow(flow_rate=rate) for name, rate in rates.items()}
    conditions |= {"outlet": cb.Pressure(0.0), "walls": cb.NoSlip()}
    channel = cb.read_cad(GEOMETRY).elevated(2).refined(
        size=lambda x: np.where((x[0] > 0.6) & (x[0] < 2.1), throat_size, element_size)
    )
    flow = cb.ChannelFlow(cb.StokesProblem(channel, viscosity, conditions, cb.Quadrature(1e-4)))
    print(f"{flow.problem.space.count} points, net flux / inflow {flow.empty.net_flux():.1e}")
    speed = sum(rates.values()) / 0.5
    print(f"throat: mean velocity {speed:g} mm/s, Ca = {viscosity * speed / tension:g}")
    centres = [(front - k * distance, 0.0, 0.0) for k in range(droplets)]
    shapes = [cb.spline_sphere(radius, centre, points) for centre in centres]
    train = [cb.Droplet(s, cb.SurfaceTension(tension), viscosity_ratio) for s in shapes]
    simulation = cb.Simulation(flow, train, stepper=cb.Adaptive(tolerance))
    run = cb.record(folder.run(simulation, end, every))
    print(cb.bodies_report(run, cb.Units("mm")))
    found = [run.course(number).deformation.max() for number in run.numbers]
    folder.summary({"largest D": max(found), "end (s)": run.last.time})
    cb.draw_run(folder, run, units=cb.Units("mm"))
    return run


if __name__ == "__main__":
    cb.run(main)
