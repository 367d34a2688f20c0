"""Bodies that move through unbounded viscous fluid, against exact solutions.

Drag 6πμaU and torque 8πμa³Ω of a sphere on three parametrisations; convergence where the
traction is no spline: a sphere held in a paraboloidal flow (Faxén) and an ellipsoid (Perrin);
two spheres along their line of centres (Stimson and Jeffery); a sphere near a wall (O'Neill,
Brenner), down to a gap of a hundredth of its radius.
"""

from math import pi

import cadbem as cb
from cadbem.verification.figures import rigid_bodies


def main(output: str = "results/moving_sphere", spans: int = 6) -> cb.StokesSolution:
    """Tables of errors, and a picture of the flow around a sphere.

    spans: elements a direction on a patch of the finest grids
    """
    folder = cb.run_folder(output)
    rigid_bodies.report_moving()
    rigid_bodies.report_convergence(range(2, spans + 1))
    rigid_bodies.report_pairs(max(1, spans // 2))
    rigid_bodies.report_walls(spans)

    # A sphere of radius 1 that moves along x in fluid of viscosity 1
    sphere = cb.Boundary(tuple(cb.Patch(surface, "body") for surface in cb.sphere()))
    motion = cb.RigidMotion(velocity=(1.0, 0.0, 0.0))
    problem = cb.StokesProblem(sphere.elevated(4), 1.0, {"body": motion}, cb.Quadrature(1e-10))
    solution = problem.solve()
    drag = solution.force("body")[0] / (-6 * pi)
    folder.summary({"points": solution.space.count, "drag / 6πμaU": drag})
    if folder:
        picture = cb.draw_around(solution, folder / "speed.png")
        print(f"\nthe speed around the sphere is in {picture}")
    return solution


if __name__ == "__main__":
    cb.run(main)
