"""Compressed layers: memory, time and accuracy beside dense matrices and a fast multipole library.

    python -m benchmarks.compressed

Each case is a process of its own.  The comparison with fast multipoles needs `pip install fmm3dpy`.
"""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Callable
from importlib.util import find_spec

import numpy as np

import cadbem as cb
from benchmarks.runs import peak
from benchmarks.table import Table, fresh, show
from cadbem.operators.compressed.iterate import Iteration
from cadbem.operators.compressed.sources import PanelList, sources
from cadbem.operators.panels import split_patch

DENSE, LARGE = (0.5, 0.33, 0.25), (0.16, 0.087)  # sizes of the serpentine's elements
EXACT_GRADIENT = -28.454153769562279  # square channel, in viscosity U / W²
LENGTH = 26.0  # of the serpentine, roughly, in widths
SPANS = 42  # elements across the square channel, of degree 3: some 20 000 points
TOLERANCE, QUADRATURE = 1e-7, 1e-6
CONDITIONS = {
    "inlet": cb.Inflow(mean_velocity=1.0),
    "outlet": cb.Pressure(0.0),
    "walls": cb.NoSlip(),
}
Row = tuple[str, ...]


def cpu_seconds(task: Callable[[], object]) -> float:
    start = time.process_time()
    task()
    return time.process_time() - start


def serpentine(size: float, storage: cb.Compressed | cb.Dense) -> cb.StokesProblem:
    channel = cb.read_cad("geometries/serpentine.step").elevated(2).refined(size=size)
    return cb.StokesProblem(channel, 1.0, CONDITIONS, cb.Quadrature(QUADRATURE), storage=storage)


def square(spans: int, tolerance: float) -> cb.StokesProblem:
    channel = cb.read_cad("geometries/square_channel.step").elevated(3).refined(size=1 / spans)
    rules = cb.Quadrature(tolerance)
    return cb.StokesProblem(channel, 1.0, CONDITIONS, rules, storage=cb.Compressed(tolerance))


def solved(problem: cb.StokesProblem, length: float) -> dict[str, float]:
    """What a solution costs, and what comes of it."""
    assembly = cpu_seconds(lambda: (problem.layers, problem.constraints, problem.system.factors))
    start = time.process_time()
    flow = problem.solve()
    solution = time.process_time() - start
    drop = flow.mean_pressure("inlet") - flow.mean_pressure("outlet")
    numbers = {
        "points": problem.space.count, "assembly": assembly, "solution": solution,
        "iterations": flow.iterations, "peak": peak(), "gradient": -drop / length,
        "flux": flow.net_flux(), "force": flow.net_force(),
    }  # fmt: skip
    factors = problem.system.factors
    if isinstance(factors, Iteration):
        density = np.random.default_rng(0).normal(size=factors.scale.shape)
        apply = min(cpu_seconds(lambda: factors.matrix.apply(density)) for _ in range(5))
        near = factors.matrix.near.entries.nbytes / 1e6
        numbers |= {"near": near, "far": factors.matrix.size / 1e6 - near, "apply": apply}
    return numbers


def multipoles(problem: cb.StokesProblem) -> dict[str, float]:
    """A product with the compressed layers, and the fast multipole method over as many Stokeslets
    as there are points, and over the nodes of the far field: CPU seconds, in turn."""
    if find_spec("fmm3dpy") is None:
        return {}
    from fmm3dpy import stfmm3d

    factors, position = problem.system.factors, problem.space.collocation.position
    assert isinstance(factors, Iteration)
    split = tuple(split_patch(p.surface) for p in problem.boundary.patches)
    nodes = sources(PanelList.of(problem.space, split), (4,) * len(split)).position
    random = np.random.default_rng(0)
    density = random.normal(size=factors.scale.shape)
    elsewhere = position + 1e-3 * random.normal(size=position.shape)
    rounds = []
    for _ in range(2):
        own = min(cpu_seconds(lambda: factors.matrix.apply(density)) for _ in range(3))
        others = [
            cpu_seconds(
                lambda s=s: stfmm3d(
                    eps=1e-6, sources=s, stoklet=random.normal(size=s.shape), targets=position,
                    ifppregtarg=1,
                )
            )
            for s in (elsewhere, nodes)
        ]  # fmt: skip
        rounds.append([own, *others])
    own, few, many = np.min(rounds, axis=0)
    return {"nodes": nodes.shape[1], "own": own, "few": few, "many": many}


