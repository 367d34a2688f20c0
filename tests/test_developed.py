"""Developed profiles of openings of any shape, against exact ones."""

import numpy as np
import pytest

from cadbem.boundary import Boundary, Patch
from cadbem.problems.conditions import Inflow, NoSlip, Pressure
from cadbem.problems.developed import developed_profile, rim
from cadbem.problems.profiles import circle_profile, port, rectangle_profile
from cadbem.problems.stokes import StokesProblem
from cadbem.quadrature import Quadrature
from cadbem.spline import Nurbs
from cadbem.spline.outlines import circle
from cadbem.spline.shapes import parallelogram

KNOTS = np.array([0, 0, 1, 1.0])


def quadrilateral(a, b, c, d) -> Nurbs:
    """Bilinear patch with corners counter-clockwise."""
    points = np.array([[a, d], [b, c]], dtype=float)
    return Nurbs((1, 1), (KNOTS, KNOTS), points, np.ones((2, 2)))


def triangle(corners) -> list[Patch]:
    """A triangle as three quadrilaterals around its centre."""
    middles, centre = (corners + np.roll(corners, -1, axis=0)) / 2, corners.mean(axis=0)
    return [
        Patch(quadrilateral(corners[i], middles[i], centre, middles[i - 1]), "inlet")
        for i in range(3)
    ]


def test_triangle():
    """Equilateral: u / mean = 60 times the product of the barycentric coordinates, a cubic that
    vanishes on the rim, has a constant Laplacian, and whose product has the mean 1/60."""
    corners = np.array([[0, 0, 2], [1, 0, 2], [0.5, np.sqrt(0.75), 2]])
    opening = port("inlet", triangle(corners))
    assert opening.area == pytest.approx(np.sqrt(3) / 4, rel=1e-13)
    shares = np.random.default_rng(0).dirichlet([1, 1, 1], 50)
    velocity = opening.profile((shares @ corners).T)
    assert velocity == pytest.approx(60 * shares.prod(axis=1), abs=1e-10)


def test_square_and_circle():
    """Computed on the rim, the profiles that are known: to 3e-7 with corners, 1e-9 without.
    A sector of the disc has two radii and an arc as its rim; its pole is no edge."""
    sides = [(-0.5, -0.5), (-0.5, 0.0), (0.0, -0.5), (0.0, 0.0)]
    quarters = [Patch(parallelogram((0, y, z), (0, 0.5, 0), (0, 0, 0.5))) for y, z in sides]
    profile = developed_profile(quarters, np.zeros(3), np.array([1.0, 0, 0]))
    y, z = (g.ravel() for g in np.meshgrid(*[np.linspace(-0.49, 0.49, 9)] * 2))
    exact = rectangle_profile(y, z, 1.0, 1.0)
    assert abs(profile(np.array([0 * y, y, z])) - exact).max() < 3e-7
    arcs = circle(2.0)
    disc = []
    for arc in arcs:
        x = np.pad(arc.points, ((0, 0), (0, 1)))
        points = np.stack([0 * x, x], axis=1)
        knots = (arc.knots[0], KNOTS)
        disc.append(Patch(Nurbs((2, 1), knots, points, np.stack([arc.weights] * 2, axis=1))))
    assert len(rim([Nurbs(p.surface.degrees, p.surface.knots, p.surface.points[..., :2],
                          p.surface.weights) for p in disc[:1]])) == 3  # fmt: skip
    flipped = [Patch(p.surface.swapped()) for p in disc]
    opening = port("inlet", flipped)
    profile = developed_profile(flipped, opening.centre, opening.normal)
    r = np.linspace(0, 1.99, 9)
    exact = circle_profile(r, 2.0)
    assert profile(np.array([0.6 * r, 0.8 * r, 0 * r])) == pytest.approx(exact, abs=1e-8)


def test_flow_through_a_triangular_channel():
    """Equilateral, side 1: -dp/dx = 80 μU, the mean of u = (G/μ) (2/√3) d₁d₂d₃ with distances
    d = (√3/2) λ from the sides being (2/√3) (√3/2)³ / 60 = 1/80 of G/μ."""
    corners = np.array([[0, 0, 0], [1, 0, 0], [0.5, np.sqrt(0.75), 0]])
    inlet = triangle(corners)
    assert inlet[0].middle().normal[2, 0] == pytest.approx(1)
    length = np.array([0, 0, 1.5])
    outlet = [Patch(p.surface.transformed(np.eye(3), length).swapped(), "outlet") for p in inlet]
    walls = [
        Patch(parallelogram(corners[i], length, corners[(i + 1) % 3] - corners[i]), "walls")
        for i in range(3)
    ]
    boundary = Boundary((*inlet, *outlet, *walls)).elevated(3).refined(3)
    assert boundary.volume() == pytest.approx(1.5 * np.sqrt(3) / 4)
    conditions = {"inlet": Inflow(mean_velocity=1.0), "outlet": Pressure(), "walls": NoSlip()}
    solution = StokesProblem(boundary, 1.0, conditions, Quadrature(1e-6)).solve()
    gradient = solution.mean_pressure("inlet") / 1.5
    assert gradient == pytest.approx(80, rel=2e-3)
    assert abs(solution.net_flux()) < 1e-3
