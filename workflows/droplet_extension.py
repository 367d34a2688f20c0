"""A viscous droplet in uniaxial extension u = (x, -y/2, -z/2) (thesis Fig. 4.5).

λ = 10; the steady D against Ca = μ × rate × R / γ.  The thesis finds that singularity subtraction
(Eq. 4.4) fails for Ca > 0.07 where polar integration does not.  Both rules are taken in our way and
in the thesis's, splines of degree 2 whose points move with the normal velocity.  Theory: D to first
(Barthes-Biesel and Acrivos) and second order in Ca.  The true D(0.05) comes from a spectral
computation.
"""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np

import cadbem as cb
from cadbem.post.style.plots import Curve, Plot, draw_plots
from cadbem.quadrature.closed import SingularitySubtraction
from cadbem.suspension.interface.volume import centre
from cadbem.verification.theory import extension

TRUE = json.loads((Path(__file__).parents[1] / "tests/data/reference.json").read_text())[
    "drop_3d_extension_lambda10"
]
THESIS = {"degree": 2, "motion": cb.normal_velocity}
VARIANTS = {
    "ours, polar rule": {},
    "ours, subtraction": {"rule": SingularitySubtraction()},
    "thesis's way, polar rule": THESIS,
    "thesis's way, subtraction": THESIS | {"rule": SingularitySubtraction()},
}
Branches = dict[str, list[tuple[float, cb.State]]]
FAR = 1e-3  # distance from the stagnation point at which a droplet is put back


def centred(shape: cb.ClosedSpline) -> cb.ClosedSpline:
    """The shape with its centre in the stagnation point."""
    return replace(shape, coefficients=shape.coefficients - centre(shape)[:, None, None])


def settle(simulation: cb.Simulation, change: float, end: float) -> tuple[float, cb.State]:
    """Steady D, when it changes by less in a unit of time; nan if it does not before ``end``.

    Rounding errors carry a droplet away from the stagnation point like exp(τ).  Its shape does
    not mind, but its points do, if they move with the normal velocity: it is put back.
    """
    last, time = np.inf, 0.0
    while time < end:
        for state in simulation.run(end - time, every=1.0):
            deformation = cb.taylor_deformation(state.droplet.shape)
            if state.time > 0 and abs(deformation - last) < change:
                return deformation, state
            if state.stopped:
                return np.nan, state
            last = deformation
            if np.linalg.norm(centre(state.droplet.shape)) > FAR:
                break
        time += state.time
        moved = state.droplet.moved(centred(state.droplet.shape))
        simulation = replace(simulation, bodies=moved)
    return np.nan, state


def branch(
    capillaries: np.ndarray, ratio: float, points: int, tolerance: float, end: float,
    degree: int = 4, **options,
) -> list[tuple[float, cb.State]]:  # fmt: skip
    """Steady shapes for rising Ca, each found from the one before, as long as there are any."""
    shape = cb.spline_sphere(points=points, degree=degree)
    flow, stepper = cb.FreeFlow(cb.uniaxial_extension()), cb.Adaptive(tolerance)
    found: list[tuple[float, cb.State]] = []
    for capillary in capillaries:
        droplet = cb.Droplet(shape, cb.capillary_tension(capillary), ratio)
        simulation = cb.Simulation(flow, droplet, stepper=stepper, **options)
        found.append(settle(simulation, tolerance / 10, end))
        if np.isnan(found[-1][0]):
            break
        shape = centred(found[-1][1].droplet.shape)
    return found


def main(
    output: str = "results/droplet_extension",
    viscosity_ratio: float = 10.0,
    points: int = 128,
    step: float = 0.02,
    highest: float = 0.09,
    tolerance: float = 1e-4,
    end: float = 40.0,
) -> Branches:
    folder = cb.run_folder(output)
    capillaries = np.arange(0.01, highest + 1e-9, step)
    branches = {
        name: branch(capillaries, viscosity_ratio, points, tolerance, end, **options)
        for name, options in VARIANTS.items()
    }

    report(capillaries, branches, viscosity_ratio, points)
    folder.summary({"D": branches["ours, polar rule"][-1][0], "Ca": capillaries[-1]})
    if folder:
        draw_plots(folder / "droplet_extension.png", [plot(capillaries, branches, viscosity_ratio)])
        last = branches["ours, polar rule"][-1][1]
        cb.draw_droplets(folder / "shape.png", [last.droplet.shape])
        print(f"the pictures are in {folder}")
    return branches


def report(capillaries: np.ndarray, branches: Branches, ratio: float, points: int) -> None:
    """Steady D beside theory, and the true value where it is known."""
    rows = []
    for k, capillary in enumerate(capillaries):
        values = [found[k][0] if k < len(found) else np.nan for found in branches.values()]
        known = np.isclose(capillary, TRUE["Ca"]) and ratio == 10
        rows.append(
            (f"{capillary:.2f}", *["-" if np.isnan(v) else f"{v:.5f}" for v in values],
             *[f"{extension(capillary, ratio, order):.5f}" for order in (1, 2)],
             f"{TRUE['D']:.5f}" if known else "-")
        )  # fmt: skip
    print(f"λ = {ratio:g}, {points} points")
    print(cb.text_table(("Ca", *branches, "first order", "second order", "true"), rows))
    for name, found in branches.items():
        if np.isnan(found[-1][0]):
            print(f"{name}: not steady at Ca = {capillaries[len(found) - 1]:.2f}")


def plot(capillaries: np.ndarray, branches: Branches, ratio: float) -> Plot:
    fine = np.linspace(0, capillaries[-1], 50)
    curves = [
        Curve(fine, extension(fine, ratio, 1), "first order", dashed=True),
        Curve(fine, extension(fine, ratio, 2), "second order"),
    ]
    for k, (name, found) in enumerate(branches.items()):
        values = [d for d, _ in found]
        look = {"line": k == 0, "marks": True, "colour": k}
        curves.append(Curve(capillaries[: len(values)], values, name, **look))
    if ratio == 10:
        curves.append(Curve([TRUE["Ca"]], [TRUE["D"]], "true", line=False, marks=True, colour=4))
    return Plot("Ca", "steady D", curves)


if __name__ == "__main__":
    cb.run(main)
