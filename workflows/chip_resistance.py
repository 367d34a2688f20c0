"""The hydraulic resistances of a chip with four openings, and what a pump has to do.

Flow focusing (geometries/flow_focusing.py): 'inlet', 'side_a' and 'side_b' meet before an orifice,
and leave through 'outlet'.  Elements are refined until flow rates are accurate.  All openings are
driven in turn by a unit pressure, with one factorisation of the matrix; the flow rates make the
conductance matrix G, Q = G p.  Prints G, the resistance matrix towards the outlet, and the
pressures that given flow rates need, at the chip and at the pumps behind tubing, whose resistance
is 128 μ L / (π d⁴).  Draws the flow at that point.
"""

from pathlib import Path

import cadbem as cb

GEOMETRY = Path(__file__).parents[1] / "geometries" / "flow_focusing.step"
OPENINGS = ("inlet", "side_a", "side_b", "outlet")


def main(
    output: str = "results/chip_resistance", viscosity: str = "1 mPa s",
    main_rate: str = "30 uL/min", side_rate: str = "60 uL/min", bore: str = "2 mm",
    tube_length: str = "30 cm", accuracy: float = 1e-2, mesh_size: float = 0.12,
) -> tuple[cb.Network, cb.OperatingPoint]:  # fmt: skip
    """Syringe pumps at three openings; the outlet's tube ends in the open.

    viscosity: of the fluid, with any units, such as '3 cP'
    main_rate: into 'inlet', with any units; side_rate: into either side
    bore: inner diameter of the tube at each opening; tube_length: its length, with any units
    accuracy: relative error of flow rates that you accept, such as 1e-3
    mesh_size: cells in pictures of the flow (mm)
    """
    folder = cb.run_folder(output, GEOMETRY)
    channel = cb.read_cad(GEOMETRY)
    u = cb.Units.of(channel)  # lengths in the file's unit, time in s, pressure in Pa
    network = cb.hydraulic_network(channel, u(viscosity), OPENINGS, accuracy=accuracy)
    print(f"{network.problem.space.count} collocation points, |G - G'| / |G| = "
          f"{network.asymmetry:.1e}")  # fmt: skip
    print(network.tables("outlet", u))

    tube = cb.tube_resistance(u(viscosity), u(tube_length), u(bore))
    rates = {"inlet": u(main_rate), "side_a": u(side_rate), "side_b": u(side_rate)}
    point = network.operate({"outlet": 0.0}, rates, dict.fromkeys(OPENINGS, tube))
    print(f"with tubes of {u.show(tube, 'resistance')} at each opening:")
    print(point.table(u))
    pumps = zip(OPENINGS, point.outside, strict=True)
    folder.summary({f"pressure at {name} (Pa)": u.si(p, "pressure") for name, p in pumps})
    pictures = ("slices.png", "streamlines.png")
    cb.draw_solution(folder, network.flow(point), GEOMETRY, mesh_size, pictures, units=u)
    return network, point


if __name__ == "__main__":
    cb.run(main)
