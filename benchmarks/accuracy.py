"""Accuracy asked for and reached, case by case: ``python -m benchmarks.accuracy [ACCURACY ...]``.

Each case starts from its coarsest drawing and has a known answer: a closed form, a series, or an
independent value of ``tests/data/reference.json``.
"""

from __future__ import annotations

import json
import sys
import time
import warnings
from collections.abc import Callable
from pathlib import Path

import numpy as np

import cadbem as cb
from cadbem.boundary import Boundary, Patch
from cadbem.spline.outlines import line
from cadbem.spline.shapes import box, cylinder, ellipsoid, plate, sphere

REFERENCE = json.loads(
    (Path(__file__).parents[1] / "tests" / "data" / "reference.json").read_text()
)
GEOMETRIES = Path(__file__).parents[1] / "geometries"
SOLVE = Callable[[cb.StokesProblem], cb.StokesSolution]
Case = tuple[cb.StokesProblem, Callable[[cb.StokesSolution], np.ndarray], np.ndarray]


def duct(width: float, height: float = 1.0, length: float = 4.0) -> Case:
    """Pressure drop of a rectangular duct: 12 μ U L / (h² (1 - 192 h / (π⁵ w) Σ tanh(…) / n⁵))."""
    n = np.arange(1, 4001, 2)
    series = (np.tanh(n * np.pi * width / (2 * height)) / n**5.0).sum()
    exact = 12 * length / height**2 / (1 - 192 * height / (np.pi**5 * width) * series)
    boundary = Boundary(tuple(Patch(s) for s in box((0, 0, 0), (length, width, height))))
    ends = {"inlet": lambda x, n: n[0] > 0.9, "outlet": lambda x, n: n[0] < -0.9}
    return channel(boundary.named(rest="walls", **ends), exact)


def channel(boundary: Boundary, *exact: float) -> Case:
    """Mean pressures at one inlet, or two, where fluid enters with the mean velocity 1."""
    inlets = [n for n in boundary.names if n.startswith("inlet")]
    conditions: dict = {n: cb.Inflow(mean_velocity=1.0) for n in inlets}
    conditions |= {"outlet": cb.Pressure(0.0), "walls": cb.NoSlip()}
    problem = cb.StokesProblem(boundary, 1.0, conditions)
    return problem, lambda s: np.array([s.mean_pressure(n) for n in inlets]), np.array(exact)


def pipe() -> Case:
    """Poiseuille: 8 μ U L / R²."""
    ends = [Patch(s, n) for n, s in discs(1.0, 0.0, 4.0)]
    wall = [Patch(s, "walls") for s in cylinder(1.0, 4.0)]
    return channel(Boundary((*wall, *ends)), 32.0)


def discs(radius: float, *places: float) -> list[tuple[str, cb.Nurbs]]:
    """Discs across x, of one square and four patches around it, at an inlet and an outlet."""
    from cadbem.cad import read_cad

    read = read_cad(GEOMETRIES / "round_pipe.step")
    low, high = read.bounds()
    across = sum(
        p.quadrature(8)[1].sum() for p in read.patches
        if abs(p.middle().position[0, 0] - low[0]) < 1e-9 and abs(p.middle().normal[0, 0]) > 0.9
    )  # fmt: skip
    found = []
    for name, place, there in zip(("inlet", "outlet"), places, (low[0], high[0]), strict=True):
        for patch in read.patches:
            middle = patch.middle()
            if abs(middle.position[0, 0] - there) < 1e-9 and abs(middle.normal[0, 0]) > 0.9:
                size = radius * np.sqrt(np.pi / across)
                shift = np.array([place - size * there, 0, 0])
                found.append((name, patch.surface.transformed(size * np.eye(3), shift)))
    return found


def plane() -> Case:
    """Plane channel: 12 μ U L / h²."""
    corners = [(0, 0), (4, 0), (4, 1), (0, 1)]
    names = ["walls", "outlet", "walls", "inlet"]
    sides = [
        Patch(line(b, a), name)
        for a, b, name in zip(corners, corners[1:] + corners[:1], names, strict=True)
    ]
    return channel(Boundary(tuple(sides)), 48.0)


def pulled(shapes: dict[str, tuple], exact: np.ndarray, wall: tuple = (), along: int = 2) -> Case:
    """Drag of bodies that move with the velocity 1, alone or beside a wall."""
    patches = [Patch(s, name) for name, surfaces in shapes.items() for s in surfaces]
    patches += [Patch(s, "wall") for s in wall]
    motion = cb.RigidMotion(tuple(np.eye(3)[along]))
    conditions: dict = {name: motion for name in shapes}
    conditions |= {"wall": cb.NoSlip()} if wall else {}
    problem = cb.StokesProblem(Boundary(tuple(patches)), 1.0, conditions)
    return problem, lambda s: np.array([-s.force(n)[along] for n in shapes]), np.atleast_1d(exact)


