"""Heat conduction in a hollow sphere that convects and radiates, against the exact solution.

Lengths in units of the inner radius, temperatures in units of the surroundings' temperature:
1 < r < 2, φ = 2 inside, Bi = Bi_r = 1 outside.  Then φ = 2 + C (1/r - 1), where the heat
C / 4 = (φ - 1) + (φ⁴ - 1) leaves at r = 2.

Temperature and flux of this solution are constant on each sphere, so that the error is that of
the quadrature alone.  How it falls with refinement, an uneven temperature shows, 1 / |x - a|.
"""

import numpy as np
from scipy.optimize import brentq

import cadbem as cb
from cadbem.post.style.plots import Curve, Plot, draw_plots, fitted_order
from cadbem.verification.heat import hollow_sphere

HEAT = brentq(lambda c: c / 4 - (1 - c / 2) - ((2 - c / 2) ** 4 - 1), 0.0, 4.0, xtol=1e-15)
RADII = np.linspace(1.05, 1.95, 25)
POLAR, OBLIQUE = np.array([0.0, 0.0, 1.0]), np.array([1.0, 2.0, 3.0]) / np.sqrt(14.0)
INSIDE_HOLE = np.array([[0.3], [0.2], [0.1]])


def exact(radii: np.ndarray) -> np.ndarray:
    return 2 + HEAT * (1 / radii - 1)


def uneven(points: np.ndarray) -> np.ndarray:
    return 1 / np.linalg.norm(points - INSIDE_HOLE, axis=0)


def uneven_flux(points: np.ndarray) -> np.ndarray:
    """Heat into the body at r = 2, -∂φ/∂n with n = -x / 2."""
    return -(points / 2 * (points - INSIDE_HOLE)).sum(axis=0) * uneven(points) ** 3


def solve(
    spans: int, tolerance: float, inner: cb.Temperature, outer: cb.HeatFlux | cb.SurfaceExchange
) -> cb.HeatSolution:
    problem = cb.HeatProblem(
        hollow_sphere().refined(spans),
        conductivity=1.0,
        conditions={"inner": inner, "outer": outer},
        quadrature=cb.Quadrature(tolerance),
    )
    return problem.solve()


def ray_error(solution: cb.HeatSolution, direction: np.ndarray) -> float:
    """Largest relative error of 25 temperatures on a ray through the wall."""
    temperature = solution.temperature_at(np.outer(direction, RADII))
    return float(abs(temperature / exact(RADII) - 1).max())


def main(output: str = "results/hollow_sphere_heat", finest: int = 4) -> cb.HeatSolution:
    folder = cb.run_folder(output)
    exchange = cb.SurfaceExchange(convection=1.0, radiation=1.0, ambient=1.0)
    counts, errors = [], []
    print("convection and radiation")
    print("points  tolerance  polar ray  oblique ray  heat rate")
    for tolerance in (1e-4, 1e-6, 1e-8):
        solution = solve(1, tolerance, cb.Temperature(2.0), exchange)
        polar, oblique = ray_error(solution, POLAR), ray_error(solution, OBLIQUE)
        heat = abs(solution.heat_rate("inner") / (4 * np.pi * HEAT) - 1)
        row = f"{polar:9.1e}  {oblique:11.1e}  {heat:9.1e}"
        print(f"{solution.space.count:6d}  {tolerance:9.0e}  {row}")

    print("uneven temperature")
    print("points  oblique ray  heat rate  order")
    points = np.outer(OBLIQUE, RADII)
    for spans in range(1, finest + 1):
        given = cb.Temperature(uneven), cb.HeatFlux(uneven_flux)
        other = solve(spans, 1e-9, *given)
        counts.append(other.space.count)
        errors.append(float(abs(other.temperature_at(points) / uneven(points) - 1).max()))
        heat = abs(other.heat_rate("inner") / (4 * np.pi) - 1)
        order = f"{fitted_order(counts, errors):5.2f}" if len(counts) > 1 else ""
        print(f"{counts[-1]:6d}  {errors[-1]:11.1e}  {heat:9.1e}  {order}")

    folder.summary({"points": counts[-1], "largest error on a ray": errors[-1]})
    if folder:
        fine = np.linspace(1, 2, 101)
        computed = solution.temperature_at(np.outer(POLAR, RADII))
        profile = [
            Curve(fine, exact(fine), "exact"),
            Curve(RADII, computed, "computed", line=False, marks=True),
        ]
        convergence = [Curve(counts, errors, "uneven temperature", marks=True)]
        plots = [
            Plot("collocation points", "largest relative error on a ray", convergence, True),
            Plot("r / inner radius", "temperature / surroundings'", profile),
        ]
        draw_plots(folder / "hollow_sphere_heat.png", plots)
        print(f"the plot is in {folder}")
    return solution


if __name__ == "__main__":
    cb.run(main)
