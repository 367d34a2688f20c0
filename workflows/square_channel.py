"""Stokes flow through a square channel, against the exact solution.

Width and height 1, length 2, mean velocity 1, viscosity 1: the pressure gradient of the
developed flow is -28.4541538 (Fourier series of the duct flow).
"""

from math import ceil
from pathlib import Path

import numpy as np

import cadbem as cb
from cadbem.problems.profiles import rectangle_profile

GEOMETRY = Path(__file__).parents[1] / "geometries" / "square_channel.step"
LENGTH, EXACT_GRADIENT = 2.0, -28.454153769562279  # the latter in viscosity U / W²


def main(
    output: str = "results/square_channel",
    spans: int = 7,
    degree: int = 2,
    along: int = 0,
    levels: int = 0,
    ratio: float = 0.5,
    tolerance: float = 1e-8,
    mesh_size: float = 0.06,
) -> cb.StokesSolution:
    folder = cb.run_folder(output, GEOMETRY)

    # Geometry: elements of 1 / spans across, and somewhat finer than twice as many along;
    # with levels, those at the channel's four long edges are cut at ratio, ratio², ...
    along = along or ceil(spans * 17 / 7)
    channel = cb.read_cad(GEOMETRY).elevated(degree)
    channel = channel.refined(size=(LENGTH / along, 1 / spans, 1 / spans))
    channel = channel.graded(levels, ratio, toward=lambda x, inward: abs(inward[0]) < 0.5)

    # Problem: the exact profile enters; at the outlet the flow leaves straight at pressure zero
    problem = cb.StokesProblem(
        channel,
        viscosity=1.0,
        conditions={
            "inlet": cb.Inflow(mean_velocity=1.0),
            "outlet": cb.Pressure(0.0),
            "walls": cb.NoSlip(),
        },
        quadrature=cb.Quadrature(tolerance),
    )
    solution = problem.solve()

    print(f"{solution.space.count} collocation points, degree {degree}")
    folder.summary(compared(solution))
    if folder:
        draw(folder, solution, mesh_size)
        print(f"pictures and ParaView files are in {folder}")
    return solution


def compared(solution: cb.StokesSolution) -> dict[str, float]:
    """Checks against the exact flow, printed and by name."""
    drop = solution.mean_pressure("inlet") - solution.mean_pressure("outlet")
    gradient = -drop / LENGTH
    print(f"net flux / inflow  {solution.net_flux():10.2e}")
    print(f"net force / forces {solution.net_force():10.2e}")
    print(f"pressure gradient  {gradient:10.5f}  ({gradient / EXACT_GRADIENT - 1:+.1e})")
    print(f"outlet velocity    {outlet_error(solution):10.2e}  (largest error over mean velocity)")
    return {
        "points": solution.space.count,
        "pressure gradient": gradient,
        "error of the gradient": gradient / EXACT_GRADIENT - 1,
        "error of the outlet velocity": outlet_error(solution),
    }


def draw(folder: cb.RunFolder, solution: cb.StokesSolution, mesh_size: float) -> None:
    """Pictures, and files for ParaView."""
    channel = solution.space.boundary
    cb.draw_boundary(channel, folder / "faces.png")
    cb.draw_collocation(solution.space, folder / "collocation.png")
    cb.draw_traction(solution, folder / "traction.png")
    points, tetrahedra = cb.mesh_volume(GEOMETRY, mesh_size)
    grid = cb.volume_grid(points, tetrahedra, solution)
    cb.draw_slices(grid, channel, folder / "slices.png")
    cb.draw_streamlines(grid, channel, folder / "streamlines.png")
    cb.write_vtu(folder / "volume.vtu", grid)


def outlet_error(solution: cb.StokesSolution) -> float:
    """Largest error of the velocity on the thesis's line (x, z) = (1, -0.047), |y| < 0.45."""
    y = np.linspace(-0.45, 0.45, 21)
    line = np.array([np.full_like(y, LENGTH / 2), y, np.full_like(y, -0.047)])
    exact = rectangle_profile(y, line[2], 1.0, 1.0)
    return float(abs(solution.velocity_at(line)[0] - exact).max())


if __name__ == "__main__":
    cb.run(main)
