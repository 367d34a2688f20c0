"""A viscous droplet in uniaxial extension (thesis Fig. 4.5)."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from cadbem.post.style.plots import Curve, Plot
from cadbem.spline.closed import ClosedSpline
from cadbem.spline.closed_shapes import spline_sphere
from cadbem.suspension.bodies.droplet import Droplet
from cadbem.suspension.interface.laws import capillary_tension
from cadbem.suspension.interface.volume import centre
from cadbem.suspension.multibody.measures import taylor_deformation
from cadbem.suspension.surroundings.flows import uniaxial_extension
from cadbem.suspension.surroundings.free_flow import FreeFlow
from cadbem.suspension.time.simulation import Simulation
from cadbem.suspension.time.state import State
from cadbem.suspension.time.stepping import Adaptive
from cadbem.tables import text_table
from cadbem.verification.theory import extension
from cadbem.verification.true_series import EXTENSION as TRUE

Branches = dict[str, list[tuple[float, State]]]
FAR = 1e-3  # distance from the stagnation point at which a droplet is put back


def centred(shape: ClosedSpline) -> ClosedSpline:
    """The shape with its centre in the stagnation point."""
    return replace(shape, coefficients=shape.coefficients - centre(shape)[:, None, None])


def settle(simulation: Simulation, change: float, end: float) -> tuple[float, State]:
    """Steady D, when it changes by less in a unit of time; nan if it does not before ``end``.

    Rounding errors carry a droplet away from the stagnation point like exp(τ).  Its shape does
    not mind, but its points do, if they move with the normal velocity: it is put back.
    """
    last, time = np.inf, 0.0
    while time < end:
        for state in simulation.run(end - time, every=1.0):
            deformation = taylor_deformation(state.droplet.shape)
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
) -> list[tuple[float, State]]:  # fmt: skip
    """Steady shapes for rising Ca, each found from the one before, as long as there are any."""
    shape = spline_sphere(points=points, degree=degree)
    flow, stepper = FreeFlow(uniaxial_extension()), Adaptive(tolerance)
    found: list[tuple[float, State]] = []
    for capillary in capillaries:
        droplet = Droplet(shape, capillary_tension(capillary), ratio)
        simulation = Simulation(flow, droplet, stepper=stepper, **options)
        found.append(settle(simulation, tolerance / 10, end))
        if np.isnan(found[-1][0]):
            break
        shape = centred(found[-1][1].droplet.shape)
    return found


def report(capillaries: np.ndarray, branches: Branches, ratio: float, points: int) -> None:
    """Steady D beside theory, and the true value where it is known."""
    rows = []
    for k, capillary in enumerate(capillaries):
        values = [found[k][0] if k < len(found) else np.nan for found in branches.values()]
        known = np.isclose(capillary, TRUE[0]) and ratio == 10
        rows.append(
            (f"{capillary:.2f}", *["-" if np.isnan(v) else f"{v:.5f}" for v in values],
             *[f"{extension(capillary, ratio, order):.5f}" for order in (1, 2)],
             f"{TRUE[1]:.5f}" if known else "-")
        )  # fmt: skip
    print(f"λ = {ratio:g}, {points} points")
    print(text_table(("Ca", *branches, "first order", "second order", "true"), rows))
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
        look: dict[str, Any] = {"line": k == 0, "marks": True, "colour": k}
        curves.append(Curve(capillaries[: len(values)], values, name, **look))
    if ratio == 10:
        curves.append(Curve([TRUE[0]], [TRUE[1]], "true", line=False, marks=True, colour=4))
    return Plot("Ca", "steady D", curves)
