"""A plane droplet between moving plates: D(τ) for several widths (thesis Fig. 3.4).

Plates y = ±W move with u = (±W, 0); the channel's ends carry u = (y, 0).  Radius R = 1.
"""

from functools import partial
from math import inf

import cadbem as cb
from cadbem.suspension.interface.laws import thesis_tension_2d
from cadbem.verification.figures import plates_2d
from cadbem.verification.figures.common import Runs, labelled
from cadbem.verification.plates import between_plane_plates

FRAMES = 60  # states that are kept


def simulate(
    flow: cb.ChannelFlow | cb.FreeFlow, capillary: float, ratio: float, points: int, end: float,
    centre: tuple[float, float] = (0.0, 0.0), degree: int = 4, **options,
) -> cb.History:  # fmt: skip
    shape = cb.spline_circle(points=points, degree=degree, centre=centre)
    droplet = cb.Droplet(shape, thesis_tension_2d(capillary), ratio)
    simulation = cb.Simulation(flow, droplet, **{"stepper": cb.Adaptive(1e-4)} | options)
    return cb.record(simulation.run(end, every=end / FRAMES))


def main(
    output: str = "results/droplet_between_plates_2d", capillary: float = 0.2,
    viscosity_ratio: float = 1.0, widths: str = "1.25 1.5 2 3 4 8 16", points: int = 48,
    end: float = 8.0, parts: str = "widths resolution drift",
) -> Runs:  # fmt: skip
    """Droplets that are round at first.

    capillary: Ca in the thesis's reading, Δf = (2 / Ca) c n, which is twice the true one
    viscosity_ratio: λ, inner over outer viscosity
    widths: W, in radii; points: on the droplet
    end: time τ, in units of 1 / rate; 'drift' takes twice as long, 'resolution' half as long
    parts: 'widths', also unbounded; 'resolution', one thing changed at a time for the narrowest;
        'drift', from off the middle; 'thesis', all widths with the thesis's methods and points
    """
    folder, made, wanted = cb.run_folder(output), {}, sorted(map(float, widths.split()))
    run = partial(simulate, capillary=capillary, ratio=viscosity_ratio, points=points, end=end)
    print(f"Ca = {capillary} in the thesis's reading, {capillary / 2} true; λ = {viscosity_ratio}")
    if "widths" in parts:
        runs = {w: run(between_plane_plates(w)) for w in wanted}
        runs[inf] = run(cb.FreeFlow(cb.shear(dimension=2)))
        made |= labelled("width", plates_2d.tell_widths(folder, runs, viscosity_ratio))
    if "resolution" in parts:
        made |= labelled("resolution", plates_2d.resolution_runs(run, wanted[0], points, end / 2))
    if "thesis" in parts:
        made |= labelled("thesis", plates_2d.thesis_runs(run, wanted))
    if "drift" in parts:
        made |= labelled("drift", plates_2d.drift_runs(partial(run, end=2 * end), folder))
    folder.summary({f"D, {' '.join(map(str, k))}": r.deformation[-1] for k, r in made.items()})
    return made


if __name__ == "__main__":
    cb.run(main)