def sphere_in_pipe(radius: float, moves: bool) -> Case:
    """Haberman and Sayre: K₁ of a sphere pulled, K₂ of one held in a flow of axial velocity 1."""
    value = TUBE[radius][0 if moves else 1]
    half = 3.0
    patches = [Patch(s, "walls") for s in cylinder(1.0, 2 * half, (-half, 0, 0))]
    patches += [Patch(s, n) for n, s in discs(1.0, -half, half)]
    patches += [Patch(s, "body") for s in sphere(radius)]
    conditions = {
        "walls": cb.NoSlip(),
        "inlet": cb.NoSlip() if moves else cb.Inflow(mean_velocity=0.5),
        "outlet": cb.Pressure(0.0),
        "body": cb.RigidMotion((1.0, 0, 0)) if moves else cb.RigidMotion(),
    }
    problem = cb.StokesProblem(Boundary(tuple(patches)), 1.0, conditions)
    exact = 6 * np.pi * radius * value
    return problem, lambda s: np.array([abs(s.force("body")[0])]), np.array([exact])


def junction(name: str, *exact: float) -> Case:
    """A junction of the folder ``geometries``; exact are values of overrefined runs."""
    return channel(cb.read_cad(GEOMETRIES / f"{name}.step"), *exact)


TUBE = {0.4: (3.591373, 3.215737), 0.5: (5.947374, 4.995339)}  # K₁ and K₂ by the radius
SIX_PI = 6 * np.pi
CASES: dict[str, Callable[[], Case]] = {
    "square duct": lambda: duct(1.0),
    "duct 3 : 2": lambda: duct(1.5),
    "duct 4 : 1": lambda: duct(4.0),
    "round pipe": pipe,
    "plane channel": plane,
    "sphere": lambda: pulled({"body": sphere()}, SIX_PI),
    "ellipsoid 2 : 1 : 1": lambda: pulled(
        {"body": ellipsoid((2, 1, 1))},
        float(REFERENCE["ellipsoid_drag"]["(2, 1, 1)"]["F_over_muU"][0]), along=0,
    ),  # fmt: skip
    "two spheres": lambda: pulled(
        {"low": sphere(1, (0, 0, -1.5)), "high": sphere(1, (0, 0, 1.5))},
        SIX_PI * float(REFERENCE["two_spheres_in_line_stimson_jeffery"]["1.5"]) * np.ones(2),
    ),
    "sphere 0.1 from a wall": lambda: pulled(
        {"body": sphere(1, (0, 0, 1.1))}, SIX_PI * 11.4591572034095570,
        plate(2.0, 200.0, degree=1, spans=1, rings=6),
    ),  # fmt: skip
    "sphere 0.05 from a wall": lambda: pulled(
        {"body": sphere(1, (0, 0, 1.05))}, SIX_PI * 21.585820,
        plate(2.0, 200.0, degree=1, spans=1, rings=6),
    ),  # fmt: skip
    "sphere in a pipe, 0.4, pulled": lambda: sphere_in_pipe(0.4, True),
    "sphere in a pipe, 0.4, held": lambda: sphere_in_pipe(0.4, False),
    "sphere in a pipe, 0.5, pulled": lambda: sphere_in_pipe(0.5, True),
    "sphere in a pipe, 0.5, held": lambda: sphere_in_pipe(0.5, False),
}


def measure(case: Case, accuracy: float) -> tuple[float, float, int, float, bool]:
    """True and estimated relative error, points, CPU seconds, and whether it warned."""
    problem, numbers, exact = case
    begin = time.process_time()
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        solution = problem.solve(accuracy)
    seconds = time.process_time() - begin
    error = float((abs(numbers(solution) - exact) / abs(exact).max()).max())
    warned = any(issubclass(w.category, cb.AccuracyWarning) for w in caught)
    estimates = [
        e.relative for e in solution.accuracy.estimates if not e.quantity.startswith("velocity")
    ]
    return error, max(estimates), solution.space.count, seconds, warned


def main() -> None:
    """The table, a line a case and accuracy."""
    chosen = [a for a in sys.argv[1:] if a in CASES] or list(CASES)
    accuracies = [float(a) for a in sys.argv[1:] if a not in CASES] or [1e-2, 1e-3]
    print("| case | asked | error | estimate | points | CPU s | |\n|---|---|---|---|---|---|---|")
    for name in chosen:
        for accuracy in accuracies:
            error, estimate, points, seconds, warned = measure(CASES[name](), accuracy)
            remark = "above" if error > accuracy else ""
            remark += " low" if estimate < error / 3 else " high" if estimate > 20 * error else ""
            print(
                f"| {name} | {accuracy:g} | {error:.1e} | {estimate:.1e} | {points} | "
                f"{seconds:.1f} | {'warned ' if warned else ''}{remark} |", flush=True,
            )  # fmt: skip


if __name__ == "__main__":
    main()
