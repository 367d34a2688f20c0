"""Pictures of solved flows: samples against flows known in closed form."""

from types import SimpleNamespace

import numpy as np
import pytest
from PIL import Image
from post_stand_ins import PositionField, box, pipe, rectangular_channel

from cadbem.boundary import Boundary, Patch
from cadbem.errors import ShapeError
from cadbem.post import draw_flow, draw_traction
from cadbem.post.fields.sampling import PORTION, SHOWN, in_portions, sample_flow
from cadbem.problems.conditions import Inflow, NoSlip, Pressure
from cadbem.spline.shapes import sphere

pytest.importorskip("pyvista")
SIZE = (640, 480)


class AffineFlow:
    """u = (1 + y, 0[, 0]) and p = 3 - x throughout a boundary: not a Stokes flow with walls, but
    linear, so that any cells interpolate it exactly."""

    def __init__(self, boundary):
        self.space = SimpleNamespace(boundary=boundary)
        self.velocity = PositionField(boundary, self.velocity_at)

    def velocity_at(self, points, quadrature=None):
        return np.stack([1 + points[1], *np.zeros_like(points[1:])])

    def pressure_at(self, points, quadrature=None):
        return 3 - points[0]

    def surface_pressure(self, patch, *parameters):
        return self.pressure_at(self.space.boundary.patches[patch].surface.evaluate(*parameters))


def measures(sample):
    """Volumes or areas of cells."""
    corners = sample.points[:, sample.cells]
    edges = np.moveaxis(corners[:, 1:] - corners[:, :1], -1, 0)
    return abs(np.linalg.det(edges)) / (2 if len(sample.points) == 2 else 6)


@pytest.mark.parametrize("boundary", [box(), rectangular_channel()], ids=["3D", "2D"])
def test_cells_fill_the_channel(boundary):
    """They cover the volume 2 of the channel once, as no cell is outside, and its flat walls
    exactly; values are those of the flow, on the boundary up to the inset of a thousandth."""
    sample = sample_flow(AffineFlow(boundary), 400)
    assert measures(sample).sum() == pytest.approx(2.0, rel=1e-3)
    points = sample.points
    assert (points.min(axis=1) == 0).all() and points[0].max() == 2 and points[1].max() == 1
    np.testing.assert_allclose(sample.velocity[0], 1 + points[1], atol=2e-3)
    np.testing.assert_allclose(sample.pressure, 3 - points[0], atol=3e-3)


def test_cells_leave_out_what_is_not_fluid():
    """A shell between radii 1 and 0.5, 4π/3 (1 - 1/8) large: cells of flat faces on its outer
    sphere lack a little, those on the inner one have a little more."""
    outer = [Patch(s.swapped(), "walls") for s in sphere()]
    inner = [Patch(s, "ball") for s in sphere(0.5)]
    shell = Boundary((*outer, *inner))
    assert shell.volume() == pytest.approx(4 * np.pi / 3 * 7 / 8, rel=1e-6)
    sample = sample_flow(AffineFlow(shell), 2000)
    assert measures(sample).sum() == pytest.approx(shell.volume(), rel=0.03)
    middles = sample.points[:, sample.cells].mean(axis=1)
    assert np.linalg.norm(middles, axis=0).min() > 0.5


def test_portions_join():
    """Twice the coordinates of more points than one portion holds, and of none."""
    points = np.arange(3.0 * (2 * PORTION + 5)).reshape(3, -1)
    sizes = []

    def doubled(part, quadrature):
        sizes.append(part.shape[1])
        return 2 * part

    np.testing.assert_array_equal(in_portions(doubled, points, SHOWN, ""), 2 * points)
    assert sizes == [PORTION, PORTION, 5]
    assert in_portions(doubled, points[:, :0], SHOWN, "").shape == (3, 0)


def test_grid_carries_the_flow():
    """The integral of 1 + y over a cross-section of a pipe of radius 1 is its area π."""
    grid = sample_flow(AffineFlow(pipe()), 3000).grid()
    cut = grid.slice(normal=(0, 0, 1), origin=(0, 0, 1)).compute_cell_sizes()
    rate = cut.point_data_to_cell_data().cell_data["velocity"][:, 0] @ cut.cell_data["Area"]
    assert rate == pytest.approx(np.pi, rel=0.02)


def test_pictures(tmp_path):
    """In space of the size asked for; in a plane colours go from purple to yellow."""
    path = draw_flow(AffineFlow(box()), tmp_path / "a" / "f.png", points=300, size=SIZE)
    image = np.asarray(Image.open(path).convert("RGB")).astype(int)
    assert image.shape == (SIZE[1], SIZE[0], 3)
    assert 0.15 < (image != 255).any(axis=2).mean() < 0.8
    path = draw_flow(AffineFlow(rectangular_channel()), tmp_path / "p.png", points=300)
    image = np.asarray(Image.open(path).convert("RGB")).astype(int)
    for colour in ((253, 231, 37), (68, 1, 84)):  # ends of the colour map
        assert (abs(image - colour) < 12).all(axis=2).sum() > 100


def test_pressure_on_walls(tmp_path, monkeypatch):
    """The traction f = -p n + τ on a wall has the pressure p and the shear stress |τ|."""
    from cadbem.post.channel import view_walls

    found = {}

    def kept(quantity, values):
        found[quantity] = np.asarray(values)
        return 0.0, 1.0

    monkeypatch.setattr(view_walls, "_limits", kept)
    boundary = box()
    solution = SimpleNamespace(
        space=SimpleNamespace(boundary=boundary),
        traction=PositionField(boundary, lambda x: np.stack([0 * x[0] + 0.5, x[1] * 0, 2 + x[0]])),
        problem=SimpleNamespace(conditions={"inlet": Inflow(1.0), "outlet": Pressure()}),
    )
    solution.problem.conditions["walls"] = NoSlip()
    draw_traction(solution, tmp_path / "w.png", size=SIZE)
    # on z = 0, n = +z: p = -(2 + x); on z = 1 it is 2 + x; on y = 0 and 1 it vanishes
    assert (found["pressure"].min(), found["pressure"].max()) == pytest.approx((-4.0, 4.0))
    assert found["wall shear stress"].min() == pytest.approx(0.5)


def test_flow_around_bodies_is_refused(tmp_path):
    ball = Boundary(tuple(Patch(s, "ball") for s in sphere()))
    assert ball.volume() < 0
    with pytest.raises(ShapeError, match="draw_around"):
        draw_flow(AffineFlow(ball), tmp_path / "f.png")
