"""How long a user waits for a first result: compiling included, and from the second time on.

    python -m benchmarks.first_result

Each round is a process of its own, which begins with an empty folder for compiled code, or with
the one that the round before has filled.
"""

from __future__ import annotations

import json
import os
import sys
import tempfile
import time

from benchmarks.table import Table, fresh, least, show

ROUNDS = 2
WORKS = {
    "channel": "Y-junction, 3 elements a side of each patch, solved",
    "point": "the same, and velocity and pressure at a point",
    "plane": "its plane section, solved",
    "droplet": "droplet of 200 points, viscosity ratio 1, first velocity",
    "ratio": "droplet of 200 points, viscosity ratio 5, first velocity",
}


class Clock:
    """CPU seconds since the last look, of this process or of the ones that it has started."""

    def __init__(self) -> None:
        self.own, self.others = 0.0, 0.0

    def look(self) -> tuple[float, float]:
        """Seconds of this process and of others."""
        now = os.times()
        own, others = now.user + now.system, now.children_user + now.children_system
        passed = own - self.own, others - self.others
        self.own, self.others = own, others
        return passed


def channel(clock: Clock, work: str) -> dict[str, float]:
    """Read a CAD file, and solve."""
    import cadbem as cb

    numbers = {"import": clock.look()[0]}
    file = "geometries/y_junction.step"
    boundary = cb.read_outline(file) if work == "plane" else cb.read_cad(file)
    own, others = clock.look()
    numbers |= {"cad": own, "kernel": others}
    conditions = {
        "inlet_a": cb.Inflow(mean_velocity=3.0),
        "inlet_b": cb.Inflow(mean_velocity=3.0),
        "outlet": cb.Pressure(0.0),
        "walls": cb.NoSlip(),
    }
    flow = cb.StokesProblem(boundary.elevated(2).refined(3), 1.0, conditions).solve()
    flow.flow_rate("outlet")
    if work == "point":
        flow.velocity_at([[12], [7], [2]])
        flow.pressure_at([[12], [7], [2]])
    return numbers | {"result": clock.look()[0]}


def droplet(clock: Clock, ratio: float) -> dict[str, float]:
    """A droplet in shear flow."""
    import cadbem as cb

    numbers = {"import": clock.look()[0], "cad": 0.0, "kernel": 0.0}
    shape = cb.spline_sphere(points=200)
    drop = cb.Droplet(shape, cb.capillary_tension(0.35), viscosity_ratio=ratio)
    assert cb.Simulation(cb.FreeFlow(cb.shear()), drop).start.responses
    return numbers | {"result": clock.look()[0]}


def measure(work: str) -> dict[str, float]:
    """CPU seconds of one kind of work in this process."""
    clock = Clock()
    if work in ("droplet", "ratio"):
        return droplet(clock, 1.0 if work == "droplet" else 5.0)
    return channel(clock, work)


def row(work: str) -> tuple[str, ...]:
    """A row of the table."""
    first, later = [], []
    for _ in range(ROUNDS):
        with tempfile.TemporaryDirectory() as folder:
            first.append(fresh("first_result", work, NUMBA_CACHE_DIR=folder))
            later += [fresh("first_result", work, NUMBA_CACHE_DIR=folder) for _ in range(ROUNDS)]
    cold, warm = least(first), least(later)
    started = warm["import"] + warm["cad"]
    numbers = (warm["kernel"], started, cold["result"], warm["result"])
    return WORKS[work], *(f"{number:.2f}" if number else "" for number in numbers)


def tables() -> list[Table]:
    """First results with nothing compiled, and later."""
    text = """
CPU seconds from the start of Python on. A CAD file is read by a process of its own ("CAD kernel");
"start" is importing cadbem and laying patches. The result comes first with an empty folder for
compiled code, then in a new process that finds it there (importing numba and SciPy included).
"""
    head = ("", "CAD kernel", "start", "first result", "later")
    return [Table("First result", text, head, [row(work) for work in WORKS])]


if __name__ == "__main__":
    if len(sys.argv) > 1:
        print(json.dumps(measure(sys.argv[1])))
    else:
        started = time.perf_counter()
        show(tables())
        print(f"{time.perf_counter() - started:.0f} s", file=sys.stderr)
