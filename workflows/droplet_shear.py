"""A droplet in shear flow u = (z, 0, 0) (thesis Fig. 4.1 to 4.3, Table 4.1).

Ca = μ × rate × R / γ; D is Taylor's.  The thesis's way is taken without and with mesh relaxation.
True values for λ = 1 come from a spectral computation.
"""

from functools import partial

import cadbem as cb
from cadbem.suspension.time.thesis_methods import thesis_methods
from cadbem.verification.figures import shear
from cadbem.verification.figures.common import KEEP, Keep, Runs, labelled


def simulate(
    capillary: float, ratio: float, points: int, degree: int, end: float,
    keep: Keep = KEEP, **options,
) -> cb.History:  # fmt: skip
    shape = cb.spline_sphere(points=points, degree=degree)
    droplet = cb.Droplet(shape, cb.capillary_tension(capillary), ratio)
    return cb.record(keep(cb.Simulation(cb.FreeFlow(cb.shear()), droplet, **options), end, 0.1))


def main(
    output: str = "results/droplet_shear", capillary: float = 0.35, viscosity_ratio: float = 1.0,
    points: int = 200, degree: int = 4, tolerance: float = 1e-3, end: float = 5.0,
    parts: str = "shape volume table", reference: int = 0, resume: bool = False,
) -> Runs:  # fmt: skip
    """Up to three parts, each with a report and pictures.

    capillary: Ca in 'shape'; viscosity_ratio: λ, inner over outer viscosity, in 'shape'
    points: on the droplet; degree: of its spline
    tolerance: error of a time step, as a share of the droplet's size
    end: time τ, in units of 1 / rate
    parts: 'shape', one droplet's D(τ) and final shape; 'volume', what is lost without correction
        at Ca = 0.2; 'table', D(τ) beside Table 4.1
    reference: points of degree 6 with which 'table' is computed again, 0 for none
    """
    folder, made = cb.run_folder(output, resume=resume), {}
    ours = {"degree": degree, "stepper": cb.Adaptive(tolerance), "end": end}
    thesis = {"degree": 2, "end": end, **thesis_methods()}
    if "shape" in parts:
        ways = {"ours": ours, "thesis's way": thesis}
        ways["thesis's way, relaxed"] = thesis | {"mesh": cb.RelaxMesh()}
        case, runs = (capillary, viscosity_ratio), {}
        for name, options in ways.items():
            keep = partial(folder.run, part=name.replace(" ", "_"))
            runs[name,] = simulate(*case, points, keep=keep, **options)
        folder.summary(shear.tell_shape(folder, case, runs))
        made |= labelled("shape", runs)
    if "volume" in parts:
        made |= labelled("volume", shear.volume_runs(simulate, points, ours, thesis, folder))
    if "table" in parts:
        made |= labelled("table", shear.table_runs(simulate, points, ours, reference))
    return made


if __name__ == "__main__":
    cb.run(main)
