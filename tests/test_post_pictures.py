"""Pictures: the size asked for, something on them, nothing cut off, faces that can be told."""

from types import SimpleNamespace

import numpy as np
import pytest
from post_stand_ins import (
    FlowInBox,
    PositionField,
    box,
    pipe,
    plate,
    rectangular_channel,
    space,
    tetrahedra_in_box,
)

from cadbem.boundary import Boundary, Patch
from cadbem.errors import SelectionError
from cadbem.post import (
    draw_boundary,
    draw_collocation,
    draw_slices,
    draw_streamlines,
    draw_traction,
    tessellated,
    volume_grid,
)
from cadbem.post.channel.view_boundary import choose_views
from cadbem.post.channel.view_flow import inflow_seeds
from cadbem.post.fields.cells import edge_lines, face_edges
from cadbem.post.scene.face_labels import look, place_labels, roomiest
from cadbem.post.style.layout import arrangement, back_view, corner_view, plan_view
from cadbem.post.style.style import PALETTE, colours_of, quantity_label, round_values
from cadbem.problems.conditions import Inflow, NoSlip, Pressure

pyvista = pytest.importorskip("pyvista")
SIZE = (640, 480)


def pixels(path):
    """Colours (height, width, 3) of a picture."""
    image = pyvista.read(path)
    width, height, _ = image.dimensions
    return np.asarray(image.active_scalars)[:, :3].reshape(height, width, 3)


def check(path, least, most):
    """Size as asked for, background at the rim, and how much of the picture is drawn on."""
    image = pixels(path)
    assert image.shape == (SIZE[1], SIZE[0], 3)
    drawn = (image != 255).any(axis=2)
    assert not drawn[:2].any() and not drawn[-2:].any()
    assert not drawn[:, :2].any() and not drawn[:, -2:].any()
    assert least < drawn.mean() < most
    return image


def has_colour(image, colour):
    wanted = [int(colour[i : i + 2], 16) for i in (1, 3, 5)]
    return (image == wanted).all(axis=2).any()


@pytest.fixture(scope="module")
def grid():
    return volume_grid(*tetrahedra_in_box(), FlowInBox())


def test_boundary(tmp_path):
    image = check(draw_boundary(box(), tmp_path / "a" / "box.png", size=SIZE), 0.2, 0.8)
    assert has_colour(image, PALETTE[0]) and has_colour(image, PALETTE[1])  # legend of the ports


def test_boundary_with_defects(tmp_path):
    """A face that has no patch is drawn by its outline in red, and named in the legend."""
    boundary = box()
    outline = np.array([[0, 0, 0], [2, 0, 0], [2, 1, 0], [0, 1, 0], [0, 0, 0.0]]).T
    broken = Boundary(boundary.patches[:-1], unit="mm")
    path = draw_boundary(broken, tmp_path / "box.png", defects={7: [outline]}, size=SIZE)
    assert has_colour(check(path, 0.2, 0.8), "#d62728")


def visible_faces(surface, view):
    return look(surface, view, surface.points.T, SIZE)


def test_every_face_of_a_box_is_seen():
    """The front view shows outlet, front and top, the back view the three others.  The roomiest
    place of the top, a rectangle seen obliquely, is its middle, where the label is."""
    surface = tessellated(box())
    points = surface.points.T
    view = corner_view(points)
    front, back = visible_faces(surface, view), visible_faces(surface, back_view(points))
    assert (set(roomiest(front)), set(roomiest(back))) == ({2, 3, 6}, {1, 4, 5})
    spots = roomiest(front)
    place = front.position(spots[6][0])
    x, y, z = place - (place[2] - 1.0) / view.toward[2] * view.toward
    np.testing.assert_allclose([x, y, z], [1.0, 0.5, 1.0], atol=0.05)
    assert place_labels(front, spots, {2: "2", 3: "3", 6: "6"}, 20)[6] == spots[6][0]


def test_small_faces_have_their_numbers_beside_them():
    """A row of six squares across a wide one: no label covers another, nor any of the squares."""
    squares = [plate((0.3 * k, 0, 0), (0.1, 0, 0), (0, 0.1, 0), "", k + 1) for k in range(6)]
    surface = tessellated(Boundary((*squares, plate((0, 0.2, 0), (1.6, 0, 0), (0, 1, 0), "", 9))))
    seen = look(surface, plan_view(surface.points.T), surface.points.T, (320, 240))
    spots = roomiest(seen)
    letter = 30
    assert all(room < 0.6 * letter for face, (_, room) in spots.items() if face != 9)
    places = place_labels(seen, spots, {face: str(face) for face in spots}, letter)
    assert sorted(places) == [1, 2, 3, 4, 5, 6, 9]
    boxes = np.array(list(places.values()))
    gaps = np.abs(boxes[:, None] - boxes)[~np.eye(7, dtype=bool)]
    assert ((gaps[:, 0] > 0.5 * letter) | (gaps[:, 1] > letter)).all()
    for column, row in boxes:
        assert seen.faces[int(row), int(column)] in (0, 9)


