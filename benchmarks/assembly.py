"""What dense matrices cost: time beside the plain kernel's, memory beside the matrices kept.

    python -m benchmarks.assembly

Stokes flow in a channel of 1 x 1 x 2 with elements of degree 2, made finer and finer; 846 points
are those of the thesis's finest channel.  Seconds are CPU seconds on one thread, the smallest of
several rounds, but for those of the comparison of threads, which are wall seconds: run it on a
quiet machine.
"""

from __future__ import annotations

import os
import time
import tracemalloc
from collections.abc import Callable

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np  # noqa: E402

import cadbem as cb  # noqa: E402
from benchmarks.table import Table, show  # noqa: E402
from cadbem.boundary import Boundary, Patch  # noqa: E402
from cadbem.kernels.stokes_3d import STOKES_3D  # noqa: E402
from cadbem.kernels.stokes_sums import SUMS_3D  # noqa: E402
from cadbem.operators.assembly import add_layers  # noqa: E402
from cadbem.operators.panels import split_patch  # noqa: E402
from cadbem.operators.parallel import CORES  # noqa: E402
from cadbem.quadrature import Quadrature  # noqa: E402
from cadbem.spline.shapes import box  # noqa: E402

ROUNDS = 2
THESIS = (17, 7)  # elements along and across
SIZES = ((8, 4), (12, 5), THESIS, (24, 10))
FLOOR_ORDER = 4
TOLERANCES = (1e-8, 1e-6)
MEGABYTE = 1 << 20


def problem(elements: tuple[int, int], tolerance: float) -> cb.StokesProblem:
    """A channel with so many elements along and across."""
    names = ("inlet", "outlet", "walls", "walls", "walls", "walls")
    faces = box((0, 0, 0), (2, 1, 1))
    boundary = Boundary(tuple(Patch(f, n) for f, n in zip(faces, names, strict=True)))
    along, across = elements
    boundary = boundary.elevated(2).refined(size=(2 / along, 1 / across, 1 / across))
    conditions = {
        "inlet": cb.Inflow(mean_velocity=1.0),
        "outlet": cb.Pressure(0.0),
        "walls": cb.NoSlip(),
    }
    return cb.StokesProblem(boundary, 1.0, conditions, cb.Quadrature(tolerance))


def with_threads(count: int, task: Callable[[], object]) -> tuple[float, float]:
    """Wall and CPU seconds of a task whose integrals run on so many threads."""
    before = CORES.set(count)
    try:
        wall, processor = time.perf_counter(), time.process_time()
        task()
        return time.perf_counter() - wall, time.process_time() - processor
    finally:
        CORES.reset(before)


def assembled(flow: cb.StokesProblem) -> np.ndarray:
    """What walls without slip, an inlet and an outlet need of both layers."""
    splits, count = flow.splits, flow.space.count
    matrix = np.zeros((3, count, 3, count))
    single, double = ([getattr(s, m) for s in splits] for m in ("flux_mixing", "value_mixing"))
    add_layers(flow.layers, single, double, matrix)
    return matrix


def assembly_and_solution(elements: tuple[int, int], tolerance: float) -> tuple[float, ...]:
    """CPU seconds of the space, of assembly, and of the solution: the best of some rounds."""
    rounds = []
    for _ in range(ROUNDS):
        flow = problem(elements, tolerance)
        parts = lambda: flow.space, lambda: assembled(flow), flow.solve  # noqa: B023
        rounds.append([with_threads(1, part)[1] for part in parts])
    return tuple(np.min(rounds, axis=0))


def thesis_rows() -> list[tuple[str, ...]]:
    """The thesis's channel."""
    rows = []
    for tolerance in TOLERANCES:
        space, assembly, solution = assembly_and_solution(THESIS, tolerance)
        seconds = (space, assembly, solution, space + assembly + solution)
        rows.append((f"{tolerance:g}", *(f"{s:.2f}" for s in seconds)))
    return rows


def passes(pairs: int) -> tuple[float, float]:
    """CPU seconds of the plain kernel over so many pairs: as sums of both layers, as tables."""
    random, count = np.random.default_rng(0), 196
    at, out, zero = random.normal(size=(3, 64)), np.zeros((3, 64)), np.zeros((3, 64))
    position, normal, density = random.normal(size=(3, 3, count))
    room, turns = np.empty(12 * 64 * count), 100

    def sums() -> None:
        for _ in range(turns):
            SUMS_3D.single(at, position, density, out)
            SUMS_3D.double(at, zero, position, normal, density, out)

    def tables() -> None:
        for _ in range(turns):
            STOKES_3D.block(at, position, normal, room)

    scale = pairs / (turns * 64 * count)
    best = [min(with_threads(1, task)[1] for _ in range(7)) for task in (sums, tables)]
    return scale * best[0], scale * best[1]


