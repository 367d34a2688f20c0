"""Checks of the thesis's Y-junction, by way of a CAD file: figures 4.9 to 4.11.

Branches 4 wide and high that meet in a plane of symmetry, y = 5√2; mean velocity 3 in both inlets.
The thesis does not give all lengths: this is the drawing in geometries/.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from cadbem.boundary import Boundary, Patch
from cadbem.cad import read_cad, write_patches
from cadbem.problems.conditions import Condition, Inflow, NoSlip, Pressure
from cadbem.problems.solution import StokesSolution
from cadbem.problems.stokes import StokesProblem
from cadbem.quadrature import Quadrature
from cadbem.spline.closed_shapes import spline_sphere
from cadbem.spline.nurbs import Nurbs
from cadbem.spline.shapes import parallelogram
from cadbem.suspension.bodies.droplet import Droplet
from cadbem.suspension.interface.laws import capillary_tension
from cadbem.suspension.surroundings.channel_flow import ChannelFlow
from cadbem.suspension.time.simulation import Simulation
from cadbem.verification.check import Check

ROOT = np.sqrt(2)
AXIS = 5 * ROOT
HEIGHT = 4.0
# corners in plan, counter-clockwise in each quadrilateral
INNER, OUTER, BEND, EDGE = (
    np.array([[x, AXIS - y], [x, AXIS + y]])
    for x, y in ((0, 3 * ROOT), (2 * ROOT, 5 * ROOT), (7 * ROOT - 2, 2), (7 * ROOT + 6, 2))
)
CROTCH, END = np.array([3 * ROOT, AXIS]), np.array([7 * ROOT + 6, AXIS])
START = (2.8284, 2.0, 2.0)
DRAWING, MIRRORED = "the drawing", "mirror symmetry"


def checks() -> tuple[Check, ...]:
    """Of the file, of the flow, and of a droplet on its way."""
    return (
        Check("Figure 4.9", "Y-junction, written as STEP and read back: volume",
              lambda: channel().volume(), 368.0, 1e-12, DRAWING),
        Check("Figure 4.9", "the same: area", lambda: channel().area(), 424 - 16 * ROOT, 1e-12,
              DRAWING),
        Check("Figure 4.9", "what leaves at the outlet", lambda: -flow().flow_rate("outlet"), 96.0,
              1e-12, "two inlets, 3 × 4 × 4 each"),
        Check("Figure 4.9", "pressures at the inlets, their difference over their mean",
              uneven_pressures, 0.0, 1e-9, MIRRORED),
        Check("Figure 4.10", "droplet: distance from the middle height at τ = 0.3",
              off_the_middle, 0.0, 1e-7, MIRRORED, long=True),
    )  # fmt: skip


def plan() -> list[np.ndarray]:
    """The floor in four quadrilaterals (4, 2)."""
    lower = [(INNER[0], OUTER[0], BEND[0], CROTCH), (CROTCH, BEND[0], EDGE[0], END)]
    upper = [(CROTCH, BEND[1], OUTER[1], INNER[1]), (END, EDGE[1], BEND[1], CROTCH)]
    return [np.array(corners) for corners in (*lower, *upper)]


def name_of(middle: np.ndarray) -> str:
    """The name of the wall over an edge with this ``middle`` (2,)."""
    ports = {"inlet_a": INNER[0] + OUTER[0], "inlet_b": INNER[1] + OUTER[1]}
    near = [name for name, ends in ports.items() if np.allclose(middle, ends / 2)]
    return near[0] if near else "outlet" if np.isclose(middle[0], END[0]) else "walls"


def patches() -> Iterator[Patch]:
    """Floor, ceiling, and what stands on edges of one quadrilateral only, normals inwards."""
    up = np.array([0.0, 0.0, HEIGHT])
    knots = np.array([0.0, 0.0, 1.0, 1.0])
    sides: Counter[tuple[float, ...]] = Counter()
    edges = []
    for corners in plan():
        a, b, c, d = np.column_stack([corners, np.zeros(4)])
        floor = Nurbs((1, 1), (knots, knots), np.array([[a, d], [b, c]]), np.ones((2, 2)))
        yield Patch(floor, "walls")
        yield Patch(floor.transformed(np.eye(3), up).swapped(), "walls")
        for start, end in ((a, b), (b, c), (c, d), (d, a)):
            edges.append((start, end))
            sides[_key(start, end)] += 1
    for start, end in edges:
        if sides[_key(start, end)] == 1:
            yield Patch(parallelogram(start, up, end - start), name_of((start + end)[:2] / 2))


def _key(start: np.ndarray, end: np.ndarray) -> tuple[float, ...]:
    return tuple(np.round(start + end, 9).tolist())


@cache
def channel() -> Boundary:
    """The junction, after a way through a STEP file."""
    with TemporaryDirectory() as folder:
        file = write_patches(Path(folder) / "y_junction.step", Boundary(tuple(patches())))
        return read_cad(file)


@cache
def problem() -> StokesProblem:
    """Three by three quadratic elements a patch."""
    given: dict[str, Condition] = {
        "inlet_a": Inflow(mean_velocity=3.0),
        "inlet_b": Inflow(mean_velocity=3.0),
        "outlet": Pressure(0.0),
        "walls": NoSlip(),
    }
    return StokesProblem(channel().elevated(2).refined(3), 1.0, given, Quadrature(1e-6))


@cache
def flow() -> StokesSolution:
    """The junction without bodies."""
    return problem().solve()


def uneven_pressures() -> float:
    """Relative difference."""
    first, second = (flow().mean_pressure(f"inlet_{name}") for name in "ab")
    return 2 * (first - second) / (first + second)


def off_the_middle() -> float:
    """Height of a droplet of radius 1 less half the channel's, Ca = 0.05."""
    droplet = Droplet(spline_sphere(centre=START, points=128), capillary_tension(0.05))
    *_, last = Simulation(ChannelFlow(problem()), droplet).run(0.3, every=0.3)
    return float(last.droplet.centre[2]) - HEIGHT / 2
