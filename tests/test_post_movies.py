"""Pictures, movies and files of bodies in motion against what is known of their places."""

import numpy as np
import pytest
from PIL import Image
from post_stand_ins import box, frames_along, pipe, rectangular_channel
from scipy.ndimage import label

from cadbem.boundary import Boundary, Patch
from cadbem.errors import CadbemError, ShapeError
from cadbem.post import (
    Frame,
    draw_movie,
    draw_scene,
    draw_trajectories,
    filmstrip,
)
from cadbem.post.bodies.bodies import body_colour, body_surface, legend_of
from cadbem.post.fields.frames import spread_points, time_labels
from cadbem.post.files.palette import EXACT, Palette
from cadbem.post.style.style import OPENING, PALETTE
from cadbem.spline.closed_shapes import spline_circle, spline_sphere
from cadbem.spline.outlines import circle, rectangle
from cadbem.spline.shapes import sphere

pytest.importorskip("pyvista")
PLACES = (None, 0.4, 0.8, 1.4)  # steps of 0.4 and 0.6
SIZE = (300, 400)


def droplet(x):
    return spline_circle(0.2, (x, 0.5), points=16)


def ball(x):
    return spline_sphere(0.2, (x, 0.5, 0.5), points=72)


def particle(patches):
    return Boundary(tuple(map(Patch, patches)))


def pictures(path):
    """All pictures of a file, (count, height, width, 3)."""
    image = Image.open(path)
    found = []
    for k in range(getattr(image, "n_frames", 1)):
        image.seek(k)
        found.append(np.asarray(image.convert("RGB")).astype(int))
    return np.stack(found)


def of_colour(image, colour):
    return (image == list(bytes.fromhex(colour[1:]))).all(axis=-1)


def columns(masks):
    """Mean column of what is drawn, for each picture."""
    return [np.nonzero(mask)[1].mean() for mask in masks]


def test_plane_movie(tmp_path):
    """The droplet's pixels move by steps as 0.4 to 0.6; all else but the time stays where it is.

    In the first frame there is no droplet, and the legend's patch alone has its colour.
    """
    frames = frames_along(PLACES, droplet)
    path = draw_movie(tmp_path / "a" / "m.gif", rectangular_channel(), frames, size=(600, 450))
    images = pictures(path)
    assert len(images) == 4 and images.shape[2] == 600
    blue = of_colour(images, PALETTE[0])
    assert 50 < blue[0].sum() < 1000
    bodies = blue[1:] & ~blue[0]
    assert bodies.sum(axis=(1, 2)) == pytest.approx(bodies[0].sum(), rel=0.01)
    first, second, third = columns(bodies)
    assert (third - second) / (second - first) == pytest.approx(1.5, abs=0.02)
    assert Image.open(path).info["loop"] == 0


def test_movie_in_space(tmp_path):
    """Seen along z in the upper panel, steps are again as 0.4 to 0.6, from an empty channel."""
    frames = frames_along(PLACES, ball)
    images = pictures(draw_movie(tmp_path / "m.gif", box(), frames, size=SIZE))
    assert images.shape == (4, SIZE[1], SIZE[0], 3)
    assert (images[:, -1, -1] == 255).all()  # the background is pure white
    upper = slice(30, 170)
    changed = (np.abs(images[1:, upper] - images[0, upper]) > 30).any(axis=-1)
    first, second, third = columns(changed)
    assert (third - second) / (second - first) == pytest.approx(1.5, abs=0.03)
    assert len(np.unique(images[1].reshape(-1, 3), axis=0)) > 50


