"""Pictures: the size asked for, something on them, nothing cut off, faces that can be told."""

from types import SimpleNamespace

import numpy as np
import pytest
from post_stand_ins import FlowInBox, PositionField, box, pipe, space, tetrahedra_in_box

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
from cadbem.post.layout import arrangement, back_view, corner_view, plan_view
from cadbem.post.style import PALETTE, colours_of, quantity_label, round_values
from cadbem.post.view_boundary import visible_spots
from cadbem.post.view_flow import inflow_seeds
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


def test_every_face_of_a_box_is_seen():
    """The front view shows outlet, front and top, the back view the three others."""
    surface = tessellated(box())
    points = surface.points.T
    front = visible_spots(surface, corner_view(points))
    back = visible_spots(surface, back_view(points))
    assert (set(front), set(back)) == ({2, 3, 6}, {1, 4, 5})
    np.testing.assert_allclose(front[6], [1, 0.5, 1], atol=0.2)


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
    assert set(visible_spots(surface, view)) == {3}


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
