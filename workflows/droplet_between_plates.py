"""A droplet between parallel plates in shear flow u = (z, 0, 0) (thesis Fig. 4.7 and 4.8).

The plates z = ±W move with u = (±W, 0, 0); they are open squares that end in unbounded fluid.
Radius R = 1, Ca = μ × rate × R / γ; D is Taylor's.  Theory is that of Shapira and Haber, for
small deformation; true values come from a spectral computation.
"""

from functools import partial

import cadbem as cb
from cadbem.verification.figures import plates
from cadbem.verification.figures.common import KEEP, Runs, labelled
from cadbem.verification.plates import between_plates


def round_droplet(capillary: float, ratio: float, degree: int, points: int) -> cb.Droplet:
    shape = cb.spline_sphere(points=points, degree=degree)
    return cb.Droplet(shape, cb.capillary_tension(capillary), ratio)


def simulate(
    droplet: cb.Droplet, confinement: float, tolerance: float, end: float, keep=KEEP, **plate
) -> cb.History:  # fmt: skip
    flow = between_plates(1 / confinement, **plate)
    return cb.record(keep(cb.Simulation(flow, droplet, cb.Adaptive(tolerance)), end, 0.1))


def main(
    output: str = "results/droplet_between_plates", capillary: float = 0.2,
    viscosity_ratio: float = 1.0, points: int = 200, degree: int = 6, confinement: float = 0.8,
    confinements: str = "0.1 0.2 0.4 0.5 0.6 0.7 0.8", tolerance: float = 1e-3,
    end: float = 14.0, settle: float = 8.0, parts: str = "time", resume: bool = False,
) -> Runs:  # fmt: skip
    """Droplets that are round at first, but for those of 'confinement' after the first.

    capillary: Ca = μ × rate × R / γ; viscosity_ratio: λ, inner over outer viscosity
    confinement: R / W of 'time' and 'resolution'; confinements: R / W of 'confinement'
    points: on the droplet; degree: of its spline
    tolerance: error of a time step, as a share of the droplet's size
    end: time τ of 'time', in 1 / rate; settle: time τ of each run of 'confinement'
    parts: 'time', D(τ); 'confinement', the steady D; 'resolution', one thing changed at a time
    """
    folder, made = cb.run_folder(output, resume=resume), {}
    droplet = partial(round_droplet, capillary, viscosity_ratio, degree, points=points)
    if "time" in parts:
        run = simulate(droplet(), confinement, tolerance, end, folder.run)
        made["time", confinement] = run
        folder.summary(plates.tell_time(folder, run))
    if "confinement" in parts:
        shares = sorted(map(float, confinements.split()))
        run = partial(simulate, tolerance=tolerance, end=settle)
        made |= labelled("confinement", plates.steady_runs(run, droplet(), shares, folder))
    if "resolution" in parts:
        case = simulate, droplet, confinement, tolerance, min(end, 4.0)
        made |= labelled("resolution", plates.resolution_runs(*case))
    return made


if __name__ == "__main__":
    cb.run(main)
