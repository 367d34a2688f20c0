"""A viscous droplet in uniaxial extension u = (x, -y/2, -z/2) (thesis Fig. 4.5).

The steady D against Ca = μ × rate × R / γ.  The thesis finds that singularity subtraction
(Eq. 4.4) fails for Ca > 0.07 where polar integration does not.  Both rules are taken in our way and
in the thesis's, splines of degree 2 whose points move with the normal velocity.  Theory: D to first
(Barthes-Biesel and Acrivos) and second order in Ca.  The true D(0.05) comes from a spectral
computation.
"""

import numpy as np

import cadbem as cb
from cadbem.post.style.plots import draw_plots
from cadbem.quadrature.closed import SingularitySubtraction
from cadbem.verification.figures import extension

SUBTRACTION = {"rule": SingularitySubtraction()}
THESIS = {"degree": 2, "motion": cb.normal_velocity}
VARIANTS = {
    "ours, polar rule": {},
    "ours, subtraction": SUBTRACTION,
    "thesis's way, polar rule": THESIS,
    "thesis's way, subtraction": THESIS | SUBTRACTION,
}


def main(
    output: str = "results/droplet_extension", viscosity_ratio: float = 10.0, points: int = 128,
    step: float = 0.02, highest: float = 0.09, tolerance: float = 1e-4, end: float = 40.0,
) -> extension.Branches:  # fmt: skip
    """A branch of steady shapes for each variant, as long as there are any.

    viscosity_ratio: λ, inner over outer viscosity
    points: on the droplet
    step: between values of Ca, which begin at 0.01; highest: the largest Ca
    tolerance: error of a time step, as a share of the droplet's size
    end: time τ within which a shape must become steady, in units of 1 / rate
    """
    folder = cb.run_folder(output)
    capillaries = np.arange(0.01, highest + 1e-9, step)
    branches = {
        name: extension.branch(capillaries, viscosity_ratio, points, tolerance, end, **options)
        for name, options in VARIANTS.items()
    }
    extension.report(capillaries, branches, viscosity_ratio, points)
    deformation, last = branches["ours, polar rule"][-1]
    folder.summary({"D": deformation, "Ca": capillaries[-1]})
    if folder:
        plot = extension.plot(capillaries, branches, viscosity_ratio)
        draw_plots(folder / "droplet_extension.png", [plot])
        cb.draw_droplets(folder / "shape.png", [last.droplet.shape])
        print(f"the pictures are in {folder}")
    return branches


if __name__ == "__main__":
    cb.run(main)
