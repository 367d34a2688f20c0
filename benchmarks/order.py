"""How fast the pressure of the Y-junction converges: ``python -m benchmarks.order``.

Its edges are re-entrant, so that tractions are infinite there.  Elements that ``solve(accuracy)``
chooses are compared with even ones.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

import cadbem as cb
from benchmarks.accuracy import GEOMETRIES, channel

EXACT = 44.9578  # mean pressure at both inlets: overrefined runs agree on it to 2e-6
ACCURACIES = (1e-2, 3e-3, 1e-3, 3e-4, 1e-4, 3e-5)
EVEN = (4, 6, 8)  # elements of degree 2 a patch and direction

Run = tuple[str, int, float]  # what was asked, points, error


def adaptive(accuracy: float) -> Run:
    """With elements chosen for an accuracy."""
    problem, numbers, exact = channel(cb.read_cad(GEOMETRIES / "y_junction.step"), EXACT, EXACT)
    solution = problem.solve(accuracy, goal="openings")
    error = float(abs(numbers(solution) / exact - 1).max())
    return f"accuracy {accuracy:g}", solution.space.count, error


def even(count: int) -> Run:
    """With even elements of degree 2."""
    boundary = cb.read_cad(GEOMETRIES / "y_junction.step").elevated(2).refined(count)
    problem, numbers, exact = channel(boundary, EXACT, EXACT)
    solution = problem.solve()
    error = float(abs(numbers(solution) / exact - 1).max())
    return f"refined({count})", solution.space.count, error


def order(runs: Sequence[Run]) -> float:
    """Slope of the error over the square root of the number of points, by least squares."""
    points, errors = (np.log([run[k] for run in runs]) for k in (1, 2))
    return -float(np.polyfit(0.5 * points, errors, 1)[0])


def main() -> None:
    """Both tables, with the orders."""
    families: list[tuple[Callable, Sequence]] = [(adaptive, ACCURACIES), (even, EVEN)]
    for family, values in families:
        runs = [family(value) for value in values]
        print("| elements | points | error |\n|---|---|---|")
        print("\n".join(f"| {name} | {points} | {error:.1e} |" for name, points, error in runs))
        print(f"order {order(runs):.1f}\n")


if __name__ == "__main__":
    main()
