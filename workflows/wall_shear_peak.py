"""The strongest wall shear stress in a constriction: where, and how sure one may be of it.

The side walls of geometries/constriction.py come as near as 0.8 mm and part again, smoothly, in a
channel 1 mm high.  Elements are refined until the estimated error of the largest wall shear is
below an accuracy.  Prints the peak with that error, its place, the mean over the walls and
percentiles by area.  The estimate is of the stress where it is largest at a collocation point:
elements must be fine enough to have one near the true peak.  Here the stress beside the edges of
the walls keeps the estimate above 1e-3, and the solution warns that it may be 1.6 % off.  A
junction's corners would have no peak: the exact stress is infinite, and a percentile says more.
"""

from pathlib import Path

import cadbem as cb

GEOMETRY = Path(__file__).parents[1] / "geometries" / "constriction.step"


def main(
    output: str = "results/wall_shear_peak", viscosity: str = "1 mPa s",
    flow_rate: str = "60 uL/min", accuracy: float = 1e-3,
) -> cb.WallShear:  # fmt: skip
    """The goal of the elements is the wall shear.

    viscosity: of the fluid, with any units; flow_rate: of what enters, with any units
    accuracy: relative error of the peak that you accept
    """
    folder = cb.run_folder(output, GEOMETRY)
    channel = cb.read_cad(GEOMETRY)
    u = cb.Units.of(channel)
    inlet = cb.Inflow(flow_rate=u(flow_rate))
    conditions = {"inlet": inlet, "outlet": cb.Pressure(0.0), "walls": cb.NoSlip()}
    solution = cb.StokesProblem(channel, u(viscosity), conditions).solve(
        accuracy, goal="wall shear"
    )
    shear = cb.wall_shear(solution)
    peak, error = (u.show(value, "pressure") for value in (shear.peak, shear.error))
    place = ", ".join(f"{x:.2f}" for x in shear.place)
    print(f"{solution.space.count} points")
    print(f"peak {peak} ± {error} at ({place}) mm on {shear.name}, face {shear.face}")
    for percent in (99, 50):
        print(f"{percent} % of the area below {u.show(shear.percentile(percent), 'pressure')}")
    print(f"mean {u.show(shear.mean, 'pressure')}")
    folder.summary({
        "peak (Pa)": u.si(shear.peak, "pressure"),
        "99th percentile (Pa)": u.si(shear.percentile(99), "pressure"),
    })
    if folder:
        cb.draw_traction(solution, folder / "wall_stresses.png", units=u)
        print(f"a picture is in {folder}")
    return shear


if __name__ == "__main__":
    cb.run(main)
