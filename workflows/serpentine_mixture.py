"""Droplets and rigid particles together in a serpentine channel that is read from a STEP file.

They start in the mid-plane z = 0 and go through the first U-turn; --end 20 lets all of them leave.
"""

from pathlib import Path

import cadbem as cb
from cadbem.suspension.time.history import plane_angle

GEOMETRY = Path(__file__).parents[1] / "geometries" / "serpentine.step"
STARTS = [(3.2, 0.12, 0.0), (2.5, -0.12, 0.0), (1.8, 0.18, 0.0), (1.1, -0.2, 0.0)]  # mm


def main(
    output: str = "results/serpentine_mixture", droplet_radius: float = 0.2,
    sphere_radius: float = 0.18, ellipsoid_length: float = 0.44, mean_velocity: float = 1.0,
    viscosity: float = 1.0, tension: float = 5.0, viscosity_ratio: float = 1.0,
    element_size: float = 0.7, points: int = 72, particle_spans: int = 2, tolerance: float = 1e-2,
    end: float = 2.2, every: float = 0.1, resume: bool = False,
) -> cb.History:  # fmt: skip
    """Droplets 1 and 2, the sphere 3, and the ellipsoid of revolution 4, twice as long as wide.

    droplet_radius: of both droplets (mm); sphere_radius: of the sphere (mm)
    ellipsoid_length: its long axis (mm); mean_velocity: at the inlet (mm/s)
    viscosity: of the fluid (Pa s); viscosity_ratio: of droplets over that of the fluid
    tension: of the droplets' interfaces (mN/m)
    element_size: longest elements of the channel (mm); points: on each droplet
    particle_spans: elements a direction on each of a particle's six patches
    tolerance: error of a time step, as a share of a body's size
    end: of the run (s); every: time between states that are kept (s)
    """
    folder = cb.run_folder(output, GEOMETRY, resume=resume)
    channel = cb.read_cad(GEOMETRY).elevated(2).refined(size=element_size)
    inlet = cb.Inflow(mean_velocity=mean_velocity)
    conditions = {"inlet": inlet, "outlet": cb.Pressure(0.0), "walls": cb.NoSlip()}
    flow = cb.ChannelFlow(cb.StokesProblem(channel, viscosity, conditions, cb.Quadrature(1e-4)))
    print(f"{flow.problem.space.count} points, net flux / inflow {flow.empty.net_flux():.1e}")
    print(f"Ca = {viscosity * mean_velocity / tension:g}")
    shapes = [cb.spline_sphere(droplet_radius, centre, points) for centre in STARTS[:2]]
    bodies = [cb.Droplet(s, cb.SurfaceTension(tension), viscosity_ratio) for s in shapes]
    axes = (ellipsoid_length / 2, ellipsoid_length / 4, ellipsoid_length / 4)
    bodies.append(cb.rigid_sphere(sphere_radius, STARTS[2], spans=particle_spans))
    bodies.append(cb.rigid_ellipsoid(axes, STARTS[3], spans=particle_spans))
    simulation = cb.Simulation(flow, bodies, stepper=cb.Adaptive(tolerance))
    run = cb.record(folder.run(simulation, end, every))
    print(cb.bodies_report(run, cb.Units("mm")))
    angles = plane_angle(run.turn(4)[:, 0], period=180.0), run.course(4).heading
    turned, bent = (angle[-1] - angle[0] for angle in angles)
    off = max(abs(run.track(number)[1][2]).max() for number in run.numbers)
    print(f"the ellipsoid has turned by {turned:.0f} degrees, its path by {bent:.0f}; "
          f"largest |z| {off:.1e}")  # fmt: skip
    largest = max(run.course(number).deformation.max() for number in (1, 2))
    folder.summary({"largest D": largest, "turn of the ellipsoid (degrees)": turned})
    cb.draw_run(folder, run, units=cb.Units("mm"))
    return run


if __name__ == "__main__":
    cb.run(main)
