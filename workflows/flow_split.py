"""How a T-junction divides what enters it, and how the tubing behind one outlet shifts that.

Fluid enters the stem of geometries/t_junction.py, and leaves through both arms into the open.  The
right arm has a tube behind it, which is made longer; the resistance of a round tube is
128 μ L / (π d⁴).  The junction is mirror symmetric.  Elements are refined until flow rates are
accurate; one factorisation serves all operating points.
"""

from pathlib import Path

import cadbem as cb
from cadbem.post.style.plots import Curve, Plot, draw_plots

GEOMETRY = Path(__file__).parents[1] / "geometries" / "t_junction.step"


def main(
    output: str = "results/flow_split", viscosity: str = "1 mPa s", flow_rate: str = "30 uL/min",
    bore: str = "1.5 mm", longest: str = "5 cm", steps: int = 6, accuracy: float = 1e-2,
) -> list[cb.OperatingPoint]:  # fmt: skip
    """Both arms end at pressure 0, one of them behind a tube.

    viscosity: of the fluid, with any units; flow_rate: of what enters, with any units
    bore: inner diameter of the tube, with any units; longest: greatest length of the tube
    steps: how many lengths there are, from 0 on
    accuracy: relative error of flow rates that you accept, such as 1e-3
    """
    folder = cb.run_folder(output, GEOMETRY)
    junction = cb.read_cad(GEOMETRY).named(stem="inlet_b", left="inlet_a", right="outlet")
    u = cb.Units.of(junction)
    openings = ("stem", "left", "right")
    network = cb.hydraulic_network(junction, u(viscosity), openings, accuracy=accuracy)
    lengths = [u(longest) * k / (steps - 1) for k in range(steps)]
    tubes = [cb.tube_resistance(u(viscosity), length, u(bore)) for length in lengths]
    ends = {"left": 0.0, "right": 0.0}
    points = [network.operate(ends, {"stem": u(flow_rate)}, {"right": t}) for t in tubes]

    rows = []
    for length, point in zip(lengths, points, strict=True):
        shares = [f"{point.fractions[name]:.4f}" for name in openings[1:]]
        rates = [u.show(-q, "flow_rate") for q in point.flow_rates[1:]]
        drop = u.show(point.pressures[0], "pressure")
        rows.append([u.show(length, "length"), *shares, *rates, drop])
    head = ("tube on the right", "share left", "share right", "left", "right", "at the stem")
    print(cb.text_table(head, rows))
    left, stem = points[-1].fractions["left"], u.si(points[-1].pressures[0], "pressure")
    folder.summary({"share left": left, "pressure at the stem (Pa)": stem})
    if folder:
        over = [u.si(length, "length") * 100 for length in lengths]
        shares = {name: [p.fractions[name] for p in points] for name in openings[1:]}
        curves = [Curve(over, values, name, marks=True) for name, values in shares.items()]
        label = "length of the tube behind the right arm (cm)"
        draw_plots(folder / "split.png", [Plot(label, "share of the flow", curves)])
    return points


if __name__ == "__main__":
    cb.run(main)
