"""Files of bodies in motion: times, numbers and exact fields come back."""

import numpy as np
import pytest
from post_stand_ins import box
from scipy.spatial.transform import Rotation

from cadbem.boundary import Boundary, Patch
from cadbem.errors import CadbemError, ShapeError
from cadbem.post import Frame, write_frame, write_frames, write_index
from cadbem.post.fields.body_fields import fields_of
from cadbem.spline.closed_shapes import spline_circle, spline_ellipsoid, spline_sphere
from cadbem.spline.shapes import sphere

pyvista = pytest.importorskip("pyvista")


def ball(x):
    return spline_sphere(0.2, (x, 0.5, 0.5), points=72)


def particle(patches):
    return Boundary(tuple(map(Patch, patches)))


def positions(boundary):
    """Coefficients (3, F) of the field x -> x: the control points."""
    return np.concatenate([p.surface.points.reshape(-1, 3) for p in boundary.patches]).T


def points_of(path):
    """Points and data of a file, on flat cells cut from the exact ones."""
    grid = pyvista.read(path)
    return grid.extract_surface(algorithm="dataset_surface", nonlinear_subdivision=2)


def test_files(tmp_path):
    """Times and numbers come back, and the cells lie on the spheres; an empty frame is empty."""
    both = {4: ball(0.5), 7: particle(sphere(0.2, (1.3, 0.5, 0.5)))}
    frames = [Frame(0.25, both), Frame(1.0, {})]
    path = write_frames(tmp_path / "a", frames, box())
    reader = pyvista.PVDReader(path)
    assert reader.time_values == [0.25, 1.0]
    grid = pyvista.read(tmp_path / "a" / "bodies_0000.vtu")
    assert np.bincount(grid.cell_data["body"]).tolist()[4:] == [6 * 12, 0, 0, 6]
    assert list(grid.field_data["names"]) == ["droplet 4", "particle 7"]
    surface = points_of(tmp_path / "a" / "bodies_0000.vtu")
    right = surface.points[surface.points[:, 0] > 0.9] - [1.3, 0.5, 0.5]
    np.testing.assert_allclose(np.linalg.norm(right, axis=1), 0.2, atol=1e-6)
    assert pyvista.read(tmp_path / "a" / "bodies_0001.vtu").n_cells == 0
    assert pyvista.read(tmp_path / "a" / "channel.vtu").n_cells == 6


def test_fields(tmp_path):
    """The fields u = x on both bodies and s = 2 y on the droplet alone are exact in all cells;
    a sphere of radius 0.2 has the mean curvature 5, of which a particle is not asked."""
    drop, solid = ball(0.5), particle(sphere(0.2, (1.3, 0.5, 0.5)))
    fields = {
        1: {"velocity": drop.coefficients, "s": 2 * drop.coefficients[1]},
        2: {"velocity": positions(solid)},
    }
    write_frame(tmp_path, 0, Frame(0.0, {1: drop, 2: solid}, fields))
    surface = points_of(tmp_path / "bodies_0000.vtu")
    np.testing.assert_allclose(surface.point_data["velocity"], surface.points, atol=1e-6)
    droplet = surface.points[:, 0] < 0.9
    scalar, curvature = surface.point_data["s"], surface.point_data["mean curvature"]
    np.testing.assert_allclose(scalar[droplet], 2 * surface.points[droplet, 1], atol=1e-6)
    np.testing.assert_allclose(curvature[droplet], 5.0, rtol=5e-3)
    assert np.isnan(scalar[~droplet]).all() and np.isnan(curvature[~droplet]).all()


def test_mean_curvature():
    """At the end of the long axis a of a spheroid (a, b, b) both principal curvatures are a / b²,
    on its equator they are 1 / b and b / a²; a circle of radius 0.2 has 5."""
    a, b = 1.4, 1.0
    drop = spline_ellipsoid((a, b, b), points=1000)
    found = drop.basis.evaluate(
        fields_of(Frame(0.0, {1: drop}), 1)["mean curvature"],
        [[np.pi / 2, np.pi / 2], [0.0, np.pi / 2]],
    )
    np.testing.assert_allclose(found, [a / b**2, 0.5 * (1 / b + b / a**2)], rtol=2e-3)
    plane = fields_of(Frame(0.0, {1: spline_circle(0.2, (0, 0), points=32)}), 1)
    np.testing.assert_allclose(plane["mean curvature"], 5.0, rtol=1e-4)


def test_curves_in_a_plane(tmp_path):
    """The circle (x - 1)² + (y - 2)² = 0.2² as rational curves, with a velocity (y, -x, 0) that is
    linear in the coordinates, and so exact."""
    drop = spline_circle(0.2, (1.0, 2.0), points=48)
    x, y = drop.coefficients
    frame = Frame(0.0, {1: drop}, {1: {"velocity": np.stack([y, -x])}})
    grid = pyvista.read(write_frame(tmp_path, 0, frame))
    assert set(grid.celltypes) == {pyvista.CellType.BEZIER_CURVE}
    curve = grid.extract_surface(nonlinear_subdivision=4, algorithm="dataset_surface")
    radius = np.linalg.norm(curve.points - [1.0, 2.0, 0.0], axis=1)
    np.testing.assert_allclose(radius, 0.2, rtol=1e-5)
    expected = curve.points[:, [1, 0, 2]] * [1, -1, 0]
    np.testing.assert_allclose(curve.point_data["velocity"], expected, atol=1e-6)


def test_frame_by_frame(tmp_path):
    """A run that is being written: each list of times replaces the one before, nothing is left
    behind, and the last one is as if all had been written at once."""
    turned = Rotation.from_euler("z", 20, degrees=True).as_matrix()
    solid = particle(s.transformed(turned, [0, 0, 0.1]) for s in sphere(0.2))
    for index, time in enumerate((0.0, 0.1, 0.25)):
        write_frame(tmp_path, index, Frame(time, {1: solid}))
        path = write_index(tmp_path, [0.0, 0.1, 0.25][: index + 1])
        assert len(pyvista.PVDReader(path).time_values) == index + 1
    assert pyvista.PVDReader(path).time_values == [0.0, 0.1, 0.25]
    assert len(list(tmp_path.iterdir())) == 4


def test_mistakes(tmp_path):
    drop = ball(0.5)
    with pytest.raises(CadbemError, match="at least one frame"):
        write_frames(tmp_path, [])
    wrong = Frame(0.0, {3: drop}, {3: {"speed": np.zeros(7)}})
    with pytest.raises(ShapeError, match=r"body 3: the field 'speed' .* \(7,\); give \(6, 12\)"):
        write_frame(tmp_path, 0, wrong)
