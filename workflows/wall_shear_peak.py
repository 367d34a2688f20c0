"""The strongest wall shear stress in a constriction: where, and how sure one may be of it.

The side walls of geometries/constriction.py come as near as 0.8 mm and part again, smoothly, in a
channel 1 mm high.  Prints the peak, its place, the mean over the walls and percentiles by area, on
finer and finer grids.  Walls that are smooth where the stress is high have a peak that settles; a
junction's corners would not: the exact stress there is infinite, and a percentile says more.
"""

from pathlib import Path

import cadbem as cb

GEOMETRY = Path(__file__).parents[1] / "geometries" / "constriction.step"


def main(
    output: str = "results/wall_shear_peak", viscosity: str = "1 mPa s",
    flow_rate: str = "60 uL/min", element_size: float = 0.3, grids: int = 3,
) -> list[cb.WallShear]:  # fmt: skip
    """Each grid is 1.4 times as fine as the one before.

    viscosity: of the fluid, with any units; flow_rate: of what enters, with any units
    element_size: of the finest grid (mm)
    grids: how many there are
    """
    folder = cb.run_folder(output, GEOMETRY)
    found, rows = [], []
    for k in range(grids):
        size = element_size * 1.4 ** (grids - 1 - k)
        channel = cb.read_cad(GEOMETRY).elevated(2).refined(size=size)
        u = cb.Units.of(channel)
        inlet = cb.Inflow(flow_rate=u(flow_rate))
        conditions = {"inlet": inlet, "outlet": cb.Pressure(0.0), "walls": cb.NoSlip()}
        rules = cb.Quadrature(1e-5)
        solution = cb.StokesProblem(channel, u(viscosity), conditions, rules).solve()
        shear = cb.wall_shear(solution)
        values = (shear.peak, shear.percentile(99), shear.percentile(50), shear.mean)
        place = ", ".join(f"{x:.2f}" for x in shear.place)
        rows.append([f"{solution.space.count}", *(u.show(v, "pressure") for v in values),
                     f"({place})", f"{shear.name}, face {shear.face}"])  # fmt: skip
        found.append(shear)
    head = ("points", "peak", "99 %", "50 %", "mean", "place (mm)", "on")
    print(cb.text_table(head, rows))
    folder.summary({
        "peak (Pa)": u.si(shear.peak, "pressure"),
        "99th percentile (Pa)": u.si(shear.percentile(99), "pressure"),
    })
    if folder:
        cb.draw_traction(solution, folder / "wall_stresses.png", units=u)
        print(f"a picture is in {folder}")
    return found


if __name__ == "__main__":
    cb.run(main)
