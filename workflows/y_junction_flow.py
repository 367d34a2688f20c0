"""Stokes flow through a Y-junction that is read from a STEP file.

Two inlets of equal mean velocity join into one outlet; see geometries/y_junction.py for the
drawing.  Prints flow rates and the pressure drop, and draws pictures into a folder.
"""

from pathlib import Path

import cadbem as cb

GEOMETRY = Path(__file__).parents[1] / "geometries" / "y_junction.step"


def main(
    output: str = "results/y_junction_flow",
    spans: int = 7,
    degree: int = 2,
    mesh_size: float = 0.35,
) -> cb.StokesSolution:
    folder = cb.run_folder(output, GEOMETRY)

    # Geometry: 18 four-sided faces with the names that the CAD file gives them
    channel = cb.read_cad(GEOMETRY).elevated(degree).refined(spans)

    # Problem: developed inflow of mean velocity 3 in both inlets, pressure zero at the outlet
    problem = cb.StokesProblem(
        channel,
        viscosity=1.0,
        conditions={
            "inlet_a": cb.Inflow(mean_velocity=3.0),
            "inlet_b": cb.Inflow(mean_velocity=3.0),
            "outlet": cb.Pressure(0.0),
            "walls": cb.NoSlip(),
        },
    )
    solution = problem.solve()

    # Checks: what enters must leave, and the two inlets must agree
    print(f"{solution.space.count} collocation points")
    for name in ("inlet_a", "inlet_b", "outlet"):
        flow, pressure = solution.flow_rate(name), solution.mean_pressure(name)
        print(f"{name:8}  flow rate {flow:10.5f}  mean pressure {pressure:10.5f}")
    print(f"net flux / inflow {solution.net_flux():.2e}, net force {solution.net_force():.2e}")
    drop = solution.mean_pressure("inlet_a") - solution.mean_pressure("outlet")
    folder.summary({"points": solution.space.count, "pressure drop": drop})

    if folder:
        draw(folder, solution, mesh_size)
        print(f"pictures and ParaView files are in {folder}")
    return solution


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
    cb.write_vtu(folder / "walls.vtu", cb.bezier_grid(channel, {
        "velocity": solution.velocity, "traction": solution.traction}))  # fmt: skip


if __name__ == "__main__":
    cb.run(main)
