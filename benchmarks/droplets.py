"""CPU time of a droplet in unbounded fluid: its velocity beside the floor that sums set, and steps.

    python -m benchmarks.droplets

The floor is one pass of the plain kernel over as many pairs of targets and sources as the
velocity needs (far and near), measured in turn with it.  A step is one of Euler's, everything
that a run does included.  Times are the smallest of several.
"""

import os
import time
from collections.abc import Callable

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np  # noqa: E402

import cadbem as cb  # noqa: E402
from benchmarks.table import Table, show  # noqa: E402
from cadbem.kernels.stokes_sums import stokes_sums  # noqa: E402
from cadbem.operators.closed.layers import ClosedLayers, closed_operator  # noqa: E402
from cadbem.quadrature.closed import PolarRule  # noqa: E402
from cadbem.suspension.bodies.droplet import PlacedDroplet  # noqa: E402
from cadbem.suspension.multibody.multibody import velocity_responses  # noqa: E402
from cadbem.suspension.time.thesis_methods import thesis_methods  # noqa: E402

REPEATS, ROUNDS = 5, 7
POINTS, RATIOS = (200, 800), (1.0, 0.1, 10.0)


def seconds(task: Callable[[], object]) -> float:
    start = time.process_time()
    for _ in range(REPEATS):
        task()
    return (time.process_time() - start) / REPEATS


def floor(targets: int, sources: int, passes: int) -> Callable[[], None]:
    """``passes`` sums over all pairs: a Stokeslet first, stresslets after it."""
    sums, random = stokes_sums(3), np.random.default_rng(0)
    at, out = random.normal(size=(3, targets)), np.zeros((3, targets))
    position, density, area = random.normal(size=(3, 3, sources))

    def run() -> None:
        sums.single(at, position, density, out)
        for _ in range(passes - 1):
            sums.double(at, out, position, area, density, np.zeros_like(out))

    return run


def velocity_row(points: int, ratio: float) -> tuple[str, ...]:
    shape = cb.spline_ellipsoid((1.6, 1.0, 0.7), points=points)
    operator = closed_operator(shape.basis, PolarRule())
    drop, flow = cb.Droplet(shape, cb.SurfaceTension(1.0), ratio), cb.FreeFlow(cb.shear())

    def velocity() -> int:
        return velocity_responses(
            flow, [PlacedDroplet(drop, ClosedLayers(operator, shape))]
        )[0].iterations

    iterations = velocity()
    near = np.mean([table.count for table in operator.tables])
    sources = int(operator.nodes.weights.size + near)
    plain = floor(points, sources, 1 + (iterations + 2 if iterations else 0))
    plain()
    pairs = [(seconds(velocity), seconds(plain)) for _ in range(ROUNDS)]
    best, least = np.min(pairs, axis=0)
    return (
        str(shape.basis.count), f"{ratio:g}", str(iterations), str(sources), f"{best:.4f}",
        f"{least:.4f}", f"{best / least:.1f}",
    )  # fmt: skip


def step_row(points: int, ratio: float) -> tuple[str, ...]:
    flow, tension = cb.FreeFlow(cb.shear()), cb.SurfaceTension(1.0)
    euler = cb.Euler(1e-3)
    times = []
    for degree, options in (
        (4, {"stepper": euler}),
        (4, {"stepper": euler, "mesh": cb.RelaxMesh()}),
        (2, thesis_methods(1e-3)),
    ):
        shape = cb.spline_ellipsoid((1.3, 1.0, 0.8), points=points, degree=degree)
        run = cb.Simulation(flow, cb.Droplet(shape, tension, ratio), **options).run(1.0)
        for _ in range(3):
            next(run)
        times.append(min(seconds(lambda run=run: next(run)) for _ in range(ROUNDS)))
    return str(shape.basis.count), f"{ratio:g}", *(f"{t:.4f}" for t in times)


def tables() -> list[Table]:
    cases = [(points, ratio) for points in POINTS for ratio in RATIOS]
    return [
        Table(
            "Velocity of a droplet",
            "An ellipsoid 1.6 : 1 : 0.7 with λ inside in shear flow; the floor is one pass of the "
            "plain kernel over all pairs of points and sources, for each iteration.",
            ("points", "λ", "iterations", "sources", "CPU s", "floor s", "times the floor"),
            [velocity_row(*case) for case in cases],
        ),
        Table(
            "A step in time of a droplet",
            "CPU seconds of a step of Euler's with all that a run does: velocities, volume, gaps "
            "and checks; by default, with the mesh relaxed too, and with the thesis's methods "
            "(degree 2, singularity subtraction).",
            ("points", "λ", "default", "relaxed mesh", "thesis's methods"),
            [step_row(*case) for case in cases],
        ),
    ]


if __name__ == "__main__":
    show(tables())
