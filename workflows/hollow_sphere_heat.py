"""Heat conduction in a hollow sphere that convects and radiates, against the exact solution.

Lengths in units of the inner radius, temperatures in units of the surroundings' temperature:
1 < r < 2, φ = 2 inside, Bi = Bi_r = 1 outside.  Then φ = 2 + C (1/r - 1), where the heat
C / 4 = (φ - 1) + (φ⁴ - 1) leaves at r = 2.  Temperature and flux are constant on each sphere, so
that the error is that of the quadrature alone.  How it falls with refinement, an uneven temperature
shows, 1 / |x - a|.
"""

import numpy as np

import cadbem as cb
from cadbem.post.style.plots import draw_plots
from cadbem.verification.figures import heat_profiles
from cadbem.verification.heat import SHELL_HEAT, hollow_sphere, uneven, uneven_flux

POLAR, OBLIQUE = np.array([0.0, 0.0, 1.0]), np.array([1.0, 2.0, 3.0]) / np.sqrt(14.0)
EXCHANGE = cb.SurfaceExchange(convection=1.0, radiation=1.0, ambient=1.0)


def exact(radii: np.ndarray) -> np.ndarray:
    return 2 + SHELL_HEAT * (1 / radii - 1)


def solve(spans: int, tolerance: float, inner, outer) -> cb.HeatSolution:
    conditions, rules = {"inner": inner, "outer": outer}, cb.Quadrature(tolerance)
    return cb.HeatProblem(hollow_sphere().refined(spans), 1.0, conditions, quadrature=rules).solve()


def main(output: str = "results/hollow_sphere_heat", finest: int = 4) -> cb.HeatSolution:
    """The coarsest grid with finer and finer integrals, and finer and finer grids.

    finest: elements a direction on each patch of the finest grid
    """
    folder = cb.run_folder(output)
    print("convection and radiation\npoints  tolerance  polar ray  oblique ray  heat rate")
    for tolerance in (1e-4, 1e-6, 1e-8):
        solution = solve(1, tolerance, cb.Temperature(2.0), EXCHANGE)
        rays = [heat_profiles.ray_error(solution, ray, exact) for ray in (POLAR, OBLIQUE)]
        heat = abs(solution.heat_rate("inner") / (4 * np.pi * SHELL_HEAT) - 1)
        row = f"{rays[0]:9.1e}  {rays[1]:11.1e}  {heat:9.1e}"
        print(f"{solution.space.count:6d}  {tolerance:9.0e}  {row}")

    print("uneven temperature\npoints  oblique ray  heat rate  order")
    found, ray = heat_profiles.Convergence("uneven temperature", 0), heat_profiles.on_ray(OBLIQUE)
    for spans in range(1, finest + 1):
        other = solve(spans, 1e-9, cb.Temperature(uneven), cb.HeatFlux(uneven_flux))
        error = float(abs(other.temperature_at(ray) / uneven(ray) - 1).max())
        order, heat = found.add(other.space.count, error), other.heat_rate("inner") / (4 * np.pi)
        print(f"{other.space.count:6d}  {error:11.1e}  {abs(heat - 1):9.1e}  {order}")
    folder.summary({"points": other.space.count, "largest error on a ray": error})
    if folder:
        label = "largest relative error on a ray"
        plots = heat_profiles.plots([found], label, solution, POLAR, exact)
        draw_plots(folder / "hollow_sphere_heat.png", plots)
    return solution


if __name__ == "__main__":
    cb.run(main)
