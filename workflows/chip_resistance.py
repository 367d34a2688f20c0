"""The hydraulic resistances of a chip with four openings, and what a pump has to do.

Flow focusing (geometries/flow_focusing.py): 'inlet', 'side_a' and 'side_b' meet before an orifice,
and leave through 'outlet'.  All openings are driven in turn by a unit pressure, with one
factorisation of the matrix; the flow rates make the conductance matrix G, Q = G p.  Prints G, the
resistance matrix towards the outlet, and the pressures that given flow rates need, at the chip and
at the pumps behind tubing of a given bore and length, whose resistance is 128 μ L / (π d⁴).

Draws the flow at that operating point.  Quantities take any units: --viscosity '3 cP'.
"""

from math import pi
from pathlib import Path

import numpy as np

import cadbem as cb

GEOMETRY = Path(__file__).parents[1] / "geometries" / "flow_focusing.step"
OPENINGS = ("inlet", "side_a", "side_b", "outlet")


def main(
    output: str = "results/chip_resistance",
    viscosity: str = "1 mPa s",
    main_rate: str = "30 uL/min",
    side_rate: str = "60 uL/min",
    bore: str = "2 mm",
    tube_length: str = "30 cm",
    element_size: float = 0.4,
    mesh_size: float = 0.12,
) -> tuple[cb.Network, cb.OperatingPoint]:
    folder = cb.run_folder(output, GEOMETRY)

    # Geometry: 34 plane faces; lengths in the file's unit, time in s, pressure in Pa
    channel = cb.read_cad(GEOMETRY).elevated(2).refined(size=element_size)
    u = cb.Units.of(channel)

    # The network
    network = cb.hydraulic_network(channel, u(viscosity), OPENINGS, cb.Quadrature(1e-5))
    print(f"{network.problem.space.count} collocation points, |G - G'| / |G| = "
          f"{network.asymmetry:.1e}")  # fmt: skip
    table("conductance G (uL/min/Pa): Q into the chip = G p", network.conductance,
          OPENINGS, u.si(1.0, "flow_rate") / u.si(1.0, "pressure") * 6e10)  # fmt: skip
    table("resistance to the outlet (Pa min/uL)", network.resistance("outlet"),
          OPENINGS[:3], u.si(1.0, "resistance") / 6e10)  # fmt: skip

    # An operating point: syringe pumps at three openings, the outlet's tube ends in the open
    tube = 128 * u(viscosity) * u(tube_length) / (pi * u(bore) ** 4)
    rates = {"inlet": u(main_rate), "side_a": u(side_rate), "side_b": u(side_rate)}
    point = network.operate({"outlet": 0.0}, rates, dict.fromkeys(OPENINGS, tube))
    print(f"with tubes of {u.show(tube, 'resistance')} at each opening:")
    report(u, point)
    pumps = zip(OPENINGS, point.outside, strict=True)
    folder.summary({f"pressure at {name} (Pa)": u.si(p, "pressure") for name, p in pumps})

    if folder:
        solution = network.flow(point)
        grid = cb.volume_grid(*cb.mesh_volume(GEOMETRY, mesh_size), solution)
        cb.draw_slices(grid, channel, folder / "slices.png", units=u)
        cb.draw_streamlines(grid, channel, folder / "streamlines.png", units=u)
        print(f"pictures are in {folder}")
    return network, point


def report(u: cb.Units, point: cb.OperatingPoint) -> None:
    """Flow rate and pressures at each opening."""
    rows = [
        (name, u.show(rate, "flow_rate"), u.show(inside, "pressure"), u.show(outside, "pressure"))
        for name, rate, inside, outside in zip(
            OPENINGS, point.flow_rates, point.pressures, point.outside, strict=True
        )
    ]
    print(cb.text_table(("opening", "flow rate", "at the chip", "beyond the tube"), rows))


def table(title: str, matrix: np.ndarray, names: tuple[str, ...], factor: float) -> None:
    """A matrix with names at its rows and columns."""
    print(title)
    rows = [(n, *(f"{x * factor:.4g}" for x in row)) for n, row in zip(names, matrix, strict=True)]
    print(cb.text_table(("", *names), rows))


if __name__ == "__main__":
    cb.run(main)