def test_scene(tmp_path):
    """A shaded droplet, a chequered particle, tinted openings, the size asked for."""
    shapes = {2: ball(0.5), 5: particle(sphere(0.2, (1.3, 0.5, 0.5)))}
    (image,) = pictures(draw_scene(tmp_path / "s.png", box(), shapes, size=SIZE))
    assert image.shape == (SIZE[1], SIZE[0], 3)
    assert of_colour(image, PALETTE[2]).any() and of_colour(image, PALETTE[5]).any()
    (empty,) = pictures(draw_scene(tmp_path / "e.png", box(), {}, size=SIZE))
    assert 0.01 < (image != empty).any(axis=-1).mean() < 0.3
    (alone,) = pictures(draw_scene(tmp_path / "a.png", None, shapes, size=SIZE))
    assert (alone != 255).any(axis=-1).mean() > 0.1


def test_plane_scene(tmp_path):
    """A round particle is half dark and half pale: sectors over halves of its four quarters."""
    shapes = {0: particle(circle(0.3, (1.0, 0.5)))}
    (image,) = pictures(draw_scene(tmp_path / "s.png", rectangular_channel(), shapes))
    assert of_colour(image, OPENING).any()
    spots, _ = label(of_colour(image, PALETTE[0]))
    areas = np.sort(np.bincount(spots.ravel())[1:])[-5:]  # four sectors and the legend's patch
    radius = 0.3 * np.ptp(np.nonzero(of_colour(image, OPENING))[1]) / 2.0
    assert areas[-4:].sum() == pytest.approx(0.5 * np.pi * radius**2, rel=0.05)


def test_sectors_of_a_rectangle(tmp_path):
    """Sides in any order: they are joined end to end, so that the square is filled."""
    shapes = {0: particle(patch.reversed() for patch in rectangle((0.7, 0.2), (1.3, 0.8)))}
    (image,) = pictures(draw_scene(tmp_path / "s.png", None, shapes, size=(400, 400)))
    dark = of_colour(image, PALETTE[0])[:300]
    rows, across = np.nonzero(dark)
    box_area = (np.ptp(rows) + 1) * (np.ptp(across) + 1)
    assert dark.sum() / box_area == pytest.approx(0.5, abs=0.05)


def test_filmstrip(tmp_path):
    """Frames 0, 2, 3 and 5 of six (evenly spread, rounded): droplets in four panels, and the
    legend."""
    frames = frames_along(np.linspace(0.3, 1.7, 6), droplet)
    path = filmstrip(tmp_path / "f.png", rectangular_channel(), frames, 4, size=(900, 700))
    (image,) = pictures(path)
    assert label(of_colour(image, PALETTE[0]))[1] == 5
    (image,) = pictures(filmstrip(tmp_path / "g.png", box(), frames_along((0.5, 1), ball)))
    assert image.shape == (1100, 1800, 3)


def test_trajectories(tmp_path):
    """A path of length 1.5 is as long, in pixels, as the channel's 2 to the same scale."""
    tracks = {0: np.array([[0.25, 1.75], [0.3, 0.3]]), "b": np.array([[0.5, 1.0], [0.7, 0.7]])}
    (image,) = pictures(draw_trajectories(tmp_path / "t.png", rectangular_channel(), tracks))
    plan = image[: int(0.8 * len(image))]
    across = np.nonzero(of_colour(plan, PALETTE[0]))[1]
    ports = np.nonzero(of_colour(plan, OPENING))[1]
    assert np.ptp(across) / np.ptp(ports) == pytest.approx(0.75, abs=0.02)
    assert of_colour(plan, PALETTE[1]).any()


def test_trajectories_in_space(tmp_path):
    """On the plan of a box 2 long and 1 wide as well; z does not matter."""
    tracks = {3: np.array([[0.25, 1.75], [0.5, 0.5], [0.1, 0.9]])}
    (image,) = pictures(draw_trajectories(tmp_path / "t.png", box(), tracks))
    plan = image[: int(0.8 * len(image))]
    across = np.nonzero(of_colour(plan, PALETTE[3]))[1]
    ports = np.nonzero(of_colour(plan, OPENING))[1]
    assert np.ptp(across) / np.ptp(ports) == pytest.approx(0.75, abs=0.02)


