"""Points inside and outside of boundaries, and their distances to it."""

from pathlib import Path

import numpy as np
import pytest
from shapes import bulged, channel

import cadbem as cb
from cadbem.boundary import Boundary, Patch
from cadbem.problems.enclosure import Enclosure, inside
from cadbem.spline.outlines import circle, rectangle
from cadbem.spline.shapes import ellipsoid, plate, sphere, sphere_octants, sphere_with_poles

GEOMETRIES = Path(__file__).parents[1] / "geometries"
ROOT = np.sqrt(2)


def of(surfaces, name="body"):
    return tuple(Patch(s, name) for s in surfaces)


def directions(count, dimension=3, seed=0):
    vectors = np.random.default_rng(seed).normal(size=(dimension, count))
    return vectors / np.linalg.norm(vectors, axis=0)


@pytest.mark.parametrize("shape", [sphere, sphere_octants, sphere_with_poles])
@pytest.mark.parametrize("inwards", [False, True])
def test_sphere(shape, inwards):
    """Around and in a sphere of radius 2, its poles included: the distance is ±(r - 2), the normal
    ±x/r; fluid inside or outside, from 1e-7 off the surface to far away and half-way to the centre
    (at the centre all points are nearest, and steps towards the nearest one are small)."""
    middle = np.array([1.0, 2.0, 3.0])
    ways = np.concatenate([directions(200), np.eye(3), -np.eye(3)], axis=1)
    boundary = Boundary(of(shape(2.0, middle, inwards=inwards))).elevated(3).refined(2)
    enclosure, sign = Enclosure(boundary), -1 if inwards else 1
    for radius in (1.2, 1.9, 2 - 1e-7, 2 + 1e-7, 2.1, 5.0):
        found = enclosure.clearance(middle[:, None] + radius * ways)
        assert found.distance == pytest.approx(sign * (radius - 2), abs=1e-11)
        assert abs(found.normal - sign * ways).max() < 1e-5
    far_and_middle = np.array([[1e3, 1.0], [0, 2], [0, 3]])
    assert enclosure.inside(far_and_middle).tolist() == [not inwards, inwards]


def test_box():
    """In a box the distance is the least to a side; outside, at edges and corners too, it is the
    length of what sticks out of the box."""
    half = np.array([[1.0], [0.5], [0.5]])
    boundary = channel().elevated(2).refined(3)
    points = np.random.default_rng(1).uniform(-1.5, 1.5, (3, 2000))
    over = np.abs(points) - half
    exact = np.where((over < 0).all(axis=0), -over.max(axis=0), 0.0)
    exact -= np.linalg.norm(np.maximum(over, 0), axis=0)
    found = Enclosure(boundary).clearance(points)
    assert abs(found.distance - exact).max() < 1e-12
    assert (inside(boundary, points) == (over < 0).all(axis=0)).all()


def test_reentrant_edge():
    """Close to the edge where both branches of the Y-junction meet: the fluid is all that is not
    in the wedge x < 3√2 - |y - 5√2| between them, its own nearest points all lie on the edge."""
    boundary = cb.read_cad(GEOMETRIES / "y_junction.step")
    angles = np.linspace(0, 2 * np.pi, 400, endpoint=False) + 1e-3
    around = np.stack([np.cos(angles), np.sin(angles), 0 * angles])
    wedge = around[0] < -abs(around[1])
    enclosure = Enclosure(boundary)
    for radius in (1e-6, 1e-3, 0.5):
        points = np.array([[3 * ROOT], [5 * ROOT], [1.7]]) + radius * around
        found = enclosure.clearance(points, reach=1.0)
        assert ((found.distance > 0) == ~wedge).all()
        beyond = around[0] > abs(around[1])
        assert found.distance[beyond] == pytest.approx(radius, abs=1e-12)


