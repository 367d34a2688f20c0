"""Pictures and files of droplets against exact shapes."""

import numpy as np
import pytest
from test_post_pictures import SIZE, check, has_colour, pixels

from cadbem.errors import CadbemError, ShapeError
from cadbem.post.bodies.droplets import (
    draw_droplets,
    draw_outlines,
    knot_lines,
    knots,
    tessellated_droplet,
    write_droplets,
)
from cadbem.post.style.style import INK, PALETTE
from cadbem.spline.closed import ClosedBasis
from cadbem.spline.closed_shapes import spline_circle, spline_ellipsoid, spline_sphere

pyvista = pytest.importorskip("pyvista")


def test_tessellated_sphere():
    """Radius, normal and mean curvature 1, on the poles too.  Chords at angles h lie h² / 12
    inside, on average, along meridians and (h sin θ)² / 12 across: together 5/12 h² of the volume.
    """
    surface = tessellated_droplet(spline_sphere(points=200))
    np.testing.assert_allclose(np.linalg.norm(surface.points, axis=1), 1, atol=2e-6)
    np.testing.assert_allclose(surface.point_data["Normals"], surface.points, atol=1e-3)
    np.testing.assert_allclose(surface.point_data["value"], 1, atol=1e-3)
    shortfall = 1 - surface.volume / (4 * np.pi / 3)
    assert shortfall == pytest.approx(5 / 12 * np.radians(3) ** 2, rel=1e-2)


def test_curvature_at_the_end_of_an_axis():
    """c / a² and c / b² are the principal curvatures of an ellipsoid at the end of its axis c."""
    surface = tessellated_droplet(spline_ellipsoid((1.5, 0.8, 1.0), points=800))
    pole = surface.points[:, 2].argmax()
    expected = (1 / 1.5**2 + 1 / 0.8**2) / 2
    assert surface.point_data["value"][pole] == pytest.approx(expected, rel=1e-3)


def test_fields():
    """A position's coefficients give the position."""
    spline = spline_ellipsoid((1.5, 0.8, 1.0), centre=(1, 2, 3))
    surface = tessellated_droplet(spline, spline.coefficients[0])
    np.testing.assert_allclose(surface.point_data["value"], surface.points[:, 0], atol=1e-6)


@pytest.mark.parametrize(("degree", "rows"), [(3, 10), (4, 9)])
def test_knot_lines(degree, rows):
    """Knots of odd degrees lie on the collocation points, of even degrees between them."""
    basis = ClosedBasis(degree, (10, 20))
    shift = np.pi / 20 if degree % 2 else 0
    assert knots(basis)[0][0] == pytest.approx(shift or np.pi / 10)
    np.testing.assert_allclose(knots(basis)[1], shift + np.arange(20) * np.pi / 10)
    lines = knot_lines(spline_sphere(degree=degree))
    assert lines.n_lines == rows + 20
    np.testing.assert_allclose(np.linalg.norm(lines.points, axis=1), 1, atol=1e-3)


def test_picture(tmp_path):
    drops = [spline_sphere(), spline_ellipsoid((1, 0.6, 0.6), centre=(0, 0, 2))]
    path = draw_droplets(tmp_path / "a" / "drops.png", drops, points=True, size=SIZE)
    assert has_colour(check(path, 0.1, 0.8), INK)
    fields = [drop.coefficients[0] for drop in drops]
    path = draw_droplets(tmp_path / "x.png", drops, fields=fields, label="x", mesh=False, size=SIZE)
    check(path, 0.1, 0.8)


def test_outlines_are_round(tmp_path):
    """Circles of radius 1 and 2: as many pixels across as up, and twice as many.  The legend
    is in the right sixth of the picture."""
    series = {"t = 0": [spline_circle(points=24)], "t = 1": [spline_circle(2.0, points=24)]}
    image = pixels(draw_outlines(tmp_path / "a" / "outlines.png", series))
    extents = []
    for colour in PALETTE[:2]:
        wanted = [int(colour[i : i + 2], 16) for i in (1, 3, 5)]
        drawn = (image[:, : int(0.84 * image.shape[1])] == wanted).all(axis=2)
        extents.append([np.ptp(np.flatnonzero(drawn.any(axis=k))) for k in (0, 1)])
    np.testing.assert_allclose(np.divide(*np.transpose(extents)), 1, atol=0.02)
    np.testing.assert_allclose(np.divide(extents[1], extents[0]), 2, atol=0.04)


def test_file_is_exact(tmp_path):
    """Points that VTK computes on the cells are where the field, the position, says."""
    drops = [spline_ellipsoid((1.5, 0.8, 1), degree=3), spline_sphere(1.0, (0, 0, 3), points=72)]
    fields = {"place": [d.coefficients for d in drops], "x": [d.coefficients[0] for d in drops]}
    grid = pyvista.read(write_droplets(tmp_path / "drops.vtu", drops, fields))
    # 10 × 20 elements of odd degree, cut once more at the poles and the seam; 6 × 12 of even
    assert np.bincount(grid.cell_data["face"]).tolist() == [0, 11 * 21, 6 * 12]
    surface = grid.extract_surface(algorithm="dataset_surface", nonlinear_subdivision=2)
    np.testing.assert_allclose(surface["place"], surface.points, atol=1e-6)
    np.testing.assert_allclose(surface["x"], surface.points[:, 0], atol=1e-6)
    upper = surface.points[surface.points[:, 2] > 1.5] - np.array([0, 0, 3])
    np.testing.assert_allclose(np.linalg.norm(upper, axis=1), 1, atol=1e-4)


def test_wrong_shapes_and_names(tmp_path):
    with pytest.raises(ShapeError, match="2D cannot be shown.*draw_outlines"):
        draw_droplets(tmp_path / "a.png", [spline_circle()])
    with pytest.raises(ShapeError, match="2D cannot be shown"):
        write_droplets(tmp_path / "a.vtu", [spline_circle()])
    with pytest.raises(ShapeError, match="3D cannot be shown.*draw_droplets"):
        draw_outlines(tmp_path / "a.png", {"": [spline_sphere()]})
    with pytest.raises(CadbemError, match=r"\.vtu"):
        write_droplets(tmp_path / "a.vtk", [spline_sphere(points=72)])
