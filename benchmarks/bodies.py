"""What bodies in a channel cost: CPU seconds of one evaluation of all velocities.

A channel 4 x 4 x 42 with 1, 2, 5, 10, 20 bodies of radius 0.6, droplets and rigid spheres by turns,
in two rows.  Prints a table, and the exponent of the cost in the number of bodies: of all, and
of what comes on top of the first.
"""

import os
import platform
import time

import numpy as np

import cadbem as cb
from cadbem.boundary import Boundary, Patch
from cadbem.spline.shapes import box

COUNTS = (1, 2, 5, 10, 20)
ROUNDS = 3


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


def bodies(count: int) -> list:
    sphere, made = cb.rigid_sphere(0.6, spans=1), []
    for k in range(count):
        centre = np.array([2.0 + 2.0 * k, 0.8 * (-1) ** (k // 2), 0.3])
        if k % 2:
            made.append(sphere.at(np.concatenate([centre, [0.0, 0.0, 0.0, 1.0]])))
        else:
            shape = cb.spline_sphere(0.6, centre, points=128)
            made.append(cb.Droplet(shape, cb.SurfaceTension(5.0)))
    return made


def evaluation(flow: cb.ChannelFlow, count: int) -> tuple[float, int]:
    """CPU seconds, and iterations of GMRES."""
    state = cb.Simulation(flow, bodies(count)).start
    start = time.process_time()
    responses = state.responses
    return time.process_time() - start, responses[0].iterations


def main() -> None:
    flow = channel()
    start = time.process_time()
    points = flow.empty.space.count
    print(platform.processor() or platform.machine(), os.cpu_count(), "cores")
    print(f"{points} points on the channel; assembly and solution {time.process_time() - start:.1f}"
          " CPU s, once")  # fmt: skip
    evaluation(flow, 2)
    print("bodies    CPU s  iterations")
    seconds = []
    for count in COUNTS:
        rounds = [evaluation(flow, count) for _ in range(ROUNDS)]
        seconds.append(min(s for s, _ in rounds))
        print(f"{count:6d} {seconds[-1]:8.3f} {rounds[0][1]:11d}", flush=True)
    counts = np.array(COUNTS)
    whole = np.polyfit(np.log(counts[1:]), np.log(seconds[1:]), 1)[0]
    print(f"cost ~ bodies^{whole:.2f} (from 2 bodies on)")


if __name__ == "__main__":
    main()
