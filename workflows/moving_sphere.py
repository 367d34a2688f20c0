"""Bodies that move through unbounded viscous fluid, against exact solutions.

Drag 6πμaU and torque 8πμa³Ω of a sphere on three parametrisations; convergence where the
traction is no spline: a sphere held in a paraboloidal flow (Faxén) and an ellipsoid (Perrin);
two spheres along their line of centres (Stimson and Jeffery); a sphere near a wall (O'Neill,
Brenner), down to a gap of a hundredth of its radius.
"""

from collections.abc import Callable
from dataclasses import replace
from math import pi

import numpy as np

import cadbem as cb
from cadbem.spline.shapes import sphere_with_poles
from cadbem.verification.walls import near_wall

MOTION = cb.RigidMotion(velocity=(1.0, 0.0, 0.0), angular_velocity=(0.0, 1.0, 0.0))
SPHERES = ((cb.sphere, 4), (cb.sphere_octants, 2), (sphere_with_poles, 2))
DRAG_211 = (22.6937530132454298, 25.9916348835661665, 25.9916348835661665)  # axes 2, 1, 1
PAIRS = {3.0: 0.804721760669963725, 2.0: 0.742258285069086028, 1.5: 0.698304560250037017}
WALL = {  # height of the centre: drag along the wall, torque, drag away from it
    2.0: (1.3827523824112236, 1.0417835548066146, 2.1255355667600392),
    1.543080634815: (1.5674594248346199, 1.0998032148298433, 3.0360643803152062),
    1.1: (2.2643030353880422, 1.454851210016983, 11.4591572034095570),
    1.01: (3.4225329663656340, 2.2407976493685187, 101.8961723246098223),
}
SLIDING = cb.RigidMotion(velocity=(1.0, 0.0, 1.0), angular_velocity=(1.0, 0.0, 0.0))
PARABOLOID = cb.Background(
    velocity=lambda x: np.array([x[2] ** 2, 0 * x[0], 0 * x[0]]), pressure=lambda x: 2 * x[0]
)


def main(output: str = "results/moving_sphere", spans: int = 6) -> cb.StokesSolution:
    folder = cb.run_folder(output)
    report_exact()
    report_convergence(range(2, spans + 1))
    report_pairs(max(1, spans // 2))
    report_wall(spans)
    solution = solve(cb.sphere(), 4, 1, cb.RigidMotion((1.0, 0.0, 0.0)))
    drag = solution.force("body")[0] / (-6 * pi)
    folder.summary({"points": solution.space.count, "drag / 6πμaU": drag})
    if folder:
        picture = cb.draw_around(solution, folder / "speed.png")
        print(f"\nthe speed around the sphere is in {picture}")
    return solution


def report_exact() -> None:
    """Drag and torque of a moving and turning sphere."""
    # The traction of a moving sphere is constant, that of a turning one linear in position: both
    # lie in the span of the sphere's own functions, and the error is that of the integrals
    heading("moving and turning sphere", "shape", "degree", "points", "drag", "torque")
    for shape, lowest in SPHERES:
        for degree in (lowest, lowest + 1):
            solution = solve(shape(), degree, 2, MOTION, tolerance=1e-11)
            drag = solution.force("body")[0] / (-6 * pi) - 1
            torque = solution.torque("body", (0, 0, 0))[1] / (-8 * pi) - 1
            row(shape.__name__, degree, solution.space.count, drag, torque)


def report_convergence(counts: range) -> None:
    """Convergence in the number of spans n along each side of a patch."""

    def faxen(shape: Callable, degree: int, n: int) -> tuple[int, float]:
        held = solve(shape(), degree, n, cb.NoSlip(), background=PARABOLOID)
        return held.space.count, float(held.force("body")[0] / (2 * pi) - 1)

    def perrin(degree: int, n: int) -> tuple[int, float]:
        pulled = solve(cb.ellipsoid((2, 1, 1)), degree, n, cb.RigidMotion((1.0, 1.0, 1.0)))
        return pulled.space.count, float(abs(pulled.force("body") / DRAG_211 + 1).max())

    for shape, degree in ((cb.sphere_octants, 2), (cb.sphere_octants, 3), (cb.sphere, 4)):
        title = f"{shape.__name__}, degree {degree}, held in a paraboloidal flow"
        convergence(title, counts, [faxen(shape, degree, n) for n in counts])
    convergence("ellipsoid 2 : 1 : 1, degree 4, pulled", counts, [perrin(4, n) for n in counts])


def report_pairs(spans: int) -> None:
    """Two spheres along their line of centres."""
    heading("two spheres along their line of centres", "distance / 2a", "points", "drag")
    for ratio, exact in PAIRS.items():
        low, high = (cb.sphere(centre=(0, 0, side * ratio)) for side in (-1, 1))
        pair = solve(low + high, 4, spans, cb.RigidMotion((0.0, 0.0, 1.0)))
        row(ratio, pair.space.count, pair.force("body")[2] / (-12 * pi * exact) - 1)


def report_wall(spans: int) -> None:
    """A sphere near a thin plate, whose traction is that of both its sides together."""
    # Moving along x and z and turning about x: by symmetry the drag along x, the drag along z and
    # the torque about x are those of each motion alone
    titles = "height / a", "points", "drag along", "torque", "drag away"
    heading("sphere near a wall, a plate of 100 a", *titles)
    for height, exact in WALL.items():
        elements = spans + 2 if height > 1.05 else 2 * spans + 2
        boundary = near_wall(height, elements, rings=2 * spans + 3, across=spans)
        motion = replace(SLIDING, centre=(0.0, 0.0, height))
        conditions = {"body": motion, "wall": cb.NoSlip()}
        near = cb.StokesProblem(boundary, 1.0, conditions, cb.Quadrature(1e-6)).solve()
        force, torque = near.force("body"), near.torque("body", (0, 0, height))
        reached = np.array([force[0] / 6, torque[0] / 8, force[2] / 6]) / -pi
        row(height, near.space.count, *(float(e) for e in reached / exact - 1))


def bodies(shape: tuple[cb.Nurbs, ...], degree: int, spans: int) -> cb.Boundary:
    patches = tuple(cb.Patch(surface, "body") for surface in shape)
    return cb.Boundary(patches).elevated(degree).refined(spans)


def solve(
    shape: tuple[cb.Nurbs, ...],
    degree: int,
    spans: int,
    condition: cb.RigidMotion | cb.NoSlip,
    *,
    tolerance: float = 1e-10,
    **options: cb.Background,
) -> cb.StokesSolution:
    return cb.StokesProblem(
        bodies(shape, degree, spans),
        viscosity=1.0,
        conditions={"body": condition},
        quadrature=cb.Quadrature(tolerance),
        **options,
    ).solve()


def convergence(title: str, counts: range, results: list[tuple[int, float]]) -> None:
    heading(title, "spans", "points", "drag")
    for n, (points, error) in zip(counts, results, strict=True):
        row(n, points, error)
    errors = [abs(error) for _, error in results]
    slope = -np.polyfit(np.log(counts), np.log(errors), 1)[0] if len(errors) > 1 else np.nan
    print(f"  fitted slope {slope:.1f}")


def heading(title: str, *columns: str) -> None:
    print(f"\n{title}: relative errors")
    row(*columns)


def row(*values: object) -> None:
    cells = [f"{v:+.2e}" if isinstance(v, float) and abs(v) < 1e-1 else f"{v}" for v in values]
    print("  " + "".join(f"{cell:>18}" for cell in cells), flush=True)


if __name__ == "__main__":
    cb.run(main)
