"""Heat conduction in a quarter of a ring that convects and radiates, against the exact solution.

Lengths in units of the inner radius, temperatures in units of the surroundings' temperature:
1 < r < 2, φ = 2 inside, Bi = Bi_r = 1 outside, no heat through the straight sides.  Then
φ = 2 + C ln r, where the heat -C / 2 = (φ - 1) + (φ⁴ - 1) leaves at r = 2.
"""

import numpy as np

import cadbem as cb
from cadbem.post.style.plots import draw_plots
from cadbem.verification.figures import heat_profiles
from cadbem.verification.heat import RING_SLOPE, error_on_sides, quarter_ring

CONDITIONS = {
    "inner": cb.Temperature(2.0),
    "outer": cb.SurfaceExchange(convection=1.0, radiation=1.0, ambient=1.0),
    "symmetry": cb.HeatFlux(0.0),
}
DIRECTION = np.array([np.cos(0.6), np.sin(0.6)])


def exact(radii: np.ndarray) -> np.ndarray:
    return 2 + RING_SLOPE * np.log(radii)


def main(
    output: str = "results/annulus_heat", finest: int = 32, tolerance: float = 1e-12
) -> cb.HeatSolution:
    """Degrees 2 and 3, on grids each twice as fine as the one before.

    finest: elements a side of the finest grid
    tolerance: of the integrals
    """
    folder, found = cb.run_folder(output), {}
    print("degree  points  mean error on sides (%)  largest error inside  order")
    for degree in (2, 3):
        found[degree] = heat_profiles.Convergence(f"degree {degree}")
        for spans in 2 ** np.arange(int(np.log2(finest)) + 1):
            boundary = quarter_ring().elevated(degree).refined(int(spans))
            problem = cb.HeatProblem(boundary, 1.0, CONDITIONS, quadrature=cb.Quadrature(tolerance))
            solution = problem.solve()
            error = error_on_sides(solution)
            order = found[degree].add(solution.space.count, error)
            worst = heat_profiles.ray_error(solution, DIRECTION, exact)
            print(f"{degree:6d}  {solution.space.count:6d}  {error:23.2e}  {worst:20.2e}  {order}")
    exact_heat = -RING_SLOPE * np.pi / 2
    print(f"heat that passes {solution.heat_rate('inner'):.12f}, exact {exact_heat:.12f}")
    folder.summary({"points": solution.space.count, "mean error on sides (%)": error})
    if folder:
        label = "mean error on the sides (%)"
        plots = heat_profiles.plots(found.values(), label, solution, DIRECTION, exact)
        draw_plots(folder / "annulus_heat.png", plots)
    return solution


if __name__ == "__main__":
    cb.run(main)
