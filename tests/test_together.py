"""Droplets that feel each other and walls."""

from dataclasses import dataclass

import numpy as np
import pytest
from test_closed_layers import layers_of, wavy

import cadbem as cb
from cadbem.boundary import Boundary, Patch
from cadbem.spline.outlines import rectangle
from cadbem.spline.shapes import box
from cadbem.suspension.channel_flow import ChannelFlow
from cadbem.suspension.together import respond_together


@dataclass(frozen=True, eq=False)
class Undisturbed:
    """The law with which droplets of a viscosity ratio λ do not disturb a linear flow of strain
    rate E: Δf = (σ_out - σ_in)·n = 2 (1 - λ) E·n."""

    strain: np.ndarray
    ratio: float

    def jump_of(self, layers):
        return lambda points: 2 * (1 - self.ratio) * self.strain @ points.normal

    def close(self, layers, respond):
        return respond(self.jump_of(layers)), self.jump_of(layers)


def placed(dimension: int, n: int, centre, size: float) -> cb.ClosedSpline:
    shape = wavy(dimension, n)
    middle = np.reshape(centre, (-1, *[1] * (shape.coefficients.ndim - 1)))
    return cb.ClosedSpline(shape.basis, size * shape.coefficients + middle)


def errors(flow, surroundings, shapes, ratios) -> float:
    """Largest difference of the interfaces' velocities from the undisturbed linear flow."""
    dim = shapes[0].dimension
    strain = flow.gradient(np.zeros((dim, 1)))[..., 0]
    strain = (strain + strain.T) / 2
    drops = [cb.Droplet(s, Undisturbed(strain, r), r) for s, r in zip(shapes, ratios, strict=True)]
    layers = [layers_of(s, cb.PolarRule(1e-5)) for s in shapes]
    found = respond_together(surroundings, drops, layers)
    return max(
        np.abs(
            of.operator.collocation.values(r.velocity) - flow.velocity(of.targets.position)
        ).max()
        for of, r in zip(layers, found, strict=True)
    )


@pytest.mark.parametrize("gap", [1.0, 0.05])
@pytest.mark.parametrize("dimension", [2, 3])
def test_two_droplets_in_a_linear_flow(dimension, gap):
    """Different viscosity ratios, far apart and almost touching (in diameters of about 2)."""
    flow = cb.shear(dimension=dimension)
    shapes = [placed(dimension, 12, np.zeros(dimension), 1.0)]
    width = np.ptp(shapes[0].points()[0])
    shift = np.zeros(dimension)
    shift[0] = width + gap
    shapes.append(placed(dimension, 12, shift, 1.0))
    assert errors(flow, cb.FreeFlow(flow), shapes, (0.3, 4.0)) < (2e-4 if dimension == 2 else 2e-3)


@pytest.mark.parametrize("dimension", [2, 3])
def test_droplet_in_a_box_with_linear_flow(dimension):
    """Walls move with the flow u = E x; the last face is held by its traction 2 E·n, n into the
    fluid.  Neither walls nor droplet disturb it."""
    strain = np.diag([1.0, -0.4, -0.6] if dimension == 3 else [1.0, -1.0])
    flow = cb.linear_flow(strain)
    half = np.array([3.0, 2.5, 2.5])[:dimension]
    faces = (box if dimension == 3 else rectangle)(-half, half)
    boundary = Boundary(tuple(Patch(f, f"face{i}", i + 1) for i, f in enumerate(faces)))
    boundary = boundary.elevated(2).refined(3 if dimension == 3 else 6)
    last = boundary.patches[-1].middle()
    conditions = {n: cb.Velocity(lambda x: strain @ x) for n in boundary.names[:-1]}
    conditions[boundary.names[-1]] = cb.Traction(tuple(2 * strain @ last.normal[:, 0]))
    problem = cb.StokesProblem(boundary, 1.0, conditions)
    shape = placed(dimension, 12, 0.2 * np.ones(dimension), 1.0)
    for ratio in (1.0, 5.0):
        assert errors(flow, ChannelFlow(problem), [shape], [ratio]) < 1e-3
