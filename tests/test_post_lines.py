"""Plots over time and paths as tubes, against what is known of their places and colours."""

from types import SimpleNamespace

import numpy as np
import pytest
from PIL import Image
from post_stand_ins import box, rectangular_channel

from cadbem.errors import CadbemError, ShapeError
from cadbem.post import draw_paths, draw_series
from cadbem.post.style.style import PALETTE, quantity_label

pytest.importorskip("pyvista")
UNITS = SimpleNamespace(length="mm", time="s", pressure="Pa")
TIMES = np.linspace(0, 2, 41)


def picture(path):
    return np.asarray(Image.open(path).convert("RGB")).astype(int)


def close_to(image, colour, room=12):
    wanted = list(bytes.fromhex(colour[1:])) if isinstance(colour, str) else colour
    return (abs(image - wanted) < room).all(axis=-1)


def test_series(tmp_path):
    """Body 1 leaves at half time: its line, above the legend, is half as long as that of body 2;
    each has its colour."""
    half = np.where(TIMES <= 1, TIMES, np.nan)
    path = draw_series(tmp_path / "a" / "s.png", TIMES, {"x (mm)": {1: half, 2: 0 * TIMES}})
    image = picture(path)
    lines = image[: int(0.75 * len(image))]
    spans = [np.ptp(np.nonzero(close_to(lines, PALETTE[k]))[1]) for k in (1, 2)]
    assert spans[0] / spans[1] == pytest.approx(0.5, abs=0.02)
    assert close_to(image[int(0.85 * len(image)) :], PALETTE[1]).any()  # the legend


def test_panels_of_series(tmp_path):
    """Up to three panels are in one column, four make two columns; many bodies are counted."""
    few = {name: TIMES for name in "abc"}
    narrow = picture(draw_series(tmp_path / "s.png", TIMES, few)).shape
    wide = picture(draw_series(tmp_path / "w.png", TIMES, {**few, "d": TIMES})).shape
    assert (narrow[1], wide[1]) == (900, 1800) and wide[0] < narrow[0]
    many = {"x": {k: k * TIMES for k in range(20)}}
    assert picture(draw_series(tmp_path / "m.png", TIMES, many, units=UNITS)).shape[1] == 900


def test_tubes_are_coloured_by_values(tmp_path):
    """A path along x whose value is x: purple at one end, yellow at the other, and between them
    as far as the path is long, 1.5 of a channel of 2."""
    x = np.linspace(0.25, 1.75, 50)
    track = np.stack([x, 0 * x + 0.5, 0 * x + 0.5])
    path = draw_paths(tmp_path / "p.png", box(), [track], values=[x], label="speed", units=UNITS)
    image = picture(path)
    plan = image[: int(0.85 * len(image)), : image.shape[1] // 2]
    left, right = (np.nonzero(close_to(plan, c, 40))[1] for c in ((68, 1, 84), (253, 231, 37)))
    assert left.size and right.size
    # the channel's plan, with a name on each side, is framed by its openings in light blue
    frame = np.nonzero(close_to(plan, "#8fb8de", 6))[1]
    assert (right.max() - left.min()) / np.ptp(frame) == pytest.approx(0.75, abs=0.03)


def test_paths_in_a_plane(tmp_path):
    """A path of length 1.5 in a channel of length 2, in its own colour; points that are not there
    are left out."""
    x = np.linspace(0.25, 1.75, 50)
    gone = np.append(x, np.nan)
    track = np.stack([gone, 0 * gone + 0.5])
    image = picture(draw_paths(tmp_path / "p.png", rectangular_channel(), [track]))
    line = np.nonzero(close_to(image, PALETTE[0]))[1]
    frame = np.nonzero(close_to(image, "#8fb8de", 6))[1]
    assert np.ptp(line) / np.ptp(frame) == pytest.approx(0.75, abs=0.02)
    coloured = draw_paths(tmp_path / "c.png", None, [track], values=[gone], label="time")
    assert close_to(picture(coloured), (253, 231, 37)).any()


def test_labels_of_time():
    assert quantity_label("time", "mm") == "time"
    assert quantity_label("time", "mm", UNITS) == "time (s)"


def test_mistakes(tmp_path):
    track = np.zeros((3, 4))
    with pytest.raises(ShapeError, match="'D, body 2' has values of shape .*3,.*, the times .*41"):
        draw_series(tmp_path / "s.png", TIMES, {"D": {2: np.zeros(3)}})
    with pytest.raises(ShapeError, match="at least one quantity"):
        draw_series(tmp_path / "s.png", TIMES, {})
    with pytest.raises(ShapeError, match="one value a point"):
        draw_paths(tmp_path / "p.png", None, [track], values=[np.zeros(3)])
    with pytest.raises(CadbemError, match="at least one path"):
        draw_paths(tmp_path / "p.png", box(), [])
    with pytest.raises(ShapeError, match="all be in 2D or all in 3D"):
        draw_paths(tmp_path / "p.png", box(), [np.zeros((2, 4))])
