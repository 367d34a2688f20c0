"""How fast a droplet may be sheared before it deforms too much.

Taylor's D of a droplet in unbounded shear flow grows with Ca = μ × rate × R / γ.  For each of some
viscosity ratios λ the Ca at which D, the largest up to a time, reaches a limit is found; for small
limits it is Taylor's Ca = D (16 λ + 16) / (19 λ + 16).
"""

import numpy as np

import cadbem as cb
from cadbem.post.style.plots import Curve, Plot, draw_plots
from cadbem.verification.theory import taylor_capillary


def main(
    output: str = "results/deformation_limit", limit: float = 0.2,
    viscosity_ratios: str = "1 0.3 3", viscosity: str = "10 mPa s", tension: str = "5 mN/m",
    radius: str = "50 um", end: float = 8.0, points: int = 72, limits: int = 5,
) -> dict[float, float]:  # fmt: skip
    """The Ca for each ratio, and the shear rate that a droplet of a size and tension bears.

    limit: of D; limits: how many up to that one are drawn, for the first ratio
    viscosity_ratios: λ, inner over outer viscosity
    viscosity: of the outer fluid, with any units
    tension: of the interface, with any units; radius: of the droplet, with any units
    end: time up to which D counts, in units of 1 / rate
    points: on the droplet
    """
    folder = cb.run_folder(output)
    u = cb.Units("um")
    bearable = u(tension) / (u(viscosity) * u(radius))  # rate for Ca = 1
    ratios = [float(word) for word in viscosity_ratios.split()]
    measured = {ratio: cb.ShearDeformation(ratio, end, points) for ratio in ratios}
    found = {ratio: cb.largest_capillary(limit, measured[ratio]) for ratio in ratios}
    rows = [
        (f"{ratio:g}", f"{capillary:.4f}", f"{taylor_capillary(limit, ratio):.4f}",
         u.show(capillary * bearable, "rate"))
        for ratio, capillary in found.items()
    ]  # fmt: skip
    print(f"D stays below {limit:g} up to")
    print(cb.text_table(("viscosity ratio", "Ca", "Ca by Taylor", "shear rate"), rows))
    folder.summary({f"Ca, λ = {ratio:g}": capillary for ratio, capillary in found.items()})
    if folder:
        asked, first = np.linspace(limit / limits, limit, limits), ratios[0]
        allowed = [cb.largest_capillary(float(d), measured[first]) for d in asked]
        curves = [
            Curve(asked, allowed, f"λ = {first:g}", marks=True),
            Curve([0, limit], [0, taylor_capillary(limit, first)], "Taylor", dashed=True),
        ]
        draw_plots(folder / "capillary_numbers.png", [Plot("limit of D", "Ca allowed", curves)])
        print(f"a plot is in {folder}")
    return found


if __name__ == "__main__":
    cb.run(main)