def test_hidden_faces_get_no_number():
    """From the front, along +y, a box shows its face 3 only, and hides a smaller one behind."""
    near = box(length=4.0)
    behind = [
        Patch(p.surface.transformed(0.5 * np.eye(3), [1.0, 3.0, 0.0]), "far", 10 + p.face)
        for p in box().patches
    ]
    surface = tessellated(Boundary((*near.patches, *behind)))
    view = plan_view(surface.points.T, hidden=1)
    np.testing.assert_allclose(view.toward, [0, -1, 0])
    assert set(roomiest(visible_faces(surface, view))) == {3}


def test_faces_inside_get_a_view_of_their_own():
    """A small box in the middle of a large one is seen from nowhere."""
    inner = [
        Patch(p.surface.transformed(0.3 * np.eye(3), [0.7, 0.35, 0.35]), "", 10 + p.face)
        for p in box().patches
    ]
    surface = tessellated(Boundary((*box().patches, *inner)))
    views, hidden = choose_views(surface, surface.points.T)
    assert (len(views), hidden) == (2, [11, 12, 13, 14, 15, 16])


def test_plane_boundary(tmp_path):
    """Edges in the colours of their names."""
    path = draw_boundary(rectangular_channel(), tmp_path / "plane.png", size=SIZE)
    image = pixels(path)
    assert image.shape[1] == SIZE[0]
    assert has_colour(image, PALETTE[0]) and has_colour(image, PALETTE[1])


def test_face_edges():
    """A box with a side cut in two has 28 edges of 7 patches; the cut, of which two of them are,
    is no edge of a face."""
    cut = box().named(rest="walls").patches
    surface = cut[0].surface
    halves = [Patch(surface.restricted((a, a + 0.5), (0, 1)), "walls", 1) for a in (0, 0.5)]
    boundary = Boundary((*halves, *cut[1:]))
    assert edge_lines(boundary).n_cells == 28
    assert face_edges(boundary).n_cells == 26


def test_collocation(tmp_path):
    check(draw_collocation(space(pipe()), tmp_path / "pipe.png", size=SIZE), 0.2, 0.8)


def test_traction(tmp_path):
    boundary = box()
    field = PositionField(boundary, lambda x: np.stack([0 * x[0] + 1, x[0], 0 * x[0]]))
    conditions = {"inlet": Inflow(mean_velocity=1.0), "outlet": Pressure(), "walls": NoSlip()}
    solution = SimpleNamespace(
        space=SimpleNamespace(boundary=boundary),
        traction=field,
        problem=SimpleNamespace(conditions=conditions),
    )
    check(draw_traction(solution, tmp_path / "walls.png", size=SIZE), 0.2, 0.8)
    del conditions["walls"]
    with pytest.raises(SelectionError, match="NoSlip"):
        draw_traction(solution, tmp_path / "walls.png", size=SIZE)


def test_slices(tmp_path, grid):
    check(draw_slices(grid, box(), tmp_path / "slices.png", size=SIZE), 0.2, 0.8)


def test_streamlines(tmp_path, grid):
    check(draw_streamlines(grid, box(), tmp_path / "lines.png", size=SIZE), 0.2, 0.8)


def test_seeds_lie_where_fluid_enters(grid):
    """Fluid enters at x = 0 alone: 25 seeds on a 1 × 1 opening are a lattice of 5 × 5."""
    seeds = inflow_seeds(grid, box(), 25)
    assert len(seeds) == 25
    np.testing.assert_allclose(seeds[:, 0], 2e-3 * 2.0)
    np.testing.assert_allclose(np.unique(np.round(seeds[:, 1], 9)), [0.1, 0.3, 0.5, 0.7, 0.9])


def test_views_are_right_handed_and_fit():
    points = tessellated(box()).points.T
    for view in (plan_view(points), corner_view(points), back_view(points)):
        frame = np.stack([view.right, view.up, view.toward])
        np.testing.assert_allclose(frame @ frame.T, np.eye(3), atol=1e-12)
        assert np.linalg.det(frame) == pytest.approx(1)
    assert plan_view(points).aspect(points) == pytest.approx(2.0)


def test_long_channels_are_stacked():
    assert arrangement(2, 4.0, (1000, 500)) == (2, 1)
    assert arrangement(2, 0.5, (1000, 500)) == (1, 2)


def test_colours_tell_names_apart():
    names = ["", "walls", *[f"inlet_{i}" for i in range(20)]]
    colours = colours_of(names)
    assert list(sorted(colours)) == sorted(names)
    assert len(set(colours.values())) == len(names)


def test_labels():
    np.testing.assert_allclose(round_values(0.0, 4.12), [0, 1, 2, 3, 4])
    np.testing.assert_allclose(round_values(-0.03, 0.021), [-0.03, -0.02, -0.01, 0, 0.01, 0.02])
    assert round_values(2.0, 2.0).tolist() == [2.0]
    assert quantity_label("speed", "mm") == "speed (mm / time)"
    assert quantity_label("pressure", "") == "pressure (dimensionless)"
