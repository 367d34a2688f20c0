"""Bodies in the colours of fields, and movies as MP4, against known places and values."""

import sys
from types import SimpleNamespace

import numpy as np
import pytest
from PIL import Image
from post_stand_ins import box, frames_along, rectangular_channel

from cadbem.boundary import Boundary, Patch
from cadbem.errors import CadbemError
from cadbem.post import Frame, draw_movie, draw_scene, filmstrip
from cadbem.post.bodies.colouring import Colouring
from cadbem.post.fields.frames import extent_of, time_labels
from cadbem.post.files.encode import Shots, encoder
from cadbem.post.style.style import quantity_label
from cadbem.spline.closed_shapes import spline_circle, spline_ellipse, spline_ellipsoid
from cadbem.spline.outlines import circle
from cadbem.spline.shapes import sphere

pytest.importorskip("pyvista")
ffmpeg = pytest.importorskip("imageio_ffmpeg")
WRITTEN = "write (16, 16, 3) (16, 16)"
UNITS = SimpleNamespace(length="mm", time="s", pressure="Pa")


def spheroid(a, x=0.5):
    return spline_ellipsoid((a, 0.2, 0.2), (x, 0.5, 0.5), points=450)


def ball(x):
    return spheroid(0.2, x)


def particle(patches):
    return Boundary(tuple(map(Patch, patches)))


def positions(boundary):
    """Coefficients of the field x -> x."""
    dimension = boundary.dimension
    flat = [p.surface.points.reshape(-1, dimension) for p in boundary.patches]
    return np.concatenate(flat).T


def movie(path):
    """Pictures (count, height, width, 3) of an MP4 file."""
    reader = ffmpeg.read_frames(str(path))
    width, height = next(reader)["size"]
    shots = [np.frombuffer(raw, np.uint8).reshape(height, width, 3) for raw in reader]
    return np.stack(shots).astype(int)


def test_movie_as_mp4(tmp_path):
    """As many pictures as frames, of the size asked for, filled up to multiples of 16; steps of
    0.4 and 0.6 along the channel in the upper panel."""
    frames = frames_along((None, 0.4, 0.8, 1.4), ball)
    images = movie(draw_movie(tmp_path / "a" / "m.mp4", box(), frames, size=(300, 400)))
    assert images.shape == (4, 400, 304, 3)
    changed = (np.abs(images[1:, 30:170] - images[0, 30:170]) > 40).any(axis=-1)
    first, second, third = [np.nonzero(mask)[1].mean() for mask in changed]
    assert (third - second) / (second - first) == pytest.approx(1.5, abs=0.05)


def test_plane_movie_as_mp4(tmp_path):
    frames = frames_along((0.4, 0.8), lambda x: spline_circle(0.2, (x, 0.5), points=16))
    path = draw_movie(tmp_path / "m.mp4", rectangular_channel(), frames, colour="mean curvature")
    images = movie(path)
    assert len(images) == 2 and (np.array(images.shape[1:3]) % 16 == 0).all()
    assert (images[0] != images[1]).any()


def test_pictures_are_taken_one_at_a_time(tmp_path, monkeypatch):
    """Each picture is on its way to the encoder before the next one is taken; 7 × 5 pixels are
    filled up to 16 × 16."""
    events = []

    def take(number):
        events.append(f"take {number}")
        return Image.new("RGB", (7, 5))

    def writer(path, size, **options):
        while (pixels := (yield)) is not None:
            events.append(f"write {pixels.shape} {size}")

    monkeypatch.setattr(ffmpeg, "write_frames", writer)
    encoder(tmp_path / "m.mp4")(tmp_path / "m.mp4", Shots("m", 2, take))
    assert events == [what for k in range(2) for what in (f"take {k}", WRITTEN)]


def test_limits_hold_for_all_frames():
    """The mean curvature of spheroids (a, b, b): from that of the equator of the longest,
    (1 / b + b / a²) / 2, to that of its ends, a / b²."""
    frames = [Frame(k, {1: spheroid(a)}) for k, a in enumerate((0.2, 0.25))]
    colouring = Colouring.of(frames, "mean curvature", "mm")
    np.testing.assert_allclose(colouring.limits, [4.1, 6.25], rtol=0.01)
    assert colouring.label == "mean curvature (1/mm)"
    ends = colouring.colours(np.array([-1.0, *colouring.limits, 99.0]))
    assert (ends[0] == ends[1]).all() and (ends[2] == ends[3]).all() and (ends[1] != ends[2]).any()
    assert Colouring.of(frames, "", "mm") is None
    assert Colouring.of(frames, "mean curvature", "mm", limits=(0, 1)).limits == (0, 1)