def growth_rows(cases: dict[float, dict[str, float]]) -> list[Row]:
    """Dense as far as it goes, and compressed."""
    rows = []
    for size, one in cases.items():
        row = [f"{one['points']}", f"{one['near']:.0f}", f"{one['far']:.0f}", f"{one['peak']:.0f}",
               f"{one['assembly']:.1f}", f"{one['solution']:.1f}", f"{one['iterations']}",
               f"{one['apply']:.3f}", f"{one['force']:.1e}"]  # fmt: skip
        if size in DENSE:
            other = fresh("compressed", "serpentine", str(size), "dense")
            error = abs(one["gradient"] / other["gradient"] - 1)
            seconds = other["assembly"] + other["solution"]
            row += [f"{other['peak']:.0f}", f"{seconds:.1f}", f"{error:.0e}"]
        else:
            row += [f"({21 * 8e-6 * one['points'] ** 2:.0f})", "-", "-"]
        rows.append(tuple(row))
    return rows


def exact_rows() -> list[Row]:
    """The square channel against the series of duct flow."""
    rows = []
    for spans, tolerance in ((12, 1e-7), (24, 1e-7), (SPANS, 1e-7)):
        one = fresh("compressed", "square", str(spans), str(tolerance))
        rows.append((
            f"{one['points']}", f"{tolerance:g}", f"{one['near'] + one['far']:.0f}",
            f"{one['peak']:.0f}", f"{one['assembly']:.0f}", f"{one['solution']:.0f}",
            f"{one['iterations']}", f"{one['gradient'] / EXACT_GRADIENT - 1:+.1e}",
            f"{one['flux']:.0e}", f"{one['force']:.0e}",
        ))  # fmt: skip
    return rows


def multipole_rows(one: dict[str, float]) -> list[Row]:
    """One row, or why there is none."""
    if "own" not in one:
        return [("fmm3dpy is not installed", "", "", "", "", "", "")]
    own, few, many = one["own"], one["few"], one["many"]
    return [(
        f"{one['points']}", f"{own:.3f}", f"{few:.1f}", f"{few / own:.0f}",
        f"{one['nodes']}", f"{many:.1f}", f"{many / own:.0f}",
    )]  # fmt: skip


def tables() -> list[Table]:
    """Growth beside dense matrices, an exact flow, fast multipoles."""
    cases = {size: fresh("compressed", "serpentine", str(size), "large") for size in DENSE + LARGE}
    return [
        Table(
            "Compressed and dense layers",
            "The serpentine of 42 patches, degree 2, ever finer; quadrature tolerance "
            f"{QUADRATURE:g}, Compressed({TOLERANCE:g}).  Megabytes of near and far blocks and at "
            "most; CPU seconds to assemble (preconditioner included), to solve, and of one product;"
            " net force over forces.  Then dense layers: megabytes at most (in brackets what the "
            "matrices would take), CPU seconds in all, relative difference of the pressure drops.",
            ("Points", "near", "far", "peak", "assembly", "solution", "iterations", "product",
             "net force", "dense: peak", "seconds", "difference"),
            growth_rows(cases),
        ),
        Table(
            "20 000 points against an exact flow",
            "The square channel of length 2, degree 3; the error is that of the pressure gradient "
            "against the series of duct flow.  Megabytes and CPU seconds as above.",
            ("Points", "tolerance", "matrix", "peak", "assembly", "solution", "iterations", "error",
             "net flux", "net force"),
            exact_rows(),
        ),
        Table(
            "Products beside fast multipoles",
            "CPU seconds of one product of the serpentine's compressed layers, near field "
            "included, and of fmm3dpy's stfmm3d at 1e-6 from as many Stokeslets as there are "
            "points, and from the 4 x 4 nodes a panel that a far field takes, to the points.",
            ("Points", "product", "fmm3dpy", "times", "nodes", "fmm3dpy", "times"),
            multipole_rows(cases[LARGE[-1]]),
        ),
    ]  # fmt: skip


def main(words: list[str]) -> None:
    """A case by its words, as JSON; without words all tables."""
    match words:
        case []:
            show(tables())
            return
        case ["serpentine", size, "dense"]:
            numbers = solved(serpentine(float(size), cb.Dense()), LENGTH)
        case ["serpentine", size, "large"]:
            problem = serpentine(float(size), cb.Compressed(TOLERANCE))
            numbers = solved(problem, LENGTH)
            if float(size) == LARGE[-1]:
                numbers |= multipoles(problem)
        case ["square", spans, tolerance]:
            numbers = solved(square(int(spans), float(tolerance)), 2.0)
        case _:
            raise SystemExit(__doc__)
    print(json.dumps(numbers))


if __name__ == "__main__":
    main(sys.argv[1:])
