"""How fast a droplet may be sheared before it deforms too much.

Taylor's D of a droplet in unbounded shear flow grows with Ca = μ × rate × R / γ.  For each of some
viscosity ratios λ the Ca at which D, the largest up to a time, reaches a limit is found; for small
limits it is Taylor's Ca = D (16 λ + 16) / (19 λ + 16).  Prints both, and the shear rate that a
droplet of a given size and tension bears; draws the allowed Ca over the limit for the first λ.
"""

import numpy as np

import cadbem as cb
from cadbem.post.style.plots import Curve, Plot, draw_plots


def main(
    output: str = "results/deformation_limit",
    limit: float = 0.2,
    viscosity_ratios: str = "1 0.3 3",
    viscosity: str = "10 mPa s",
    tension: str = "5 mN/m",
    radius: str = "50 um",
    end: float = 8.0,
    points: int = 72,
    limits: int = 5,
) -> dict[float, float]:
    folder = cb.run_folder(output)
    u = cb.Units("um")
    bearable = u(tension) / (u(viscosity) * u(radius))  # rate for Ca = 1
    ratios = [float(word) for word in viscosity_ratios.split()]
    found = {
        ratio: cb.largest_capillary(limit, cb.ShearDeformation(ratio, end, points))
        for ratio in ratios
    }
    rows = [
        (f"{ratio:g}", f"{capillary:.4f}", f"{taylor(limit, ratio):.4f}",
         u.show(capillary * bearable, "rate"))
        for ratio, capillary in found.items()
    ]  # fmt: skip
    print(f"D stays below {limit:g} up to")
    print(cb.text_table(("viscosity ratio", "Ca", "Ca by Taylor", "shear rate"), rows))
    folder.summary({f"Ca, λ = {ratio:g}": capillary for ratio, capillary in found.items()})
    if folder:
        asked = np.linspace(limit / limits, limit, limits)
        measured = cb.ShearDeformation(ratios[0], end, points)
        allowed = [cb.largest_capillary(float(d), measured) for d in asked]
        curves = [
            Curve(asked, allowed, f"λ = {ratios[0]:g}", marks=True),
            Curve([0, limit], [0, taylor(limit, ratios[0])], "Taylor", dashed=True),
        ]
        plot = Plot("limit of D", "Ca allowed", curves)
        draw_plots(folder / "capillary_numbers.png", [plot])
        print(f"a plot is in {folder}")
    return found


def taylor(limit: float, ratio: float) -> float:
    """Ca for a small steady D."""
    return limit * (16 * ratio + 16) / (19 * ratio + 16)


if __name__ == "__main__":
    cb.run(main)
