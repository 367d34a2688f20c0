"""Heat conduction in a quarter of a ring that convects and radiates, against the exact solution.

Lengths in units of the inner radius, temperatures in units of the surroundings' temperature:
1 < r < 2, φ = 2 inside, Bi = Bi_r = 1 outside, no heat through the straight sides.  Then
φ = 2 + C ln r, where the heat -C / 2 = (φ - 1) + (φ⁴ - 1) leaves at r = 2.
"""

import numpy as np
from scipy.optimize import brentq

import cadbem as cb
from cadbem.post.style.plots import Curve, Plot, draw_plots, fitted_order
from cadbem.verification.heat import error_on_sides, quarter_ring

SLOPE = brentq(
    lambda c: c / 2 + (1 + c * np.log(2)) + (2 + c * np.log(2)) ** 4 - 1, -2.0, 0.0, xtol=1e-15
)
DIRECTION = np.array([np.cos(0.6), np.sin(0.6)])


def exact(points: np.ndarray) -> np.ndarray:
    return 2 + SLOPE * np.log(np.linalg.norm(points, axis=0))


def solve(degree: int, spans: int, tolerance: float) -> cb.HeatSolution:
    problem = cb.HeatProblem(
        quarter_ring().elevated(degree).refined(spans),
        conductivity=1.0,
        conditions={
            "inner": cb.Temperature(2.0),
            "outer": cb.SurfaceExchange(convection=1.0, radiation=1.0, ambient=1.0),
            "symmetry": cb.HeatFlux(0.0),
        },
        quadrature=cb.Quadrature(tolerance),
    )
    return problem.solve()


def main(
    output: str = "results/annulus_heat", finest: int = 32, tolerance: float = 1e-12
) -> cb.HeatSolution:
    folder = cb.run_folder(output)
    radii = np.linspace(1.05, 1.95, 25)
    inside = np.outer(DIRECTION, radii)
    convergence = []
    print("degree  points  mean error on sides (%)  largest error inside  order")
    for degree in (2, 3):
        counts, errors = [], []
        for spans in 2 ** np.arange(int(np.log2(finest)) + 1):
            solution = solve(degree, int(spans), tolerance)
            counts.append(solution.space.count)
            errors.append(error_on_sides(solution))
            worst = abs(solution.temperature_at(inside) / exact(inside) - 1).max()
            order = f"{fitted_order(counts[-2:], errors[-2:]):5.2f}" if len(counts) > 1 else ""
            print(f"{degree:6d}  {counts[-1]:6d}  {errors[-1]:23.2e}  {worst:20.2e}  {order}")
        convergence.append(Curve(counts, errors, f"degree {degree}", marks=True))
    print(f"heat that passes {solution.heat_rate('inner'):.12f}, exact {-SLOPE * np.pi / 2:.12f}")
    folder.summary({"points": counts[-1], "mean error on sides (%)": errors[-1]})

    if folder:
        fine = np.linspace(1, 2, 101)
        profile = [
            Curve(fine, exact(np.outer(DIRECTION, fine)), "exact"),
            Curve(radii, solution.temperature_at(inside), "computed", line=False, marks=True),
        ]
        plots = [
            Plot("collocation points", "mean error on the sides (%)", convergence, True),
            Plot("r / inner radius", "temperature / surroundings'", profile),
        ]
        draw_plots(folder / "annulus_heat.png", plots)
        print(f"the plot is in {folder}")
    return solution


if __name__ == "__main__":
    cb.run(main)
