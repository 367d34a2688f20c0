"""What small capillary numbers cost: evaluations of the velocities, and CPU seconds.

    python -m benchmarks.stiffness

Droplets that are round at first, with tensions that make them relax up to a thousand times faster
than they move.  Errors are against the same run with a hundredth of the tolerance.
"""

import os
import time

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np  # noqa: E402

import cadbem as cb  # noqa: E402
from benchmarks.table import Table, show  # noqa: E402
from cadbem.boundary import Boundary, Patch  # noqa: E402
from cadbem.spline.shapes import box  # noqa: E402
from cadbem.suspension.surroundings.surroundings import Surroundings  # noqa: E402

CAPILLARY, RATIOS, TOLERANCE = (0.1, 1e-2, 1e-3, 1e-4), (0.1, 1.0, 10.0), 1e-3


def duct() -> cb.ChannelFlow:
    """A square duct of width 1 with the mean velocity 1."""
    names = ("inlet", "outlet", "walls", "walls", "walls", "walls")
    faces = box((0.0, -0.5, -0.5), (3.0, 0.5, 0.5))
    boundary = Boundary(tuple(Patch(f, n) for f, n in zip(faces, names, strict=True)))
    conditions = {
        "inlet": cb.Inflow(mean_velocity=1.0),
        "outlet": cb.Pressure(0.0),
        "walls": cb.NoSlip(),
    }
    problem = cb.StokesProblem(
        boundary.elevated(2).refined(size=0.25), 1.0, conditions, cb.Quadrature(1e-4)
    )
    return cb.ChannelFlow(problem)


def row(
    flow: Surroundings, radius: float, centre: tuple[float, ...], ratio: float, capillary: float
) -> tuple[str, ...]:
    """One droplet for a unit of time."""
    shape = cb.spline_sphere(radius, centre, points=200)
    droplet, ends = cb.Droplet(shape, cb.SurfaceTension(1 / capillary), ratio), []
    for tolerance in (TOLERANCE, TOLERANCE / 100):
        simulation = cb.Simulation(flow, droplet, stepper=cb.Adaptive(tolerance))
        start = time.process_time()
        *_, state = simulation.run(1.0)
        ends.append((state, time.process_time() - start))
    (state, seconds), (fine, _) = ends
    found, true = state.measures[0], fine.measures[0]
    deformation = abs(found.deformation / true.deformation - 1)
    return (
        f"{ratio:g}", f"{capillary:g}", str(state.evaluations), str(state.steps), f"{seconds:.1f}",
        f"{np.linalg.norm(found.centre - true.centre):.0e}", f"{deformation:.0e}",
    )  # fmt: skip


def tables() -> list[Table]:
    head = ("λ", "Ca", "evaluations", "steps", "CPU s", "error of the place", "error of D")
    text = "A droplet of 200 points {}, for a unit of time, tolerance 1e-3. D's error is relative."
    flow, middle = cb.FreeFlow(cb.shear()), (0.0, 0.0, 0.0)
    channel, beside = duct(), (0.7, 0.1, 0.05)
    return [
        Table(
            "Small capillary numbers in shear", text.format("of radius 1 in shear flow"), head,
            [row(flow, 1.0, middle, ratio, c) for ratio in RATIOS for c in CAPILLARY],
        ),
        Table(
            "Small capillary numbers in a duct",
            text.format("of radius 0.15 beside the middle of a square duct of width 1"), head,
            [row(channel, 0.15, beside, 1.0, c) for c in CAPILLARY],
        ),
    ]  # fmt: skip


if __name__ == "__main__":
    show(tables())
