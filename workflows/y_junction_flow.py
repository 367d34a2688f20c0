"""Stokes flow through a Y-junction that is read from a STEP file.

Two inlets of equal mean velocity join into one outlet; see geometries/y_junction.py for the
drawing.  Elements are chosen and refined until estimated errors are below an accuracy.  Prints flow
rates, pressures and their errors, and draws pictures into a folder.
"""

from pathlib import Path

import cadbem as cb

GEOMETRY = Path(__file__).parents[1] / "geometries" / "y_junction.step"


def main(
    output: str = "results/y_junction_flow", accuracy: float = 1e-2, mesh_size: float = 0.35,
) -> cb.StokesSolution:  # fmt: skip
    """Branches are 4 wide and high, the mean velocity is 3 in both inlets, the viscosity 1.

    accuracy: relative error that you accept, such as 1e-3
    mesh_size: of the cells on which pictures of the flow are drawn
    """
    folder = cb.run_folder(output, GEOMETRY)

    # Geometry: 18 four-sided faces with the names that the CAD file gives them
    channel = cb.read_cad(GEOMETRY)

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
    solution = problem.solve(accuracy)

    # Checks: what enters must leave, and the two inlets must agree
    print(f"{solution.space.count} collocation points")
    for name in ("inlet_a", "inlet_b", "outlet"):
        flow, pressure = solution.flow_rate(name), solution.mean_pressure(name)
        print(f"{name:8}  flow rate {flow:10.5f}  mean pressure {pressure:10.5f}")
    print(f"net flux / inflow {solution.net_flux():.2e}, net force {solution.net_force():.2e}")
    print(solution.accuracy)
    drop = solution.mean_pressure("inlet_a") - solution.mean_pressure("outlet")
    folder.summary({"points": solution.space.count, "pressure drop": drop})

    # Pictures, and files for ParaView
    cb.draw_solution(folder, solution, GEOMETRY, mesh_size)
    return solution


if __name__ == "__main__":
    cb.run(main)
