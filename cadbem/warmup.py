"""Compiles the kernels ahead by the smallest flows and droplets that use all of them."""

from __future__ import annotations

import numpy as np
from tqdm import tqdm

from cadbem.boundary import Boundary, Patch
from cadbem.problems.conditions import Condition, Inflow, NoSlip, Pressure
from cadbem.problems.stokes import StokesProblem
from cadbem.spline.closed import ClosedSpline, spline_circle, spline_sphere
from cadbem.spline.shapes import box
from cadbem.suspension.droplet import Droplet
from cadbem.suspension.flows import shear
from cadbem.suspension.free_flow import FreeFlow
from cadbem.suspension.interface import SurfaceTension
from cadbem.suspension.simulation import Simulation


def warm_up(progress: bool = True) -> None:
    """Run every compiled function once; numba keeps the machine code on disk."""
    names = ("inlet", "outlet", "walls", "walls", "walls", "walls")
    patches = [Patch(s, n, i + 1) for i, (s, n) in enumerate(zip(box(), names, strict=True))]
    boundary = Boundary(tuple(patches)).elevated(2).refined(2)
    conditions: dict[str, Condition] = {
        "inlet": Inflow(mean_velocity=1.0),
        "outlet": Pressure(0.0),
        "walls": NoSlip(),
    }
    problem = StokesProblem(boundary, 1.0, conditions)
    points = np.array([[0.5, 0.5], [0.5, 0.5], [0.5, 1e-3]])
    steps = (
        lambda: problem.layers,
        lambda: problem.solve().velocity_at(points),
        lambda: problem.solve().pressure_at(points),
        lambda: _move(spline_circle(points=24)),
        lambda: _move(spline_sphere(points=128)),
    )
    for step in tqdm(steps, desc="compiling", disable=None if progress else True):
        step()


def _move(shape: ClosedSpline) -> None:
    """A droplet with another viscosity than its surroundings: single and double layer."""
    drop = Droplet(shape, SurfaceTension(1.0), viscosity_ratio=0.5)
    list(Simulation(FreeFlow(shear(dimension=shape.dimension)), drop).run(1e-3))
