"""Pairs of targets and sources a second and core: the package's kernels beside C.

    python -m benchmarks.kernels

Each kernel is measured in turn with the same loop in C (``kernels.c``), compiled by
gcc -O3 -march=native -ffast-math into a temporary folder; without gcc the rows say so.  Times are
CPU times, the smallest of several rounds, on one thread.
"""

from __future__ import annotations

import ctypes
import os
import shutil
import subprocess
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np  # noqa: E402

from benchmarks.table import Table, show  # noqa: E402
from cadbem.kernels import laplace_2d, laplace_3d, stokes_2d, stokes_3d  # noqa: E402
from cadbem.kernels.kernel import Array, Kernel, Sums  # noqa: E402
from cadbem.kernels.stokes_sums import stokes_sums  # noqa: E402
from cadbem.operators.panels import Panels, split_patch, tensor_nodes  # noqa: E402
from cadbem.operators.tensor import add_tensor, by_blocks  # noqa: E402
from cadbem.spline.shapes import box  # noqa: E402

ROUNDS, PAIRS = 15, 2_000_000
SOURCES = 196  # a table: four panels with 7 x 7 nodes
TARGETS = 64
FILLS = {
    "stokes_3d": stokes_3d.STOKES_3D,
    "pressure_3d": stokes_3d.STOKES_PRESSURE_3D,
    "laplace_3d": laplace_3d.LAPLACE_3D,
    "stokes_2d": stokes_2d.STOKES_2D,
    "pressure_2d": stokes_2d.STOKES_PRESSURE_2D,
    "laplace_2d": laplace_2d.LAPLACE_2D,
}
HEAD = ("Kernel", "package", "gcc", "package / gcc")
NO_PEER = "no gcc"


def compiled_c(folder: str) -> ctypes.CDLL | None:
    """The peers, if there is a compiler."""
    compiler, source = shutil.which("gcc"), Path(__file__).with_name("kernels.c")
    if compiler is None:
        return None
    library = Path(folder) / "kernels.so"
    options = ["-O3", "-march=native", "-ffast-math", "-shared", "-fPIC"]
    subprocess.run([compiler, *options, str(source), "-o", str(library), "-lm"], check=True)
    return ctypes.CDLL(str(library))


def in_turn(*tasks: Callable[[], object]) -> list[float]:
    """Smallest CPU seconds of each task over rounds in which all take their turn."""
    for task in tasks:
        task()
    best = [np.inf] * len(tasks)
    for _ in range(ROUNDS):
        for k, task in enumerate(tasks):
            start = time.process_time()
            task()
            best[k] = min(best[k], time.process_time() - start)
    return best