@pytest.mark.parametrize("radius", [1e-7, 1e-3, 0.7])
def test_corners_and_edges(radius):
    """Points about all corners and edges of the T-junction (see its drawing), salient ones,
    re-entrant ones, and where both meet: |z| < 1/2, in the main channel or in the branch."""
    boundary = cb.read_cad(GEOMETRIES / "t_junction.step").elevated(2).refined(2)
    ends = [(u, v) for u in (0, 0.3, 1) for v in (0, 0.3, 1) if 0.3 not in (u, v) or u != v]
    about = np.array([p.surface.evaluate(*e) for p in boundary.patches for e in ends]).T
    offsets = np.random.default_rng(5).normal(size=(3, 40 * about.shape[-1]))
    x, y, z = points = np.repeat(about.reshape(3, -1), 40, axis=1) + radius * offsets
    within = (abs(y) < 0.5) & (abs(x) < 3) | (abs(x) < 0.5) & (y > -3) & (y < 0.5)
    assert (inside(boundary, points) == within & (abs(z) < 0.5)).all()


def test_reach():
    """Beyond reach: distance inf, patch -1; within it, the lower wall (number 5) of the box."""
    points = np.array([[0.0, 0.0], [0.0, 0.1], [0.0, -0.45]])
    found = Enclosure(channel()).clearance(points, reach=0.2)
    assert found.distance == pytest.approx([np.inf, 0.05])
    assert found.patch.tolist() == [-1, 4]
    assert found.normal.T.tolist() == [[0, 0, 0], [0, 0, 1]]


def test_body_in_a_box_and_ellipsoid():
    """What lies in a body is outside the fluid.  Inside the ellipsoid x·A x = 1 moved outwards by
    its normal t the distance is t, as long as t is below the least radius of curvature."""
    ball = Boundary(of(ellipsoid((0.4, 0.3, 0.2))))
    boundary = Boundary((*channel().patches, *ball.patches))
    way = directions(300)
    semi = np.array([[0.4], [0.3], [0.2]])
    foot = semi * way
    normal = way / semi / np.linalg.norm(way / semi, axis=0)
    enclosure = Enclosure(boundary)
    for t in (-0.05, -1e-5, 1e-5, 0.05):
        assert enclosure.clearance(foot + t * normal).distance == pytest.approx(t, abs=1e-9)
    assert inside(boundary, np.array([[0, 0.9, 1.1], [0, 0, 0], [0, 0, 0]])).tolist() == [0, 1, 0]


def test_curved_sides_by_solid_angle():
    """Inside a closed surface ∮ r·n/r³ dS = 4π seen from inside with n outwards, else 0; points
    at least 0.05 from the surface, by the distance in question, with 40² Gauss points a patch."""
    boundary = bulged()
    points = np.random.default_rng(3).uniform(-1.7, 1.7, (3, 300))
    found = Enclosure(boundary).clearance(points)
    clear = abs(found.distance) > 0.05
    nodes, weights = boundary.refined(4).quadrature(20)
    gap = nodes.position[:, None] - points[:, clear, None]
    angle = (gap * nodes.normal[:, None]).sum(axis=0) / np.linalg.norm(gap, axis=0) ** 3 @ weights
    assert ((angle < -2 * np.pi) == (found.distance[clear] > 0)).all()
    assert clear.sum() > 200


def test_plates():
    """An open plate has fluid on both sides: nothing is outside, normals point to the asker."""
    boundary = Boundary(of(plate(1.0, 4.0)))
    found = Enclosure(boundary).clearance(np.array([[0.1, 0.1], [0.2, 0.2], [0.3, -0.3]]))
    assert found.distance == pytest.approx([0.3, 0.3])
    assert found.normal[2] == pytest.approx([1, -1])


def test_plane():
    """A round body of radius 0.1 in a rectangle."""
    boundary = Boundary(of(rectangle((-1, -0.25), (1, 0.25)), "walls") + of(circle(0.1)))
    points = np.array([[0, 0.15, 0.9, 1.3, 0], [0, 0, 0.2, 0.65, 0.2]])
    found = Enclosure(boundary.elevated(3).refined(4)).clearance(points)
    assert found.distance == pytest.approx([-0.1, 0.05, 0.05, -0.5, 0.05], abs=1e-12)
    assert found.normal[:, 4] == pytest.approx([0, -1])
