"""Whole runs: CPU seconds and the most memory that a process held.

    python -m benchmarks.runs

Each run is a process of its own; everything is compiled beforehand.
"""

from __future__ import annotations

import json
import platform
import resource
import sys
import time
from collections.abc import Callable

import numpy as np

import cadbem as cb
from benchmarks.table import Table, fresh, least, show
from cadbem.boundary import Boundary, Patch
from cadbem.spline.shapes import box

ROUNDS = 2
SIDES = (6, 10, 14)  # elements along the sides of each face of a box
MEGABYTE = 1e6
CONDITIONS = {
    "inlet_a": cb.Inflow(mean_velocity=3.0),
    "inlet_b": cb.Inflow(mean_velocity=3.0),
    "outlet": cb.Pressure(0.0),
    "walls": cb.NoSlip(),
}


def peak() -> float:
    """Most memory held so far, in MB (megabytes)."""
    unit = 1 if platform.system() == "Darwin" else 1024  # macOS counts bytes
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * unit / MEGABYTE


def junction() -> cb.StokesProblem:
    """Two streams that meet, 4 elements a side of each patch."""
    boundary = cb.read_cad("geometries/y_junction.step").elevated(2).refined(4)
    return cb.StokesProblem(boundary, 1.0, CONDITIONS)


def flow() -> int:
    """The flow in a Y-junction, and its velocity at 2000 points."""
    solution = junction().solve()
    low, high = solution.space.boundary.bounds()
    shares = np.random.default_rng(1).random((3, 2000))
    middle = np.array([[12.0], [7.0], [2.0]])
    solution.velocity_at(middle + 0.05 * (high - low)[:, None] * (shares - 0.5))
    return solution.space.count


def plane() -> int:
    """The flow in the junction's plane section, 16 elements a side."""
    boundary = cb.read_outline("geometries/y_junction.step").elevated(2).refined(16)
    return cb.StokesProblem(boundary, 1.0, CONDITIONS).solve().space.count


def droplet() -> int:
    """A droplet in shear flow to its steady shape, as in the README."""
    drop = cb.Droplet(cb.spline_sphere(points=200), cb.capillary_tension(0.35))
    list(cb.Simulation(cb.FreeFlow(cb.shear()), drop).run(5.0, every=0.5))
    return drop.shape.basis.count


def carried() -> int:
    """A droplet and a sphere in the junction, a few steps."""
    shape = cb.spline_sphere(points=200, centre=(2.8, 2, 2))
    drop = cb.Droplet(shape, cb.SurfaceTension(20.0), viscosity_ratio=1.0)
    bodies = [drop, cb.rigid_sphere(0.5, (2.8, 11.5, 2))]
    problem = junction()
    list(cb.Simulation(cb.ChannelFlow(problem), bodies).run(0.05))
    return problem.space.count


WORKS: dict[str, Callable[[], int]] = {
    "flow": flow, "plane": plane, "droplet": droplet, "carried": carried,
}  # fmt: skip


def block(side: int) -> cb.StokesProblem:
    """The flow through a box."""
    names = ("inlet_a", "outlet", "walls", "walls", "walls", "walls")
    patches = tuple(Patch(s, n) for s, n in zip(box(), names, strict=True))
    boundary = Boundary(patches).elevated(2).refined(side)
    conditions = {name: CONDITIONS[name] for name in set(names)}
    return cb.StokesProblem(boundary, 1.0, conditions)


def assembly(side: int) -> dict[str, float]:
    """The system of a box, and what it holds: points, MB of its factors, MB at most, seconds."""
    block(2).solve()  # loads the machine code
    problem = block(side)
    points, before, start = problem.space.count, peak(), time.process_time()
    tables = problem.system.factors.factors[0].nbytes / MEGABYTE
    seconds, assembled = time.process_time() - start, peak() - before
    problem.solve()
    return {
        "points": points, "tables": tables, "assembled": assembled, "seconds": seconds,
        "solved": peak() - before,
    }  # fmt: skip


def measure(work: str) -> dict[str, float]:
    """Numbers of one run in this process."""
    if work.isdigit():
        return assembly(int(work))
    points = WORKS[work]()
    return {"points": points, "seconds": time.process_time(), "peak": peak()}


def rounds(work: str) -> dict[str, float]:
    """The smallest numbers of some processes."""
    return least([fresh("runs", work) for _ in range(ROUNDS)])


def tables() -> list[Table]:
    """Whole runs, and the memory of assembly."""
    fresh("runs", "carried")  # compiles
    rows = []
    for name, work in WORKS.items():
        numbers = rounds(name)
        words = (work.__doc__ or "").rstrip(".")
        values = (f"{numbers['points']:.0f}", f"{numbers['seconds']:.1f}", f"{numbers['peak']:.0f}")
        rows.append((words, *values))
    text = "From the start of Python to the result; points are those of the channel or the droplet."
    head = ("", "points", "CPU s", "memory at most (MB)")
    runs = Table("Whole runs", text, head, rows)
    rows = []
    for side in SIDES:
        found = rounds(str(side))
        memory = (f"{found[key]:.0f}" for key in ("tables", "assembled", "solved"))
        rows.append((f"{found['points']:.0f}", f"{found['seconds']:.2f}", *memory))
    text = """
A box with degree 2: CPU seconds of assembling and factorising, the memory that the factors take,
the most memory held on top of what was held before, while assembling and until solved.
"""
    head = ("points", "CPU s", "factors (MB)", "assembling (MB)", "solving (MB)")
    return [runs, Table("Memory of dense matrices", text, head, rows)]


if __name__ == "__main__":
    if len(sys.argv) > 1:
        print(json.dumps(measure(sys.argv[1])))
    else:
        show(tables())
