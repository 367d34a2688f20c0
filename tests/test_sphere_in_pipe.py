"""A sphere on the axis of a round pipe, against Haberman and Sayre's series (1958)."""

import json
from pathlib import Path
from pipes import ends

import numpy as np
import pytest

from cadbem.boundary import Boundary, Patch
from cadbem.problems.conditions import Inflow, NoSlip, Pressure, RigidMotion
from cadbem.problems.stokes import StokesProblem
from cadbem.quadrature import Quadrature
from cadbem.spline.shapes import cylinder, sphere

DATA = json.loads((Path(__file__).parent / "data" / "reference.json").read_text())
HALF_LENGTH = 3.0  # in radii of the pipe; what a sphere adds falls like exp(-4.5 x) there


def pipe_with_sphere(radius, elements=12, width=0.6):
    """Elements along the pipe are short, of knots at ``width`` sinh t, next to the sphere."""
    places = np.linspace(-1, 1, elements + 1)[1:-1] * np.arcsinh(HALF_LENGTH / width)
    along = 0.5 + 0.5 * width / HALF_LENGTH * np.sinh(places)
    side = cylinder(1.0, 2 * HALF_LENGTH, (-HALF_LENGTH, 0, 0))
    wall = [Patch(s.elevated((4, 4)).inserted([along, [0.5]]), "wall") for s in side]
    ball = Boundary(tuple(Patch(s, "body") for s in sphere(radius))).refined(2)
    return Boundary((*wall, *ends(HALF_LENGTH), *ball.patches))


@pytest.mark.parametrize("radius", [pytest.param(0.2, marks=pytest.mark.long), 0.4])
@pytest.mark.parametrize("moves", [True, False])
def test_drag_in_a_pipe(radius, moves):
    """Drag 6πμa (K₁ U - K₂ V₀): K₁ of a sphere that moves without flow through the pipe, closed at
    its inlet; K₂ of one held in developed flow of the velocity V₀ = 1 on the axis."""
    exact = float(DATA["sphere_on_tube_axis"][str(radius)]["K1" if moves else "K2"])
    conditions = {"wall": NoSlip(), "outlet": Pressure(0.0)}
    conditions["inlet"] = NoSlip() if moves else Inflow(mean_velocity=0.5)
    conditions["body"] = RigidMotion((-1.0, 0.0, 0.0)) if moves else NoSlip()
    problem = StokesProblem(pipe_with_sphere(radius), 1.0, conditions, Quadrature(1e-6))
    force = problem.solve().force("body")
    assert force[0] / (6 * np.pi * radius) == pytest.approx(exact, rel=3e-5)
    assert abs(force[1:]).max() < 1e-6
