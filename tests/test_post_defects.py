"""Defective faces of CAD files: which edges are at fault, and that they alone are drawn in red."""

from math import pi, sqrt

import gmsh
import numpy as np
import pytest
from post_stand_ins import box

from cadbem.boundary import Boundary
from cadbem.cad import write_cad
from cadbem.cad.layout.face_patches import face_patches
from cadbem.cad.layout.region import region_of
from cadbem.cad.layout.trimming_curves import line
from cadbem.cad.picture import defect_lines, skins, triangulated
from cadbem.cad.survey import survey_cad
from cadbem.errors import CadError
from cadbem.post import draw_boundary

pyvista = pytest.importorskip("pyvista")
SIZE = (640, 480)
occ = gmsh.model.occ


@pytest.fixture
def folder(tmp_path):
    """A fresh gmsh model, and a folder for files."""
    gmsh.initialize(interruptible=False, readConfigFiles=False)
    gmsh.option.setNumber("General.Terminal", 0)
    yield tmp_path
    gmsh.finalize()


def open_box(path):
    """A box 3 x 2 x 1 without its face at x = 3."""
    occ.remove([(3, occ.addBox(0, 0, 0, 3, 2, 1))])
    ends = [face for face in occ.getEntities(2) if occ.getCenterOfMass(*face)[0] > 2.9]
    assert len(ends) == 1
    occ.remove(ends)
    occ.synchronize()
    write_cad(path, {})
    return path


def slanted_cylinder(path):
    """x² + y² < 1 between z = 0 and z = 2 + x/2."""
    cylinder = occ.addCylinder(0, 0, 0, 0, 0, 4, 1)
    knife = occ.addBox(-3, -3, 0, 6, 6, 6)
    occ.rotate([(3, knife)], 0, 0, 0, 0, 1, 0, -np.arctan(0.5))
    occ.translate([(3, knife)], 0, 0, 2)
    occ.cut([(3, cylinder)], [(3, knife)])
    occ.synchronize()
    write_cad(path, {})
    return path


