"""Checks of the thesis's benchmarks I and II: heat conduction in a ring and in a hollow sphere.

Inner radius 1 at the temperature 2, outer radius 2, where Bi = Bi_r = 1 to surroundings at 1: heat
-q leaves there with q = (φ - 1) + (φ⁴ - 1).
"""

from __future__ import annotations

from functools import cache

import numpy as np

from cadbem.boundary import Boundary, Patch
from cadbem.problems.heat import HeatProblem
from cadbem.problems.heat_conditions import HeatCondition, HeatFlux, SurfaceExchange, Temperature
from cadbem.problems.heat_solution import HeatSolution
from cadbem.quadrature import Quadrature
from cadbem.spline.basis import Array
from cadbem.spline.outlines import circle, line
from cadbem.spline.shapes import sphere
from cadbem.verification.check import Check

OUTSIDE = SurfaceExchange(convection=1.0, radiation=1.0, ambient=1.0)
RING_SLOPE = -1.2812099885298150074  # of φ = 2 + C ln r
SHELL_HEAT = 1.8340512420877237118  # of φ = 2 + C (1/r - 1)
QUARTIC = "exact profile, its constant the root of a quartic"
IN_HOLE = np.array([[0.3], [0.2], [0.1]])
RADII = np.linspace(1.05, 1.95, 25)


def checks() -> tuple[Check, ...]:
    """Of temperatures and of the heat that passes."""
    return (
        Check("Figure 2.7", "ring: temperature at r = 1.5",
              lambda: ring(32).temperature_at([[1.2], [0.9]])[0],
              1.48051405349149851, 1e-7, QUARTIC),
        Check("Figure 2.7", "ring: heat that passes a quarter",
              lambda: ring(32).heat_rate("inner"), -RING_SLOPE * np.pi / 2, 1e-7, QUARTIC),
        Check("Figure 2.8", "ring: mean error on the sides (%), 12 points",
              lambda: error_on_sides(ring(1)), 0.0, 0.1, "exact profile", 0.1),
        Check("Figure 2.8", "ring: mean error on the sides (%), 136 points",
              lambda: error_on_sides(ring(32)), 0.0, 1e-5, "exact profile", 1e-5),
        Check("Figure 2.14", "hollow sphere: temperature at r = 1.5",
              lambda: shell().temperature_at([[0.0], [0.0], [1.5]])[0],
              1.38864958597075876, 1e-7, QUARTIC),
        Check("Figure 2.14", "hollow sphere: largest error at 25 points on a ray",
              shell_error, 0.0, 1e-6, "exact profile"),
        Check("Figure 2.14", "hollow sphere: heat that passes",
              lambda: shell().heat_rate("inner"), 4 * np.pi * SHELL_HEAT, 1e-9, QUARTIC),
    )  # fmt: skip


def quarter_ring() -> Boundary:
    """Normals, to the right of each curve's direction, point into the body."""
    return Boundary(
        (
            Patch(circle(1.0)[0], "inner"),
            Patch(circle(2.0, inwards=True)[-1], "outer"),
            Patch(line((2, 0), (1, 0)), "symmetry"),
            Patch(line((0, 1), (0, 2)), "symmetry"),
        )
    )


@cache
def ring(spans: int) -> HeatSolution:
    """A quarter of the ring, degree 2, so many elements a side."""
    given: dict[str, HeatCondition] = {
        "inner": Temperature(2.0),
        "outer": OUTSIDE,
        "symmetry": HeatFlux(0.0),
    }
    boundary = quarter_ring().elevated(2).refined(spans)
    return HeatProblem(boundary, 1.0, given, quadrature=Quadrature(1e-12)).solve()


def error_on_sides(solution: HeatSolution) -> float:
    """Mean absolute percentage error at the collocation points of the straight sides (Eq. 2.34)."""
    space = solution.space
    sides = slice(space.offsets[2], space.offsets[4])
    found = space.values(solution.temperature.coefficients)[0, sides]
    radius = np.linalg.norm(space.collocation.position[:, sides], axis=0)
    return float(100 * abs(found / (2 + RING_SLOPE * np.log(radius)) - 1).mean())


def hollow_sphere() -> Boundary:
    """Twelve patches without poles, normals into the body."""
    inner = [Patch(s, "inner") for s in sphere(1.0)]
    outer = [Patch(s, "outer") for s in sphere(2.0, inwards=True)]
    return Boundary((*inner, *outer))


@cache
def shell() -> HeatSolution:
    """The hollow sphere."""
    given: dict[str, HeatCondition] = {"inner": Temperature(2.0), "outer": OUTSIDE}
    return HeatProblem(hollow_sphere(), 1.0, given, quadrature=Quadrature(1e-8)).solve()


def shell_error() -> float:
    """Largest relative error on the thesis's ray, the z axis."""
    found = shell().temperature_at(RADII * np.array([[0.0], [0.0], [1.0]]))
    exact: Array = 2 + SHELL_HEAT * (1 / RADII - 1)
    return float(abs(found / exact - 1).max())


def uneven(points: Array) -> Array:
    """A temperature (N,) without sources in the hollow sphere, 1 / |x - a|, a in the hole."""
    distance: Array = np.linalg.norm(points - IN_HOLE, axis=0)
    return 1 / distance


def uneven_flux(points: Array) -> Array:
    """Its heat into the body at r = 2, -∂φ/∂n with n = -x / 2."""
    return -(points / 2 * (points - IN_HOLE)).sum(axis=0) * uneven(points) ** 3