def floor_rows() -> list[tuple[str, ...]]:
    """Assembly beside one pass of the kernel over all targets and the nodes of a low order."""
    rows = []
    for elements in SIZES[2:]:
        for tolerance in TOLERANCES[::-1]:
            flow, best, floors = problem(elements, tolerance), np.inf, []
            panels = [split_patch(p.surface) for p in flow.boundary.patches]
            nodes = FLOOR_ORDER**2 * sum(len(p.flat_nets) for p in panels)
            for _ in range(ROUNDS):
                floors.append(passes(nodes * flow.space.count))
                fresh = problem(elements, tolerance)
                best = min(best, with_threads(1, lambda: assembled(fresh))[1])  # noqa: B023
            least = np.min(floors, axis=0)
            ratios = (f"{best / f:.1f}" for f in least)
            seconds = (f"{s:.2f}" for s in (best, *least))
            rows.append((f"{flow.space.count}", f"{tolerance:g}", *seconds, *ratios))
    return rows


def growth_rows() -> list[tuple[str, ...]]:
    """Assembly and solution for more and more points."""
    rows = []
    for elements in SIZES:
        count = problem(elements, Quadrature().tolerance).space.count
        _, assembly, solution = assembly_and_solution(elements, Quadrature().tolerance)
        kept, peak = memory(elements)
        rows.append((
            f"{count}", f"{assembly:.2f}", f"{1e6 * assembly / count**2:.2f}", f"{solution:.2f}",
            f"{kept:.0f}", f"{peak:.0f}", f"{peak / kept:.2f}",
        ))  # fmt: skip
    return rows


def memory(elements: tuple[int, int]) -> tuple[float, float]:
    """Megabytes of the matrices kept, and of all arrays at the worst moment."""
    tracemalloc.start()
    flow = problem(elements, Quadrature().tolerance)
    flow.solve()
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    kept = flow.system.factors.factors[0].nbytes
    return kept / MEGABYTE, peak / MEGABYTE


def thread_rows() -> list[tuple[str, ...]]:
    """Assembly on one thread and on two."""
    rows = []
    for elements in SIZES[2:]:
        rounds: list[list[float]] = []
        for _ in range(ROUNDS):
            fresh = [problem(elements, Quadrature().tolerance) for _ in range(2)]
            for flow in fresh:
                assert flow.space.count
            rounds.append([
                with_threads(n, lambda: assembled(flow))[0]  # noqa: B023
                for n, flow in enumerate(fresh, start=1)
            ])  # fmt: skip
        one, two = np.min(rounds, axis=0)
        rows.append((f"{flow.space.count}", f"{one:.2f}", f"{two:.2f}", f"{one / two:.2f}"))
    return rows


def tables() -> list[Table]:
    """The thesis's channel, the floor, growth, memory, threads."""
    problem(THESIS, TOLERANCES[0]).solve()
    return [
        Table(
            "The thesis's channel",
            "CPU seconds for 846 points (2538 unknowns), assembly and solution, by tolerance.",
            ("Tolerance", "space", "assembly", "solution", "all"),
            thesis_rows(),
        ),
        Table(
            "Assembly beside the plain kernel",
            f"One pass of the kernel over all targets and {FLOOR_ORDER} x {FLOOR_ORDER} nodes on "
            "each panel: as sums of both layers, which write nothing, and as tables of both "
            "layers.  CPU seconds; assembly holds everything, also singular integrals.",
            ("Points", "tolerance", "assembly", "sums", "tables", "/ sums", "/ tables"),
            floor_rows(),
        ),
        Table(
            "Dense matrices",
            "At the default tolerance: CPU seconds, memory in megabytes.  Kept are the factors of "
            "the system.",
            ("Points", "assembly", "µs an entry", "solution", "kept", "peak", "peak / kept"),
            growth_rows(),
        ),
        Table(
            "Two threads",
            f"Wall seconds of assembly, {os.cpu_count()} cores.",
            ("Points", "one thread", "two", "speed-up"),
            thread_rows(),
        ),
    ]


if __name__ == "__main__":
    show(tables())
