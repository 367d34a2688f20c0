"""Tessellation, edges and wall stresses against closed forms."""

import numpy as np
import pytest
from post_stand_ins import ARC, PositionField, box, pipe, quarter_cylinder

from cadbem.boundary import Boundary, Patch
from cadbem.post import edge_lines, tessellated, wall_stresses
from cadbem.post.fields.cells import sharp_edges
from cadbem.spline import Nurbs

pytest.importorskip("pyvista")


def total_length(lines):
    return lines.compute_cell_sizes()["Length"].sum()


def test_area_of_a_cylinder():
    """Chords of arcs θ are short by θ²/24, so the area misses π r h / 2 by a quarter of that
    when the density is doubled."""
    boundary = Boundary((quarter_cylinder(radius=1.5, height=4.0),))
    exact = 0.5 * np.pi * 1.5 * 4.0
    coarse, fine = (exact - tessellated(boundary, n).area for n in (16, 32))
    assert 0 < fine < 1e-3 * exact
    assert coarse / fine == pytest.approx(4, rel=0.01)


def test_normals_and_winding_point_into_the_fluid():
    surface = tessellated(pipe(), patches=[0, 1, 2, 3])
    x, y, _ = surface.points.T
    np.testing.assert_allclose(surface["Normals"].T, [-x, -y, 0 * x], atol=1e-12)
    flat = surface.compute_normals(
        point_normals=False, auto_orient_normals=False, consistent_normals=False
    )
    centre = surface.cell_centers().points
    assert ((flat.cell_data["Normals"] * centre)[:, :2].sum(axis=1) < -0.9).all()


def test_normal_at_a_pole():
    """A disk's sector whose tip is one point: the normal there is that of the plane."""
    points = np.zeros((2, 3, 3))
    points[1, :, :2] = [[1, 0], [1, 1], [0, 1]]
    weights = np.broadcast_to([1, np.sqrt(0.5), 1], (2, 3)).copy()
    line = np.array([0.0, 0, 1, 1])
    sector = Patch(Nurbs((1, 2), (line, ARC), points, weights))
    normals = tessellated(Boundary((sector,)))["Normals"]
    np.testing.assert_allclose(normals, np.tile([0, 0, 1], (len(normals), 1)), atol=1e-12)


def test_wall_stresses_of_pipe_flow():
    """In a pipe of radius 1 with pressure p(z) = 5 - z and shear 0.75 along the axis the wall
    feels f = -p n + 0.75 e_z with n towards the axis."""
    boundary = pipe()

    def traction(x):
        return np.stack([(5 - x[2]) * x[0], (5 - x[2]) * x[1], 0.75 + 0 * x[2]])

    walls = tessellated(boundary, 4, {"traction": PositionField(boundary, traction)}, range(4))
    pressure, shear = wall_stresses(walls["traction"].T, walls["Normals"].T)
    np.testing.assert_allclose(pressure, 5 - walls.points[:, 2], atol=1e-12)
    np.testing.assert_allclose(shear, 0.75, atol=1e-12)


def test_edges_of_elements():
    """A unit square in 2 × 2 elements has three lines of length one each way."""
    square = Boundary(box().patches[:1]).refined(2)
    assert edge_lines(square, elements=True).compute_cell_sizes()["Length"].sum() == pytest.approx(
        6
    )
    assert edge_lines(square).compute_cell_sizes()["Length"].sum() == pytest.approx(4)


def test_sharp_edges():
    """The pipe is sharp at both rims only, the box along all its edges; each edge comes from
    two patches."""
    rims = sharp_edges(pipe())
    assert set(np.round(rims.points[:, 2], 12)) == {0.0, 2.0}
    np.testing.assert_allclose(np.hypot(*rims.points.T[:2]), 1, atol=1e-12)
    assert total_length(sharp_edges(box(length=2.0))) == pytest.approx(2 * (4 * 2 + 8 * 1))