def repeated(task: Callable[[], object], pairs: int) -> Callable[[], object]:
    """The task again and again, until so many pairs are done that the clock is fine enough."""
    times = range(max(1, PAIRS // pairs))

    def run() -> None:
        for _ in times:
            task()

    return run


def c_task(function: Callable, *arguments: int | Array) -> Callable[[], object]:
    """A call of a C function with numbers and arrays."""
    passed = [
        ctypes.c_long(a) if isinstance(a, int) else a.ctypes.data_as(ctypes.c_void_p)
        for a in arguments
    ]
    return lambda: function(*passed)


def row(name: str, pairs: int, ours: Callable, theirs: Callable | None) -> tuple[str, ...]:
    """Thousand millions of pairs a second of both, and their ratio."""
    tasks = [ours] if theirs is None else [ours, theirs]
    done = pairs * max(1, PAIRS // pairs)
    rates = [1e-9 * done / s for s in in_turn(*(repeated(t, pairs) for t in tasks))]
    if theirs is None:
        return name, f"{rates[0]:.3f}", NO_PEER, ""
    return name, f"{rates[0]:.3f}", f"{rates[1]:.3f}", f"{rates[0] / rates[1]:.2f}"


def fill_row(name: str, kernel: Kernel, peers: ctypes.CDLL | None) -> tuple[str, ...]:
    """Tables of pairs."""
    random, dim = np.random.default_rng(0), kernel.dimension
    targets, sources = random.normal(size=(dim, TARGETS)), 5 + random.normal(size=(dim, SOURCES))
    normal = random.normal(size=(dim, SOURCES))
    room = np.empty(kernel.entries * TARGETS * SOURCES)
    theirs = None
    if peers is not None:
        out = np.empty_like(room)
        arguments = TARGETS, targets, SOURCES, sources, normal, out
        theirs = c_task(getattr(peers, name), *arguments)
        theirs()
        ours = kernel.block(targets, sources, normal, room)
        assert np.allclose(ours.ravel(), out, rtol=1e-12, atol=0.0)
    return row(
        f"{kernel.name}: table",
        TARGETS * SOURCES,
        lambda: kernel.block(targets, sources, normal, room),
        theirs,
    )


def sum_rows(dim: int, peers: ctypes.CDLL | None) -> list[tuple[str, ...]]:
    """Sums over sources."""
    random, sums, count = np.random.default_rng(0), stokes_sums(dim), 1000
    targets, sources = random.normal(size=(dim, TARGETS)), 5 + random.normal(size=(dim, count))
    area, density = random.normal(size=(2, dim, count))
    out, zero = np.zeros((2, dim, TARGETS)), np.zeros((dim, TARGETS))

    def peer(name: str) -> Callable | None:
        if peers is None:
            return None
        arguments = TARGETS, targets, count, sources, area, density, out[1]
        return c_task(getattr(peers, f"{name}_{dim}d"), *arguments)

    pairs = TARGETS * count
    ours = sum_tasks(sums, targets, zero, sources, area, density, out[0])
    return [
        row(f"Stokes flow, {dim}D: sum of {name} layer", pairs, task, peer(name))
        for name, task in ours.items()
    ]


def sum_tasks(
    sums: Sums, at: Array, zero: Array, sources: Array, area: Array, density: Array, out: Array
) -> dict[str, Callable[[], None]]:
    """Sums of the single and the double layer."""
    return {
        "single": lambda: sums.single(at, sources, area, out),
        "double": lambda: sums.double(at, zero, sources, area, density, out),
    }


class _Nowhere:
    """A accumulator that keeps nothing."""

    def pairs(self, *_: object) -> None:
        """Forget."""


def block_row(panels: Panels, order: int, peers: ctypes.CDLL | None) -> tuple[str, ...]:
    """Table and product with all functions: the package beside code by hand."""
    count, nodes = 1024, tensor_nodes(panels, order)
    targets = np.random.default_rng(0).normal(size=(3, count)) + [[0.0], [0.0], [9.0]]
    pairs = by_blocks(np.ones((count, len(panels.flat_nets)), dtype=bool))
    kernel, theirs = stokes_3d.STOKES_3D, None
    if peers is not None:
        by_panel = (len(panels.flat_nets), order**2)
        position, normal = (
            np.ascontiguousarray(x.reshape(3, *by_panel).swapaxes(0, 1)) for x in nodes.flat
        )
        basis, out = np.ones((*by_panel, 9)), np.empty(len(panels.flat_nets) * count * 12 * 9)
        arguments = count, targets, *by_panel, position, normal, basis, out
        theirs = c_task(peers.panels_by_hand, *arguments)
        theirs = theirs if theirs() else None
    return row(
        f"Stokes flow, velocity, 3D: table and product, order {order}",
        count * nodes.weight.size,
        lambda: add_tensor(kernel, panels, order, targets, *pairs, _Nowhere()),
        theirs,
    )


def tables() -> list[Table]:
    """Kernels beside the same loops, and blocks beside intrinsics."""
    panels = split_patch(box((0, 0, 0), (1, 1, 1))[0].elevated((2, 2)))
    side = np.arange(1, 8) / 8
    panels = split_patch(panels.surface.inserted((side, side)))
    with tempfile.TemporaryDirectory() as folder:
        peers = compiled_c(folder)
        loops = [fill_row(name, kernel, peers) for name, kernel in FILLS.items()]
        loops += [r for dim in (3, 2) for r in sum_rows(dim, peers)]
        blocks = [block_row(panels, order, peers) for order in (4, 5, 7)]
    return [
        Table(
            "Kernels",
            "Thousand million pairs of a target and a source a second and core, beside the same "
            "loops in C by `gcc -O3 -march=native -ffast-math`, in turn. A table holds the single "
            "and the double layer's numbers of each pair.",
            HEAD,
            loops,
        ),
        Table(
            "Blocks of matrices",
            "The same for what assembly does with panels far away: fill a table, multiply it by "
            "the weighted functions of each panel. The peer is C by hand with AVX-512 intrinsics, "
            "whose reciprocal roots are approximated and refined, and which keeps each panel's "
            "table in registers and the nearest cache.",
            (HEAD[0], HEAD[1], "by hand", "package / by hand"),
            blocks,
        ),
    ]


if __name__ == "__main__":
    show(tables())
