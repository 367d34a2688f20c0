"""CPU time of a droplet's velocity beside the floor that its sums set.

    python benchmarks/droplets.py

The floor is one pass of the plain kernel over as many pairs of targets and sources as the
velocity needs (far and near), measured in turn with it.  Times are the smallest of several, on
one thread.
"""

import os
import platform
import time
from collections.abc import Callable

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np  # noqa: E402

import cadbem as cb  # noqa: E402
from cadbem.kernels.stokes_sums import stokes_sums  # noqa: E402
from cadbem.operators.closed import ClosedLayers, closed_operator  # noqa: E402
from cadbem.suspension.droplet import PlacedDroplet
from cadbem.suspension.together import respond_together

REPEATS, ROUNDS = 5, 7


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


def compare(points: int, ratio: float) -> str:
    shape = cb.spline_ellipsoid((1.6, 1.0, 0.7), points=points)
    operator = closed_operator(shape.basis, cb.PolarRule())
    drop, flow = cb.Droplet(shape, cb.SurfaceTension(1.0), ratio), cb.FreeFlow(cb.shear())

    def velocity() -> int:
        return respond_together(
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
        f"{points:6d} {ratio:6g} {best:10.4f} {least:10.4f} {best / least:8.1f} {iterations:6d}"
        f" {sources:8d}"
    )


def main() -> None:
    print(platform.processor() or platform.machine(), os.cpu_count(), "cores, one thread used")
    print("points  ratio  velocity s    floor s    times  iterations  sources")
    for points in (200, 800):
        for ratio in (1.0, 0.1, 10.0):
            print(compare(points, ratio), flush=True)


if __name__ == "__main__":
    main()
