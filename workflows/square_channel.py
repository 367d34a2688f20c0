"""Stokes flow through a square channel, against the exact solution.

Width and height 1, length 2, mean velocity 1, viscosity 1: the pressure gradient of the
developed flow is -28.4541538 (Fourier series of the duct flow).
"""

from math import ceil
from pathlib import Path

import cadbem as cb
from cadbem.verification.channel import GRADIENT, error_at_outlet

GEOMETRY = Path(__file__).parents[1] / "geometries" / "square_channel.step"
LENGTH, EXACT_GRADIENT = 2.0, -GRADIENT  # the latter in viscosity U / W²


def main(
    output: str = "results/square_channel", spans: int = 7, degree: int = 2, along: int = 0,
    levels: int = 0, ratio: float = 0.5, tolerance: float = 1e-8, mesh_size: float = 0.06,
) -> cb.StokesSolution:  # fmt: skip
    """The exact profile enters; at the outlet the flow leaves straight at pressure zero.

    spans: elements across; along: elements along the channel, 0 for 17 / 7 as many
    degree: of the patches
    levels: how often elements at the long edges are cut; ratio: cuts are at ratio, ratio², ...
    tolerance: of the integrals
    mesh_size: of the cells on which pictures of the flow are drawn, in widths
    """
    folder = cb.run_folder(output, GEOMETRY)
    along = along or ceil(spans * 17 / 7)
    channel = cb.read_cad(GEOMETRY).elevated(degree)
    channel = channel.refined(size=(LENGTH / along, 1 / spans, 1 / spans))
    channel = channel.graded(levels, ratio, toward=lambda x, inward: abs(inward[0]) < 0.5)
    inlet = cb.Inflow(mean_velocity=1.0)
    conditions = {"inlet": inlet, "outlet": cb.Pressure(0.0), "walls": cb.NoSlip()}
    solution = cb.StokesProblem(channel, 1.0, conditions, cb.Quadrature(tolerance)).solve()

    drop = solution.mean_pressure("inlet") - solution.mean_pressure("outlet")
    gradient = -drop / LENGTH
    error, at_outlet = gradient / EXACT_GRADIENT - 1, error_at_outlet(solution)
    print(f"{solution.space.count} collocation points, degree {degree}")
    print(f"net flux / inflow  {solution.net_flux():10.2e}")
    print(f"net force / forces {solution.net_force():10.2e}")
    print(f"pressure gradient  {gradient:10.5f}  ({error:+.1e})")
    print(f"outlet velocity    {at_outlet:10.2e}  (largest error over mean velocity)")
    folder.summary({
        "points": solution.space.count, "pressure gradient": gradient,
        "error of the gradient": error, "error of the outlet velocity": at_outlet,
    })  # fmt: skip
    cb.draw_solution(folder, solution, GEOMETRY, mesh_size)
    return solution


if __name__ == "__main__":
    cb.run(main)
