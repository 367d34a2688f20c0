"""Checks of the thesis's benchmark IV, and of rigid bodies beyond it: pairs, walls, ellipsoids."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cache, partial

import numpy as np

from cadbem.boundary import Boundary, Patch
from cadbem.problems.conditions import Background, Condition, NoSlip, RigidMotion
from cadbem.problems.solution import StokesSolution
from cadbem.problems.stokes import StokesProblem
from cadbem.quadrature import Quadrature
from cadbem.spline.nurbs import Nurbs
from cadbem.spline.shapes import ellipsoid, sphere, sphere_octants, sphere_with_poles
from cadbem.verification.check import Check
from cadbem.verification.walls import near_wall

STOKES = "Stokes, 6πμaU and 8πμa³Ω"
PAIR, BROADSIDE, ENDWISE = 0.742258285069086028, 25.9916348835661665, 22.6937530132454298
MOTION = RigidMotion(velocity=(1.0, 0.0, 0.0), angular_velocity=(0.0, 1.0, 0.0))
SLIDING = RigidMotion(velocity=(1.0, 0.0, 1.0), angular_velocity=(1.0, 0.0, 0.0))
AT_REST = Background()
PARABOLOID = Background(
    velocity=lambda x: np.array([x[2] ** 2, 0 * x[0], 0 * x[0]]), pressure=lambda x: 2 * x[0]
)
# height of the centre over the radius: drag along the wall, torque, drag away from it, each over
# that without a wall
WALL = {
    2.0: (1.3827523824112236, 1.0417835548066146, 2.1255355667600392),
    1.1: (2.2643030353880422, 1.454851210016983, 11.4591572034095570),
    1.01: (3.4225329663656340, 2.2407976493685187, 101.8961723246098223),
}
NEAREST = 1.01
UNITS = np.array([6.0, 8.0, 6.0]) * -np.pi  # of the three, with the sign that the body feels


def checks() -> tuple[Check, ...]:
    """Of single bodies, a pair, and a sphere near a wall."""
    figure = "Figure 2.19"
    single = (
        Check(figure, "moving sphere: drag", partial(drag, sphere), 6 * np.pi, 1e-9, STOKES),
        Check(figure, "moving sphere with poles: drag", partial(drag, sphere_with_poles),
              6 * np.pi, 1e-9, STOKES),
        Check(figure, "turning sphere: torque", torque, 8 * np.pi, 1e-9, STOKES),
        Check("Figure 2.20", "speed beside a moving sphere, at r = 2", speed, 0.40625, 1e-7,
              "Stokes, 3/4r + 1/4r³"),
        Check("Beyond", "sphere held in the flow u = z²: force", faxen, 2 * np.pi, 2e-4, "Faxén"),
        Check("Beyond", "ellipsoid 2 : 1 : 1: drag endwise", partial(spheroid, 0), ENDWISE,
              1e-4, "Perrin"),
        Check("Beyond", "ellipsoid 2 : 1 : 1: drag broadside", partial(spheroid, 1), BROADSIDE,
              1e-4, "Perrin"),
        Check("Beyond", "two spheres in line, two diameters apart: drag of both", pair,
              12 * np.pi * PAIR, 1e-5, "Stimson and Jeffery"),
    )  # fmt: skip
    names = ("drag along the wall", "torque", "drag away from it")
    walls = tuple(
        Check("Beyond", f"sphere at {height:g} a over a wall: {name}",
              partial(_at_wall, height, k), values[k], 5e-4 if height > NEAREST else 1e-3,
              "bispherical series (O'Neill, Brenner)", long=height == NEAREST)
        for height, values in WALL.items() for k, name in enumerate(names)
    )  # fmt: skip
    return single + walls


@cache
def moving(shape: Callable[[], tuple[Nurbs, ...]]) -> StokesSolution:
    """A unit sphere that moves along x and turns about y."""
    return flow_around(shape(), 1, 2, MOTION)


def drag(shape: Callable[[], tuple[Nurbs, ...]]) -> float:
    """Of a moving unit sphere, against its motion."""
    return -float(moving(shape).force("body")[0])


def torque() -> float:
    """Of a turning unit sphere."""
    return -float(moving(sphere).torque("body", (0, 0, 0))[1])


def speed() -> float:
    """Beside a sphere that moves along x, where its turning about y adds nothing."""
    return float(moving(sphere).velocity_at([[0.0], [2.0], [0.0]])[0, 0])


def faxen() -> float:
    """F = 6πμa (1 + a² ∇² / 6) u at the centre, where u = 0 and ∇²u = 2."""
    held = flow_around(sphere_octants(), 2, 4, NoSlip(), PARABOLOID)
    return float(held.force("body")[0])


@cache
def _pulled() -> StokesSolution:
    return flow_around(ellipsoid((2, 1, 1)), 4, 2, RigidMotion((1.0, 1.0, 1.0)))


def spheroid(axis: int) -> float:
    """Drag of an ellipsoid along an axis."""
    return -float(_pulled().force("body")[axis])


def pair() -> float:
    """Drag of two spheres along the line of their centres."""
    low, high = (sphere(centre=(0, 0, side * 2.0)) for side in (-1, 1))
    both = flow_around(low + high, 4, 2, RigidMotion((0.0, 0.0, 1.0)))
    return -float(both.force("body")[2])


def flow_around(
    shape: tuple[Nurbs, ...], degree: int, spans: int, condition: Condition,
    background: Background = AT_REST, tolerance: float = 1e-10,
) -> StokesSolution:  # fmt: skip
    """Flow around one body, or several that move alike."""
    patches = tuple(Patch(surface, "body") for surface in shape)
    boundary = Boundary(patches).elevated(degree).refined(spans)
    quadrature = Quadrature(tolerance)
    return StokesProblem(boundary, 1.0, {"body": condition}, quadrature, background).solve()


@cache
def _beside_wall(height: float) -> np.ndarray:
    """Drag along the wall, torque and drag away from it, over those without a wall.

    A sphere that moves along x and z and turns about x feels all three at once: by symmetry each
    component of force and torque belongs to one of the motions.
    """
    fine = {"elements": 14, "rings": 15, "across": 6}
    coarse = {"elements": 4 if height > 1.5 else 8, "rings": 9, "across": 4}
    boundary = near_wall(height, **(fine if height == NEAREST else coarse))
    given: dict[str, Condition] = {
        "body": replace(SLIDING, centre=(0.0, 0.0, height)),
        "wall": NoSlip(),
    }
    solution = StokesProblem(boundary, 1.0, given, Quadrature(1e-6)).solve()
    force, moment = solution.force("body"), solution.torque("body", (0, 0, height))
    return np.array([force[0], moment[0], force[2]]) / UNITS


def _at_wall(height: float, which: int) -> float:
    return float(_beside_wall(height)[which])