def test_surfaces():
    """Half of a particle's cells are dark; its corners and normals are those of the sphere."""
    surface = body_surface(1, particle(sphere()))
    dark = of_colour(np.asarray(surface.cell_data["colour"]), PALETTE[1])
    assert dark.mean() == 0.5
    np.testing.assert_allclose(surface.point_data["Normals"], surface.points, atol=1e-6)
    refined = body_surface(1, Boundary(particle(sphere()).patches).refined(6))
    assert of_colour(np.asarray(refined.cell_data["colour"]), PALETTE[1]).mean() == 0.5


def test_extent():
    """A pipe of radius 1 and length 2, whose control points are corners of squares outside."""
    np.testing.assert_allclose(np.ptp(spread_points(pipe()), axis=1), 2, atol=1e-12)


def test_looks():
    """Colours depend on the number alone; the longest time has three digits; crowds are counted."""
    assert len({body_colour(number) for number in range(60)}) == 60
    frames = [Frame(time, {}) for time in (0.0, 0.5, 12.3)]
    assert time_labels(frames) == ["t = 0.0", "t = 0.5", "t = 12.3"]
    neighbours = {number: ball(0.5) for number in range(9)} | {9: particle(sphere())}
    assert list(legend_of([Frame(0.0, neighbours)])) == ["9 droplets", "1 particle"]
    assert legend_of([Frame(0.0, {3: ball(0.5)})]) == {"droplet 3": PALETTE[3]}


def test_palette_keeps_frequent_colours():
    """Shades of grey, each more frequent than the next: the first 48 are exact, as their values
    differ by 5 and no two fall into one box of 4; others are met within half a box and a shade."""
    shades = np.repeat(np.arange(0, 255, 5, dtype=np.uint8), np.arange(51, 0, -1))
    image = Image.fromarray(np.repeat(shades[None, :, None], 3, axis=2))
    result = np.asarray(Palette.of([image]).applied(image).convert("RGB"))[0, :, 0]
    exact = shades < 5 * EXACT
    np.testing.assert_array_equal(result[exact], shades[exact])
    assert np.abs(result.astype(int) - shades).max() <= 4


def test_palette_keeps_a_scale():
    """A rare scale of 64 shades of red survives beside 4096 more frequent greens and blues."""
    reds = np.stack([np.arange(0, 256, 4), *np.zeros((2, 64))], axis=1).astype(np.uint8)
    others = np.indices((64, 64)).reshape(2, -1).T * 4
    neighbours = np.repeat(np.hstack([0 * others[:, :1], others]), 3, axis=0).astype(np.uint8)
    image = Image.fromarray(np.concatenate([reds, neighbours])[None])
    result = np.asarray(Palette.of([image], reds).applied(image).convert("RGB"))[0, :64]
    assert np.abs(result.astype(int) - reds).max() <= 4


def test_mistakes(tmp_path):
    flat, solid = Frame(0.0, {1: droplet(0.5)}), Frame(2.0, {3: ball(0.5)})
    with pytest.raises(CadbemError, match="at least one frame"):
        draw_movie(tmp_path / "m.gif", box(), [])
    with pytest.raises(CadbemError, match="a channel or a body"):
        draw_scene(tmp_path / "s.png", None, {})
    with pytest.raises(ShapeError, match="body 1 at t = 0 is in 2D, body 3 at t = 2 in 3D"):
        filmstrip(tmp_path / "f.png", None, [flat, solid])
    with pytest.raises(ShapeError, match="body 1 at t = 0 is in 2D, the channel in 3D"):
        draw_scene(tmp_path / "s.png", box(), flat.shapes)
    with pytest.raises(CadbemError, match=r"m\.avi: .* ends in \.mp4 or \.gif"):
        draw_movie(tmp_path / "m.avi", box(), [solid])
    with pytest.raises(CadbemError, match="at least one path"):
        draw_trajectories(tmp_path / "t.png", box(), {})
    with pytest.raises(ShapeError, match="all be in 2D or all in 3D"):
        draw_trajectories(tmp_path / "t.png", box(), {1: np.zeros((2, 5))})
