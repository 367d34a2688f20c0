"""Checks of the thesis's chapter 3: droplets in a plane.

The thesis's Ca is twice the true one there: ``thesis_tension_2d``.  True D of the droplets in shear
flow come from a spectral computation.
"""

from __future__ import annotations

from functools import cache, partial
from typing import Any

import numpy as np

from cadbem.quadrature.closed import PolarRule
from cadbem.spline.closed_shapes import spline_circle, spline_ellipse
from cadbem.suspension.bodies.droplet import Droplet
from cadbem.suspension.interface.laws import SurfaceTension, capillary_tension, thesis_tension_2d
from cadbem.suspension.surroundings.flows import at_rest, shear
from cadbem.suspension.surroundings.free_flow import FreeFlow
from cadbem.suspension.surroundings.surroundings import Surroundings
from cadbem.suspension.time.history import History, record
from cadbem.suspension.time.simulation import Simulation
from cadbem.suspension.time.stepping import Adaptive
from cadbem.verification.check import Check
from cadbem.verification.plates import between_plane_plates
from cadbem.verification.theory import far_plates

RADIUS = np.sqrt(4.7126 / np.pi)  # of the circle with the thesis's area
ASPECT = 1.5
TENSION = thesis_tension_2d(0.2)
SPECTRAL = "spectral computation"
TIPS = np.array([[0.0, np.pi / 2]])
# viscosity ratio: true steady D in the thesis's reading of Ca = 0.2, and in the physical one
STEADY = {0.2: (0.09987, 0.19907), 1.0: (0.09927, 0.19458), 2.0: (0.09731, 0.18218)}
SERIES = {0.4: 0.08630902104445538, 1.0: 0.09880434367445903}  # D(τ) for λ = 1
SWAP = ((-2.5, 0.25), (2.5, -0.25))  # centres of two droplets that pass each other


def checks() -> tuple[Check, ...]:
    """Of relaxation, of shear flow, and of plates."""
    return (*_relaxation(), *_shear(), *_far_from_round(), *_between_plates())


def _relaxation() -> list[Check]:
    place, circle = "Figure 3.1", "a circle of the same area"
    rate = TENSION.tension / (2 * RADIUS)
    return [
        Check(place, "R1 at τ = 4", partial(semi_axis, 0), RADIUS, 1e-6, circle, 1.2248),
        Check(place, "R2 at τ = 4", partial(semi_axis, 1), RADIUS, 1e-6, circle, 1.2248),
        Check(place, "rate at which D decays, τ = 0.5 to 1", decay, rate, 2e-3,
              "linear theory, γ / ((1 + λ) μ R)"),
    ]  # fmt: skip


def _shear() -> list[Check]:
    place, readings = "Figure 3.2", ("Ca = 0.2 in the thesis's reading", "Ca = 0.2, physical")
    found = [
        Check(place, f"D({tau:g}), λ = 1, {readings[0]}", partial(deformation, 1.0, 0, tau), true,
              1e-3, SPECTRAL)
        for tau, true in SERIES.items()
    ]  # fmt: skip
    found += [
        Check(place, f"steady D, λ = {ratio:g}, {reading}", partial(deformation, ratio, k, 8.0),
              STEADY[ratio][k], 1e-3, SPECTRAL, None if k else 0.1)
        for k, reading in enumerate(readings) for ratio in STEADY
    ]  # fmt: skip
    kept = "the droplet cannot be compressed"
    return [*found, Check(place, "change of area by τ = 8, λ = 0.2", area_lost, 0.0, 1e-12, kept)]


def _far_from_round() -> list[Check]:
    return [
        Check("Figure 3.3", "D(10) from 24 points less that from 96, Ca = 0.5", refined_away, 0.0,
              2e-4, "the same equations, four times as many points")
    ]  # fmt: skip


def _between_plates() -> list[Check]:
    return [
        Check("Figure 3.4", "(D / D unbounded - 1) W², W = 16", excess, far_plates(1.0), 0.02,
              "plates far away, small Ca"),
        Check("Figure 3.5", "two droplets that swap: sum of their heights at τ = 4", sum_of_heights,
              0.0, 1e-6, "symmetry", long=True),
    ]  # fmt: skip


def run(flow: Surroundings, bodies: Any, end: float, tolerance: float, every: float) -> History:
    """Bodies carried by a flow, with steps to a tolerance."""
    stepper, rule = Adaptive(tolerance), PolarRule(1e-7)
    return record(Simulation(flow, bodies, stepper, rule=rule).run(end, every=every))


@cache
def relaxed() -> History:
    """An ellipse 1.5 : 1 of the area 4.7126 at rest, 32 points."""
    axes = (RADIUS * np.sqrt(ASPECT), RADIUS / np.sqrt(ASPECT))
    droplet = Droplet(spline_ellipse(axes, points=32), TENSION)
    return run(FreeFlow(at_rest(dimension=2)), droplet, 4.0, 1e-6, 0.5)


def semi_axis(number: int) -> float:
    """The final one along x or y: the tips stay on the axes."""
    return float(abs(relaxed().last.droplet.shape.evaluate(TIPS)[number, number]))


def decay() -> float:
    """Rate of ln D."""
    early, late = relaxed().deformation[1:3]
    return 2 * float(np.log(early / late))


@cache
def sheared(ratio: float, reading: int) -> History:
    """24 points to τ = 8."""
    tension: SurfaceTension = (TENSION, capillary_tension(0.2))[reading]
    droplet = Droplet(spline_circle(points=24), tension, ratio)
    return run(FreeFlow(shear(dimension=2)), droplet, 8.0, 1e-5, 0.2)


def deformation(ratio: float, reading: int, tau: float) -> float:
    """Taylor's D at a time."""
    history = sheared(ratio, reading)
    return float(history.deformation[np.isclose(history.times, tau)][0])


def area_lost() -> float:
    """Relative change of the area."""
    area = sheared(0.2, 0).volume
    return float(area[-1] / area[0] - 1)


def refined_away() -> float:
    """The change by more points and a higher degree, in the thesis's reading Ca = 1."""
    tension, free = thesis_tension_2d(1.0), FreeFlow(shear(dimension=2))
    coarse, fine = (
        run(free, Droplet(spline_circle(points=n, degree=p), tension), 10.0, 1e-5, 10.0)
        for n, p in ((24, 4), (96, 6))
    )
    return float(coarse.deformation[-1] - fine.deformation[-1])


def excess() -> float:
    """The change of D by plates at ±16, times 16²."""
    droplet = Droplet(spline_circle(points=24), TENSION)
    bounded = run(between_plane_plates(16.0, parts=4), droplet, 8.0, 1e-5, 8.0)
    free = run(FreeFlow(shear(dimension=2)), droplet, 8.0, 1e-5, 8.0)
    return float(bounded.deformation[-1] / free.deformation[-1] - 1) * 256


def sum_of_heights() -> float:
    """A turn by 180 degrees takes one droplet to the other, between plates at ±2.2."""
    droplets = [Droplet(spline_circle(points=24, centre=c), TENSION) for c in SWAP]
    last = run(between_plane_plates(2.2, parts=6), droplets, 4.0, 1e-3, 4.0).last
    return float(sum(body.centre[1] for body in last.bodies))
