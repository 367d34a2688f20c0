"""Bodies that move through unbounded viscous fluid, on finer and finer grids."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from math import pi

import numpy as np

from cadbem.problems.conditions import Condition, NoSlip, RigidMotion
from cadbem.problems.stokes import StokesProblem
from cadbem.quadrature import Quadrature
from cadbem.spline.nurbs import Nurbs
from cadbem.spline.shapes import ellipsoid, sphere, sphere_octants, sphere_with_poles
from cadbem.verification.spheres import (
    BROADSIDE,
    ENDWISE,
    MOTION,
    PARABOLOID,
    SLIDING,
    WALL,
    flow_around,
)
from cadbem.verification.walls import near_wall

Shape = Callable[[], tuple[Nurbs, ...]]
SPHERES: tuple[tuple[Shape, int], ...] = (
    (sphere, 4),
    (sphere_octants, 2),
    (sphere_with_poles, 2),
)
PAIRS = {3.0: 0.804721760669963725, 2.0: 0.742258285069086028, 1.5: 0.698304560250037017}
NEARER = {1.543080634815: (1.5674594248346199, 1.0998032148298433, 3.0360643803152062)}
WALLS = dict(sorted((WALL | NEARER).items(), reverse=True))


def report_moving() -> None:
    """A moving and turning sphere.  The traction of one that moves is constant, that of one that
    turns linear in position: both lie in the span of the sphere's own functions, and the error is
    that of the integrals."""
    heading("moving and turning sphere", "shape", "degree", "points", "drag", "torque")
    for shape, lowest in SPHERES:
        for degree in (lowest, lowest + 1):
            solution = flow_around(shape(), degree, 2, MOTION, tolerance=1e-11)
            drag = solution.force("body")[0] / (-6 * pi) - 1
            torque = solution.torque("body", (0, 0, 0))[1] / (-8 * pi) - 1
            row(getattr(shape, "__name__", ""), degree, solution.space.count, drag, torque)


def report_convergence(counts: range) -> None:
    """Where the traction is no spline, in the number of spans along each side of a patch: a sphere
    held in a paraboloidal flow (Faxén), an ellipsoid (Perrin)."""

    def faxen(shape: Shape, degree: int, n: int) -> tuple[int, float]:
        held = flow_around(shape(), degree, n, NoSlip(), PARABOLOID)
        return held.space.count, float(held.force("body")[0] / (2 * pi) - 1)

    def perrin(degree: int, n: int) -> tuple[int, float]:
        pulled = flow_around(ellipsoid((2, 1, 1)), degree, n, RigidMotion((1.0, 1.0, 1.0)))
        exact = (ENDWISE, BROADSIDE, BROADSIDE)
        return pulled.space.count, float(abs(pulled.force("body") / exact + 1).max())

    for shape, degree in ((sphere_octants, 2), (sphere_octants, 3), (sphere, 4)):
        title = f"{shape.__name__}, degree {degree}, held in a paraboloidal flow"
        convergence(title, counts, [faxen(shape, degree, n) for n in counts])
    convergence("ellipsoid 2 : 1 : 1, degree 4, pulled", counts, [perrin(4, n) for n in counts])


def report_pairs(spans: int) -> None:
    """Two spheres along their line of centres (Stimson and Jeffery)."""
    heading("two spheres along their line of centres", "distance / 2a", "points", "drag")
    for ratio, exact in PAIRS.items():
        low, high = (sphere(centre=(0, 0, side * ratio)) for side in (-1, 1))
        pair = flow_around(low + high, 4, spans, RigidMotion((0.0, 0.0, 1.0)))
        row(ratio, pair.space.count, pair.force("body")[2] / (-12 * pi * exact) - 1)


def report_walls(spans: int) -> None:
    """A sphere near a wall, a thin plate, whose traction is that of both its sides together
    (O'Neill, Brenner).

    Moving along x and z and turning about x: by symmetry the drag along x, the drag along z and
    the torque about x are those of each motion alone.
    """
    titles = "height / a", "points", "drag along", "torque", "drag away"
    heading("sphere near a wall, a plate of 100 a", *titles)
    for height, exact in WALLS.items():
        elements = spans + 2 if height > 1.05 else 2 * spans + 2
        boundary = near_wall(height, elements, rings=2 * spans + 3, across=spans)
        motion = replace(SLIDING, centre=(0.0, 0.0, height))
        conditions: dict[str, Condition] = {"body": motion, "wall": NoSlip()}
        near = StokesProblem(boundary, 1.0, conditions, Quadrature(1e-6)).solve()
        force, torque = near.force("body"), near.torque("body", (0, 0, height))
        reached = np.array([force[0] / 6, torque[0] / 8, force[2] / 6]) / -pi
        row(height, near.space.count, *(float(e) for e in reached / exact - 1))


def convergence(title: str, counts: range, results: list[tuple[int, float]]) -> None:
    """A table of errors on grids with ``counts`` spans, and the slope."""
    heading(title, "spans", "points", "drag")
    for n, (points, error) in zip(counts, results, strict=True):
        row(n, points, error)
    errors = [abs(error) for _, error in results]
    slope = -np.polyfit(np.log(counts), np.log(errors), 1)[0] if len(errors) > 1 else np.nan
    print(f"  fitted slope {slope:.1f}")


def heading(title: str, *columns: str) -> None:
    """What a table shows."""
    print(f"\n{title}: relative errors")
    row(*columns)


def row(*values: object) -> None:
    """A line of a table, as soon as it is known."""
    cells = [f"{v:+.2e}" if isinstance(v, float) and abs(v) < 1e-1 else f"{v}" for v in values]
    print("  " + "".join(f"{cell:>18}" for cell in cells), flush=True)
