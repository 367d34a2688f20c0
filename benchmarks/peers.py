"""Inlet pressures of channels beside finite elements: ``python -m benchmarks.peers [CASE ...]``.

Both codes read the same STEP file.  The finite elements are NGSolve's, which is no requirement of
cadbem and which this benchmark alone needs: ``pip install ngsolve``.  Cases are those of
``peers_cases``; their pressures come from overrefined runs of both codes.
"""

from __future__ import annotations

import sys
import time
import warnings
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from functools import partial

import cadbem as cb
from benchmarks.peers_cases import CHANNELS, Channel, Elements
from benchmarks.table import Table, show

NEEDS = "ngsolve"
ACCURACIES = (1e-2, 1e-3, 1e-4)
SIZES = {  # of elements by the order of velocities, over the width of the channel
    2: (0.5, 0.35, 0.25, 0.18),
    3: (0.7, 0.5, 0.35, 0.25, 0.18),
    4: (1.0, 0.7, 0.5, 0.35),
    5: (1.0, 0.7, 0.5),
}
AT_EDGES: tuple[dict, ...] = ({"levels": 1}, {"levels": 2}, {"near": 0.1})
ELSEWHERE: tuple[dict, ...] = ({}, {"care": True})  # refinement where no edge is re-entrant
TOO_LONG = 15.0  # CPU seconds of a run of finite elements, after which none is finer
BRIEF, ROUNDS = 5.0, 3  # shorter runs are measured several times, and the shortest time taken
TEXT = """Mean pressures at the inlets, where developed flow enters with the mean velocity 1; the
outlet has no tangential velocity and the pressure 0.  An error is the largest of all inlets over
the largest pressure.  The true pressures are those of overrefined runs; beside the name stands
the share to which both codes agree on them: errors that are no larger say nothing more.

cadbem is asked for an accuracy and chooses its elements itself: its time is that of all rounds,
from the boundary that was read to the answer, and it does not know the true values.  Of NGSolve
(Taylor-Hood tetrahedra, curved, prisms along re-entrant edges; sparse Cholesky factors after
elimination inside elements) the table shows the cheapest of all runs whose error turned out
below the accuracy: meshing, assembly and solution, but neither the search for that run nor an
estimate of its error.  A ratio above 1 says that cadbem takes less time; one in brackets
that it missed the accuracy, and "warned" that it said so.  Errors of finite elements change sign,
so that some of these cheapest runs are lucky.  Their mean pressures are weighted by the profile
(the power over the flow), which is the plain mean where flow is developed and far more accurate."""
HEAD = ("Case", "asked", "cadbem error", "CPU s", "points", "NGSolve error", "CPU s", "order",
        "unknowns", "NGSolve / cadbem")  # fmt: skip


@dataclass(frozen=True)
class Run:
    """Pressures, CPU seconds, unknowns or points, and a remark or the order."""

    pressures: tuple[float, ...]
    seconds: float
    size: int
    remark: str = ""

    def error(self, channel: Channel) -> float:
        """Largest error over the largest pressure."""
        pairs = zip(self.pressures, channel.pressures, strict=True)
        return max(abs(p - exact) for p, exact in pairs) / max(channel.pressures)


def boundary_elements(channel: Channel, accuracy: float) -> Run:
    """Pressures by cadbem."""
    boundary = channel.boundary()
    inlets = sorted(n for n in boundary.names if n.startswith("inlet"))
    conditions: dict = {n: cb.Inflow(mean_velocity=1.0) for n in inlets}
    conditions |= {"outlet": cb.Pressure(0.0), "walls": cb.NoSlip()}
    begin = time.process_time()
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        problem = cb.StokesProblem(boundary, 1.0, conditions)
        solution = problem.solve(accuracy, goal="openings")
    pressures = tuple(solution.mean_pressure(n) for n in inlets)
    seconds = time.process_time() - begin
    warned = any(issubclass(w.category, cb.AccuracyWarning) for w in caught)
    return Run(pressures, seconds, solution.space.count, " warned" if warned else "")


def finite_elements(channel: Channel) -> Iterator[tuple[Elements, Run]]:
    """Runs of NGSolve: all orders, sizes and refinements until they are accurate or too long."""
    for refinement in AT_EDGES if channel.edges else ELSEWHERE:
        scaled = {k: v * channel.width if k == "near" else v for k, v in refinement.items()}
        for order, sizes in SIZES.items():
            for size in sizes:
                elements = Elements(order, size * channel.width, **scaled)
                run = by_elements(channel, elements)
                error = run.error(channel)
                said = f"{elements} {run.pressures} {error:.1e} {run.seconds:.1f} s"
                print(said, file=sys.stderr, flush=True)
                yield elements, run
                if run.seconds > TOO_LONG or error < min(ACCURACIES) / 2:
                    break


def by_elements(channel: Channel, elements: Elements) -> Run:
    """Pressures by NGSolve."""
    from benchmarks.peers_elements import solved

    begin = time.process_time()
    pressures, unknowns = solved(channel, elements)
    return Run(pressures, time.process_time() - begin, unknowns, str(elements.order))


def steady(run: Callable[[], Run], first: Run) -> Run:
    """The least time of several rounds, if they are brief."""
    again = ROUNDS - 1 if first.seconds < BRIEF else 0
    return replace(first, seconds=min([first.seconds, *(run().seconds for _ in range(again))]))


def rows(name: str) -> list[tuple[str, ...]]:
    """Lines of the table for one channel."""
    channel, lines = CHANNELS[name], []
    channel.file()
    ours = {}
    for accuracy in ACCURACIES:
        first = boundary_elements(channel, accuracy)
        ours[accuracy] = steady(partial(boundary_elements, channel, accuracy), first)
        print(f"cadbem {accuracy:g} {ours[accuracy]}", file=sys.stderr, flush=True)
    theirs = list(finite_elements(channel))
    for accuracy in ACCURACIES:
        enough = [both for both in theirs if both[1].error(channel) <= accuracy]
        best = None
        if enough:
            elements, first = min(enough, key=lambda both: both[1].seconds)
            best = steady(partial(by_elements, channel, elements), first)
        lines.append(_row(name, channel, accuracy, ours[accuracy], best))
    return lines


def _row(
    name: str, channel: Channel, accuracy: float, ours: Run, theirs: Run | None
) -> tuple[str, ...]:
    error = ours.error(channel)
    cells = [f"{name}, {channel.doubt:.0e}", f"{accuracy:.0e}", f"{error:.1e}{ours.remark}"]
    cells += [f"{ours.seconds:.1f}", str(ours.size)]
    if theirs is None:
        return (*cells, "none", "", "", "", "")
    ratio = f"{theirs.seconds / ours.seconds:.2f}"
    cells += [f"{theirs.error(channel):.1e}", f"{theirs.seconds:.1f}", theirs.remark]
    return (*cells, str(theirs.size), ratio if error <= accuracy else f"({ratio})")


def tables(names: Iterable[str] = CHANNELS) -> Iterator[Table]:
    """Cost of an accuracy, channel by channel."""
    boundary_elements(CHANNELS["bent pipe"], 1e-2)  # compiles
    lines = [line for name in names for line in rows(name)]
    yield Table("Inlet pressures of channels beside finite elements", TEXT, HEAD, lines)


if __name__ == "__main__":
    show(tables(sys.argv[1:] or CHANNELS))