def red_share(path):
    """Share of the pixels above the legend, a strip of 12 %, that are red, in light or shade."""
    image = pyvista.read(path)
    width, height, _ = image.dimensions
    pixels = np.asarray(image.active_scalars)[:, :3].reshape(height, width, 3).astype(float)
    red, green, blue = np.moveaxis(pixels[height // 8 :], -1, 0)  # rows count from below
    return ((red > 80) & (green < 0.3 * red) & (blue < 0.3 * red)).mean()


def areas(triangles):
    first, second = np.diff(triangles, axis=1).transpose(1, 0, 2)
    return 0.5 * np.linalg.norm(np.cross(first, second), axis=1)


def test_open_edges_of_a_box(folder):
    """The missing face has edges of lengths 2, 1, 2 and 1 in the plane x = 3, one on each of its
    neighbours; the five faces that are there have patches of area 2 (6 + 3) + 2 = 20."""
    survey = survey_cad(open_box(folder / "box.step"))
    lines = defect_lines(survey)
    assert all(len(curves) == 1 for curves in lines.values())
    points = [curve for curves in lines.values() for curve in curves]
    assert sorted(np.linalg.norm(np.ptp(p, axis=1)) for p in points) == pytest.approx([1, 1, 2, 2])
    np.testing.assert_allclose([x for p in points for x in p[0]], 3, atol=1e-12)
    assert survey.boundary.area() == pytest.approx(20)
    assert len(survey.boundary.patches) == 5 and survey.refused == {} and skins(survey) == {}
    assert len(survey.problems) == 1 and len(survey.complaints()) == 4


def test_only_the_defective_box_is_red(folder):
    """Four of the five faces of the open box are red, and nothing of a closed one; one wall of the
    box with ports is drawn in red if it is said to be defective."""
    survey = survey_cad(open_box(folder / "box.step"))
    path = folder / "box.png"
    shares = []
    for boundary, lines in [
        (survey.boundary, defect_lines(survey)),
        (survey.boundary, {}),
        (box(), {}),
        (box(), {6: []}),
    ]:
        draw_boundary(boundary, path, defects=lines, size=SIZE)
        shares.append(red_share(path))
    assert shares[0] > 0.2
    assert shares[1:3] == [0, 0]
    assert 0.02 < shares[3] < 0.2


def planes_only(face, tolerance):
    """As if there were no way to lay patches on curved faces."""
    if face.surface.kind != "plane":
        raise CadError("it is curved")
    return face_patches(face, tolerance)


def test_skin_of_a_face_without_patches(folder, monkeypatch):
    """The slanted cylinder's side has a mean height of 2 and an area of 4 π; the normals of its
    skin point to the axis. The ends are a circle and an ellipse of half axes 1 and sqrt(1.25)."""
    monkeypatch.setattr("cadbem.cad.body.model.face_patches", planes_only)
    survey = survey_cad(slanted_cylinder(folder / "slanted.step"))
    (side,) = survey.refused
    found = skins(survey)
    assert list(found) == [side]
    assert areas(found[side]).sum() == pytest.approx(4 * pi, rel=5e-3)
    np.testing.assert_allclose(np.hypot(found[side][..., 0], found[side][..., 1]), 1)
    first, second = np.diff(found[side], axis=1).transpose(1, 0, 2)
    inward = (np.cross(first, second)[:, :2] * found[side].mean(axis=1)[:, :2]).sum(axis=1)
    assert (inward < 0).all()
    assert survey.boundary.area() == pytest.approx(pi * (1 + sqrt(1.25)))
    lines = defect_lines(survey)
    assert list(lines) == [side]
    heights = np.concatenate(lines[side], axis=1)
    z, top = heights[2], 2 + heights[0] / 2
    assert len(lines[side]) == 4  # circle, ellipse, and the seam twice
    ends = np.minimum(abs(z), abs(z - top)) < 1e-9
    assert ends.any() and (np.abs(heights[:2, ~ends].T - [1, 0]) < 1e-9).all()
    path = draw_boundary(
        survey.boundary, folder / "slanted.png", defects=lines, skins=found, size=SIZE
    )
    lines_only = draw_boundary(survey.boundary, folder / "lines.png", defects=lines, size=SIZE)
    assert red_share(path) > 0.1 > red_share(lines_only) > 0.002


def test_nothing_but_edges(folder):
    """A file none of whose faces has patches or a skin is drawn by its edges."""
    outline = np.array([[0, 0, 0], [2, 0, 0], [2, 1, 0], [0, 1, 1], [0, 0, 0.0]]).T
    path = draw_boundary(Boundary(()), folder / "a.png", defects={1: [outline]}, size=SIZE)
    assert 0.002 < red_share(path) < 0.05


def test_triangles_leave_holes_out():
    """A square of side 4 with a hole of side 1 off its middle: area 15; the triangles turn
    counter-clockwise, and straight borders are met exactly."""
    loops = []
    for corner, side in (((0, 0), 4), ((0.5, 2), 1)):
        corners = np.array(corner) + side * np.array([[0, 0], [1, 0], [1, 1], [0, 1]])
        loops.append(
            tuple(line(a, b) for a, b in zip(corners, np.roll(corners, -1, 0), strict=True))
        )
    region = region_of(loops)
    assert region is not None
    points, cells = triangulated(region)
    first, second = np.diff(points[:, cells], axis=2).transpose(2, 0, 1)
    signed = 0.5 * (first[0] * second[1] - first[1] * second[0])
    assert (signed > 0).all() and signed.sum() == pytest.approx(15, rel=1e-12)
    middles = np.abs(points[:, cells].mean(axis=2).T - [1, 2.5]).max(axis=1)  # of the hole
    assert (middles > 0.5).all()
