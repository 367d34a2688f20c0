"""Grids and files against exact geometry and fields that are known everywhere."""

import meshio
import numpy as np
import pytest
from post_stand_ins import FlowInBox, PositionField, pipe, quarter_cylinder, tetrahedra_in_box

from cadbem.boundary import Boundary
from cadbem.errors import CadbemError
from cadbem.post import bezier_grid, tessellated, volume_grid, write_mesh, write_vtu

pyvista = pytest.importorskip("pyvista")


def linear(x):
    """Each component another linear function of position."""
    return np.stack([2 * x[0] - x[1], x[2] + 1, x[0] + 3 * x[2]])


def drawn(grid):
    """The surface that VTK makes of curved cells, sixteen pieces a direction."""
    return grid.extract_surface(algorithm="dataset_surface", nonlinear_subdivision=4)


def test_cells_are_exactly_round():
    """Every point that VTK computes on the cells has distance r to the axis, in single
    precision, though the patch has degrees 1 and 2; the control points lie off it by 0.08."""
    boundary = Boundary((quarter_cylinder(radius=0.5),)).refined(2)
    points = drawn(bezier_grid(boundary)).points
    assert len(points) > 500
    np.testing.assert_allclose(np.hypot(points[:, 0], points[:, 1]), 0.5, atol=1e-7)


def test_fields_on_cells_are_exact():
    """An affine function of position, given by its control values, is that function at the
    points drawn."""
    boundary = pipe().refined(2)
    grid = bezier_grid(boundary, {"velocity": PositionField(boundary, linear)})
    surface = drawn(grid)
    np.testing.assert_allclose(surface["velocity"].T, linear(surface.points.T), atol=2e-6)


def test_numbers_of_cells():
    grid = bezier_grid(pipe().refined(2))
    assert grid.n_cells == 6 * 4
    assert list(grid.field_data["names"]) == ["inlet", "outlet", "walls"]
    assert grid.cell_data["face"].tolist() == [1] * 16 + [2] * 4 + [3] * 4
    assert grid.cell_data["name"].tolist() == [2] * 16 + [0] * 4 + [1] * 4
    assert grid.cell_data["patch"].tolist() == np.repeat(range(6), 4).tolist()


def test_vtu_keeps_weights_bit_for_bit(tmp_path):
    grid = bezier_grid(pipe().refined(2))
    again = pyvista.read(write_vtu(tmp_path / "new folder" / "pipe.vtu", grid))
    assert again.point_data["RationalWeights"].tobytes() == grid["RationalWeights"].tobytes()
    assert again.points.tobytes() == grid.points.tobytes()
    np.testing.assert_array_equal(again.cell_data["HigherOrderDegrees"], [[2, 2, 1]] * 24)
    # by its role too, or VTK would draw the cells without weights
    assert again.GetPointData().GetRationalWeights() is not None
    points = drawn(again).points
    assert np.hypot(points[:, 0], points[:, 1]).max() < 1 + 1e-6


def test_vtu_is_asked_for(tmp_path):
    with pytest.raises(CadbemError, match=r"pipe\.vtk.*\.vtu"):
        write_vtu(tmp_path / "pipe.vtk", bezier_grid(pipe()))


def test_volume_grid_reproduces_linear_fields():
    """Linear interpolation on tetrahedra is exact for a linear velocity and pressure."""
    points, tetrahedra = tetrahedra_in_box(counts=(3, 2, 2))

    class Linear:
        velocity_at = staticmethod(lambda x, quadrature: linear(x))
        pressure_at = staticmethod(lambda x, quadrature: 4 - x[0])

    grid = volume_grid(points, tetrahedra, Linear())
    assert grid.volume == pytest.approx(2.0)
    inside = np.random.default_rng(0).random((50, 3)) * [2, 1, 1]
    probed = pyvista.PolyData(inside).sample(grid)
    np.testing.assert_allclose(probed["velocity"].T, linear(inside.T), atol=1e-12)
    np.testing.assert_allclose(probed["pressure"], 4 - inside[:, 0], atol=1e-12)


@pytest.mark.parametrize("ending", [".xdmf", ".msh", ".vtk", ".vtu"])
def test_other_formats_keep_mesh_and_fields(tmp_path, ending):
    points, tetrahedra = tetrahedra_in_box(counts=(2, 2, 2))
    grid = volume_grid(points, tetrahedra, FlowInBox())
    again = meshio.read(write_mesh(tmp_path / f"flow{ending}", grid))
    np.testing.assert_allclose(again.points, points.T, atol=1e-12)
    np.testing.assert_array_equal(again.cells_dict["tetra"], tetrahedra.T)
    np.testing.assert_allclose(again.point_data["pressure"], 3 - points[0], atol=1e-12)


def test_surface_as_triangles(tmp_path):
    """A closed surface of triangles in an .stl file: its volume by the divergence theorem is
    that of the inscribed prism; normals point into the fluid, so it is negative."""
    again = meshio.read(write_mesh(tmp_path / "pipe.stl", tessellated(pipe(), density=16)))
    corners = again.points[again.cells_dict["triangle"]]
    volume = np.linalg.det(corners).sum() / 6
    assert volume == pytest.approx(-2 * np.pi, rel=2e-3)


def test_unknown_ending_is_named(tmp_path):
    grid = volume_grid(*tetrahedra_in_box(counts=(1, 1, 1)), FlowInBox())
    with pytest.raises(CadbemError, match=r"'\.stepp'.*\.xdmf"):
        write_mesh(tmp_path / "flow.stepp", grid)
    with pytest.raises(CadbemError, match="cannot hold this mesh"):
        write_mesh(tmp_path / "flow.obj", grid)
