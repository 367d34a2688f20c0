"""Compiles all compiled functions, by small flows, bodies and heat problems that use them."""

from __future__ import annotations

import os
import warnings
from collections.abc import Callable, Iterator
from functools import partial
from typing import Any

import numpy as np

from cadbem.boundary import Boundary, Patch
from cadbem.compiled import quietly
from cadbem.errors import AccuracyWarning
from cadbem.kernels.stokes_3d import STOKES_3D
from cadbem.operators.compressed.storage import Compressed, Storage
from cadbem.operators.layers import assemble_layers, collocation_targets
from cadbem.problems.conditions import Condition, Inflow, NoSlip, Pressure
from cadbem.problems.heat import HeatProblem
from cadbem.problems.heat_conditions import HeatCondition, HeatFlux, Temperature
from cadbem.problems.stokes import StokesProblem
from cadbem.progress import progress
from cadbem.quadrature import Quadrature, Rules, UniformSubdivision
from cadbem.quadrature.panels import closest_on_panels
from cadbem.space import discontinuous_space
from cadbem.spline.closed import ClosedSpline
from cadbem.spline.closed_shapes import spline_circle, spline_sphere
from cadbem.spline.outlines import rectangle
from cadbem.spline.shapes import box, sphere_with_poles
from cadbem.suspension.bodies.body import Body
from cadbem.suspension.bodies.droplet import Droplet
from cadbem.suspension.bodies.rigid_shapes import rigid_sphere
from cadbem.suspension.interface.laws import SurfaceTension
from cadbem.suspension.surroundings.channel_flow import ChannelFlow
from cadbem.suspension.surroundings.flows import shear
from cadbem.suspension.surroundings.free_flow import FreeFlow
from cadbem.suspension.time.simulation import Simulation

Step = tuple[str, Callable[[], object]]
FAR = 100  # elements along an edge from which some are far from each other


def warm_up() -> str | None:
    """Run every compiled function once, so that its machine code is on disk.

    Returns the folder where it is, or above where it is; None if there is none to write to.
    """
    steps = list(_steps())
    with warnings.catch_warnings(), quietly(), progress(total=len(steps)) as bar:
        warnings.simplefilter("ignore", AccuracyWarning)
        for name, step in steps:
            bar.set_description(f"compiling for {name}")
            step()
            bar.update()
    functions: tuple[Any, ...] = STOKES_3D.fill, closest_on_panels
    paths = [function.stats.cache_path for function in functions]
    return None if None in paths else os.path.commonpath(paths)


def _steps() -> Iterator[Step]:
    """The steps of the warm-up: a short description of each, and a function that carries it out."""
    for dimension, place in ((3, "space"), (2, "a plane")):
        yield f"flow in {place}", partial(_flow, dimension)
        yield f"heat in {place}", partial(_heat, dimension)
    yield "droplets in space", partial(_move, spline_sphere(points=128))
    yield "droplets in a plane", partial(_move, spline_circle(points=24))
    yield "bodies in a channel", _bodies
    yield "panels with poles", partial(_assemble, Quadrature())
    yield "the thesis's rules", partial(_assemble, UniformSubdivision())
    yield "large systems", partial(_flow, 2, FAR, Compressed())


def _block(dimension: int, elements: int = 2) -> Boundary:
    """0 < x, y (, z) < 1, so many elements along each edge: inlet, outlet, and walls."""
    sides = box() if dimension == 3 else rectangle()
    names = ("inlet", "outlet", *["walls"] * (len(sides) - 2))
    patches = [Patch(s, n, i + 1) for i, (s, n) in enumerate(zip(sides, names, strict=True))]
    return Boundary(tuple(patches)).elevated(2).refined(elements)


def _points(dimension: int) -> np.ndarray:
    """Inside, and close to a wall."""
    return np.array([[0.5, 0.5]] * (dimension - 1) + [[0.5, 1e-3]])


def _channel(dimension: int, elements: int = 2, storage: Storage | None = None) -> StokesProblem:
    conditions: dict[str, Condition] = {
        "inlet": Inflow(mean_velocity=1.0),
        "outlet": Pressure(0.0),
        "walls": NoSlip(),
    }
    return StokesProblem(_block(dimension, elements), 1.0, conditions, storage=storage)


def _flow(dimension: int, elements: int = 2, storage: Storage | None = None) -> None:
    solution = _channel(dimension, elements, storage).solve()
    solution.velocity_at(_points(dimension))
    solution.pressure_at(_points(dimension))


def _heat(dimension: int) -> None:
    conditions: dict[str, HeatCondition] = {
        "inlet": Temperature(0.0),
        "outlet": Temperature(1.0),
        "walls": HeatFlux(0.0),
    }
    solution = HeatProblem(_block(dimension), 1.0, conditions).solve()
    solution.temperature_at(_points(dimension))
    solution.heat_flux_at(_points(dimension))


def _move(shape: ClosedSpline) -> None:
    """A droplet with another viscosity than its surroundings: single and double layer."""
    drop = Droplet(shape, SurfaceTension(1.0), viscosity_ratio=0.5)
    for state in Simulation(FreeFlow(shear(dimension=shape.dimension)), drop).run(1e-3):
        points = np.zeros((shape.dimension, 2))
        points[0] = 1.02, 3.0  # close to the surface, and away from it
        state.velocity_at(points)


def _bodies() -> None:
    shape = spline_sphere(0.1, (0.3, 0.5, 0.5), points=128)
    drop = Droplet(shape, SurfaceTension(1.0), viscosity_ratio=0.5)
    bodies: list[Body] = [drop, rigid_sphere(0.1, (0.7, 0.5, 0.5), spans=1)]
    list(Simulation(ChannelFlow(_channel(3)), bodies).run(1e-6))


def _assemble(quadrature: Rules) -> None:
    patches = tuple(Patch(s, "ball") for s in sphere_with_poles())
    space = discontinuous_space(Boundary(patches).refined(2))
    assemble_layers(STOKES_3D, space, collocation_targets(space), quadrature)