def test_length_of_a_vector_field():
    """The field u = x about the origin is as long as the radius: 0.5 on a ball, 0.3 on a particle,
    1 and 0.4 at the ends of an ellipse."""
    drop, solid = spline_ellipsoid((0.5,) * 3, points=200), particle(sphere(0.3))
    fields = {1: {"velocity": drop.coefficients}, 2: {"velocity": positions(solid)}}
    colouring = Colouring.of([Frame(0.0, {1: drop, 2: solid}, fields)], "velocity", "", UNITS)
    np.testing.assert_allclose(colouring.limits, [0.3, 0.5], rtol=1e-3)
    assert colouring.label == "velocity (mm/s)"
    oval, disk = spline_ellipse((1.0, 0.4), points=64), particle(circle(0.6))
    fields = {1: {"velocity": oval.coefficients}, 2: {"velocity": positions(disk)}}
    colouring = Colouring.of([Frame(0.0, {1: oval, 2: disk}, fields)], "velocity", "")
    np.testing.assert_allclose(colouring.limits, [0.4, 1.0], rtol=1e-3)


def test_bodies_have_the_colours_of_their_values(tmp_path):
    """A droplet with the value 1 and one with the value 3 in the colours of the limits, which
    differ; a particle without the field is grey."""
    drops = {1: ball(0.3), 2: ball(1.2)}
    fields = {n: {"heat": np.full(d.basis.shape, 2.0 * n - 1)} for n, d in drops.items()}
    frame = Frame(0.0, {**drops, 3: particle(sphere(0.1, (1.7, 0.5, 0.5)))}, fields)
    colouring = Colouring.of([frame], "heat", "mm")
    np.testing.assert_allclose(colouring.limits, [1.0, 3.0])
    assert colouring.label == "heat"
    for number in (1, 2):
        colours = colouring.surface(frame, number).point_data["colour"]
        assert (colours == colouring.colours(np.array([2.0 * number - 1]))).all()
    grey = np.asarray(colouring.surface(frame, 3).cell_data["colour"]).astype(int)
    assert np.ptp(grey, axis=1).max() < 25
    for draw in (draw_scene, filmstrip):
        bodies = frame.shapes if draw is draw_scene else [frame, frame]
        more = {"fields": fields} if draw is draw_scene else {}
        path = draw(tmp_path / "a.png", box(), bodies, colour="heat", size=(400, 300), **more)
        image = np.asarray(Image.open(path).convert("RGB")).astype(int)
        yellow = (image[..., 0] > 200) & (image[..., 1] > 180) & (image[..., 2] < 100)
        assert yellow.sum() > 50


def test_outermost_points():
    """Of all frames only the points that matter are kept: a ball's extent is its diameter."""
    frames = frames_along((0.4, 1.4), ball)
    points = extent_of(None, frames)
    assert points.shape[1] <= 2 * 27
    np.testing.assert_allclose(np.ptp(points, axis=1), [1.4, 0.4, 0.4], atol=0.03)


def test_labels_with_units():
    assert quantity_label("speed", "m", UNITS) == "speed (mm/s)"
    assert quantity_label("wall shear stress", "m", UNITS) == "wall shear stress (Pa)"
    assert time_labels([Frame(0.0, {}), Frame(1.5, {})], "s") == ["t = 0.00 s", "t = 1.50 s"]


def test_mistakes(tmp_path, monkeypatch):
    frame = Frame(0.0, {1: ball(0.5)}, {1: {"velocity": ball(0.5).coefficients}})
    with pytest.raises(CadbemError, match="no .* 'speed' .*: mean curvature, velocity"):
        draw_movie(tmp_path / "m.gif", None, [frame], colour="speed")
    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", None)
    with pytest.raises(CadbemError, match="pip install imageio-ffmpeg"):
        draw_movie(tmp_path / "m.mp4", None, [frame])
