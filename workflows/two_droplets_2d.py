"""Two plane droplets that meet between moving plates (thesis Fig. 3.5).

Plates as in droplet_between_plates_2d; Ca is twice the true one; each start in free fluid as well.
"""

from functools import partial

import cadbem as cb
from cadbem.suspension.interface.laws import thesis_tension_2d
from cadbem.verification.figures import pair_2d
from cadbem.verification.figures.common import Runs, labelled
from cadbem.verification.plates import between_plane_plates

# one droplet passes over the other, or the plates turn them back
STARTS = {"pass": ((0.0, 0.0), (-2.5, 1.0)), "swap": ((-1.25, 0.25), (1.25, -0.25))}


def simulate(
    flow: cb.ChannelFlow | cb.FreeFlow, starts: tuple, capillary: float, ratio: float,
    points: int, tolerance: float, end: float,
) -> cb.History:  # fmt: skip
    tension = thesis_tension_2d(capillary)
    shapes = [cb.spline_circle(points=points, centre=centre) for centre in starts]
    droplets = [cb.Droplet(shape, tension, ratio) for shape in shapes]
    simulation = cb.Simulation(flow, droplets, stepper=cb.Adaptive(tolerance))
    return cb.record(simulation.run(end, every=0.25))


def main(
    output: str = "results/two_droplets_2d", capillary: float = 0.2, viscosity_ratio: float = 1.0,
    half_width: float = 2.2, points: int = 32, tolerance: float = 1e-3, end: float = 10.0,
    parts: str = "pass swap",
) -> Runs:  # fmt: skip
    """Up to three parts.

    capillary: Ca in the thesis's reading; viscosity_ratio: λ, inner over outer viscosity
    half_width: W, in radii; points: on each droplet
    tolerance: error of a time step, as a share of a droplet's size
    end: time τ, in units of 1 / rate
    parts: 'pass', the thesis's start; 'swap', droplets that get each onto the side of the other;
        'convergence', how the end of 'pass' depends on points and steps
    """
    folder, case = cb.run_folder(output), (capillary, viscosity_ratio)
    plates = between_plane_plates(half_width, parts=6)
    flows = {"plates": plates, "unbounded": cb.FreeFlow(cb.shear(dimension=2))}
    print(f"Ca = {capillary} in the thesis's reading, {capillary / 2} true; λ = {viscosity_ratio}")
    made = {
        (name, place): simulate(flow, STARTS[name], *case, points, tolerance, end)
        for name in STARTS if name in parts for place, flow in flows.items()
    }  # fmt: skip
    folder.summary(pair_2d.tell(folder, made))
    if "convergence" in parts:
        run = partial(simulate, plates, STARTS["pass"], *case, end=end)
        known = made.get(("pass", "plates"))
        made |= labelled("convergence", pair_2d.convergence_runs(run, points, tolerance, known))
    return made


if __name__ == "__main__":
    cb.run(main)
