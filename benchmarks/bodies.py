"""What many bodies cost: CPU seconds of one evaluation of all velocities.

    python -m benchmarks.bodies

Droplets in unbounded fluid at random places, some nearly touching, and droplets and rigid spheres
by turns in a channel; the exponent of the cost in the number of bodies.
"""

import os
import time
from collections.abc import Sequence

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np  # noqa: E402

import cadbem as cb  # noqa: E402
from benchmarks.table import Table, show  # noqa: E402
from cadbem.boundary import Boundary, Patch  # noqa: E402
from cadbem.spline.shapes import box  # noqa: E402
from cadbem.suspension.surroundings.surroundings import Surroundings  # noqa: E402

FREE = (1, 5, 20, 50, 100)
SUMMED_DIRECTLY = 50  # bodies up to which direct sums are timed
IN_CHANNEL = (1, 2, 5, 10, 20)
VOLUME_SHARE, NARROWEST = 0.08, 0.05
ROUNDS = 2


def cloud(count: int, ratio: float) -> list[cb.Droplet]:
    """Ellipsoids of 200 points in a cube."""
    random = np.random.default_rng(0)
    side = (count * 4 / 3 * np.pi / VOLUME_SHARE) ** (1 / 3)
    centres: list[np.ndarray] = []
    while len(centres) < count:
        centre = random.uniform(0, side, 3)
        if all(np.linalg.norm(centre - c) > 2 + NARROWEST for c in centres):
            centres.append(centre)
    return [
        cb.Droplet(
            cb.spline_ellipsoid(np.roll((1.0, 0.9, 0.8), i), c), cb.SurfaceTension(1.0), ratio
        )
        for i, c in enumerate(centres)
    ]


def channel() -> cb.ChannelFlow:
    names = ("inlet", "outlet", "walls", "walls", "walls", "walls")
    faces = box((0.0, -2.0, -2.0), (42.0, 2.0, 2.0))
    boundary = Boundary(tuple(Patch(f, n) for f, n in zip(faces, names, strict=True)))
    boundary = boundary.elevated(2).refined(size=(1.75, 1.0, 1.0))
    conditions = {
        "inlet": cb.Inflow(mean_velocity=1.0),
        "outlet": cb.Pressure(0.0),
        "walls": cb.NoSlip(),
    }
    return cb.ChannelFlow(cb.StokesProblem(boundary, 1.0, conditions, cb.Quadrature(1e-5)))


def train(count: int) -> list:
    """Bodies of radius 0.6 in a channel, in two rows."""
    sphere, made = cb.rigid_sphere(0.6, spans=1), []
    for k in range(count):
        centre = np.array([2.0 + 2.0 * k, 0.8 * (-1) ** (k // 2), 0.3])
        if k % 2:
            made.append(sphere.at(np.concatenate([centre, [0.0, 0.0, 0.0, 1.0]])))
        else:
            shape = cb.spline_sphere(0.6, centre, points=128)
            made.append(cb.Droplet(shape, cb.SurfaceTension(5.0)))
    return made


def evaluation(
    flow: Surroundings, bodies: list, far: cb.FarField | None = None, rounds: int = ROUNDS
) -> tuple[float, int]:
    """CPU seconds, and iterations of GMRES."""
    times = []
    for _ in range(rounds):
        state = cb.Simulation(flow, bodies, far=far).start
        start = time.process_time()
        iterations = state.responses[0].iterations
        times.append(time.process_time() - start)
    return min(times), iterations


def exponent(counts: Sequence[int], seconds: Sequence[float]) -> float:
    return float(np.polyfit(np.log(counts), np.log(seconds), 1)[0])


def free_table(ratio: float) -> Table:
    flow, far = cb.FreeFlow(cb.shear()), cb.FarField()
    evaluation(flow, cloud(5, ratio), far)
    evaluation(flow, cloud(5, ratio))
    rows, times = [], []
    for count in FREE:
        bodies = cloud(count, ratio)
        seconds, iterations = evaluation(flow, bodies, far)
        times.append(seconds)
        direct = ("", "")
        if count <= SUMMED_DIRECTLY:
            summed = evaluation(flow, bodies, rounds=1)[0]
            direct = f"{summed:.2f}", f"{summed / seconds:.1f}"
        row = str(count), str(iterations), f"{seconds:.3f}", f"{1000 * seconds / count:.0f}"
        rows.append((*row, *direct))
    many = [i for i, count in enumerate(FREE) if count >= 20]
    power = exponent([FREE[i] for i in many], [times[i] for i in many])
    return Table(
        f"Droplets in unbounded fluid, λ = {ratio:g}",
        f"Ellipsoids of 200 points at random in a cube, {VOLUME_SHARE:.0%} of its volume, gaps "
        f"from {NARROWEST} radii on. From 20 on the cost grows like bodies^{power:.2f}.",
        ("droplets", "iterations", "CPU s", "ms a droplet", "direct sums s", "ratio"),
        rows,
    )


def channel_table() -> Table:
    flow, far = channel(), cb.FarField()
    start = time.process_time()
    points = flow.empty.space.count
    once = time.process_time() - start
    evaluation(flow, train(2), far)
    rows, times = [], []
    for count in IN_CHANNEL:
        seconds, iterations = evaluation(flow, train(count), far)
        direct = evaluation(flow, train(count), rounds=1)[0]
        times.append(seconds)
        row = str(count), str(iterations), f"{seconds:.3f}", f"{direct:.2f}"
        rows.append((*row, f"{direct / seconds:.1f}"))
    power = exponent(IN_CHANNEL[1:], times[1:])
    return Table(
        "Bodies in a channel",
        f"Droplets of 128 points (λ = 1) and rigid spheres in a channel of {points} points, 42 "
        f"long, assembled and solved once in {once:.1f} CPU s. From 2 on the cost grows like "
        f"bodies^{power:.2f}.",
        ("bodies", "iterations", "CPU s", "direct sums s", "ratio"),
        rows,
    )


def tables() -> list[Table]:
    return [free_table(1.0), free_table(5.0), channel_table()]


if __name__ == "__main__":
    show(tables())
