"""The visible part of each face in a picture, and the place of its number."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import distance_transform_edt

from cadbem.post.style.display import load_pyvista
from cadbem.post.style.layout import View, aim
from cadbem.post.style.style import BACKGROUND, INK, LETTER, add_text, scaled
from cadbem.spline.basis import Array

Pixel = tuple[float, float]  # column and row, rows upwards
LEAST = 1.5  # pixels that the visible part of a face must reach on each side of its middle
SPACIOUS = 0.9  # share of the most room that is enough for a label
RINGS, DIRECTIONS = 24, 16  # places that are tried around a face too small for its label
FRAME = 0.3  # room around a label, in heights of a letter


@dataclass(frozen=True, eq=False)
class VisibleFaces:
    """Numbers (height, width) of the faces that each pixel shows, row 0 at the bottom, 0 where
    there is none; ``corner`` and ``pixel`` place the picture in the view's coordinates."""

    faces: NDArray[np.int64]
    view: View
    corner: Array
    pixel: float
    depth: float

    def position(self, place: Pixel) -> Array:
        """The point (3,) in front of everything that is drawn at a pixel."""
        right, up = self.corner + self.pixel * (np.asarray(place) + 0.5)
        return right * self.view.right + up * self.view.up + self.depth * self.view.toward


def look(surface: Any, view: View, extent: Array, size: tuple[int, int]) -> VisibleFaces:
    """The visible faces of a surface with the cell data ``face``, in a panel of ``size`` pixels
    whose camera is set by ``aim``."""
    pyvista = load_pyvista()
    plotter = pyvista.Plotter(off_screen=True, window_size=size)
    try:
        plotter.set_background("black")
        plotter.render_window.SetMultiSamples(0)
        if surface.n_cells:
            codes = np.asarray(surface.cell_data["face"])
            painted = surface.copy(deep=False)
            painted.cell_data["code"] = np.stack(
                [codes >> 16, codes >> 8 & 255, codes & 255], axis=1
            ).astype(np.uint8)
            plotter.add_mesh(painted, scalars="code", rgb=True, lighting=False)
        aim(plotter, view, extent)
        image = plotter.screenshot(return_img=True).astype(np.int64)[::-1]
        height = 2 * plotter.camera.parallel_scale
        middle = view.flat(np.asarray(plotter.camera.focal_point)[:, None])[:, 0]
    finally:
        plotter.close()
    pixel = height / size[1]
    depth = float((view.toward @ extent).max() + 0.01 * height)
    corner = middle - 0.5 * pixel * np.array(size)
    return VisibleFaces(image @ np.array([65536, 256, 1]), view, corner, pixel, depth)


def roomiest(visible: VisibleFaces) -> dict[int, tuple[Pixel, float]]:
    """For each face that is visible, a pixel far from its edges as they appear, and how far: among
    those with nearly the most room the one nearest to the middle."""
    found = {}
    for face in np.unique(visible.faces[visible.faces > 0]).tolist():
        places = np.argwhere(visible.faces == face)
        low, high = places.min(axis=0), places.max(axis=0) + 1
        mask = visible.faces[low[0] : high[0], low[1] : high[1]] == face
        room = distance_transform_edt(np.pad(mask, 1))[1:-1, 1:-1]
        if room.max() > LEAST:
            best = np.argwhere(room >= SPACIOUS * room.max())
            middle = places.mean(axis=0) - low
            row, column = best[np.argmin(np.linalg.norm(best - middle, axis=1))]
            found[face] = (float(low[1] + column), float(low[0] + row)), float(room[row, column])
    return found


def place_labels(
    visible: VisibleFaces,
    spots: Mapping[int, tuple[Pixel, float]],
    labels: Mapping[int, str],
    letter: int,
) -> dict[int, Pixel]:
    """Middles of the labels of faces, none on top of another: in a face that has the room, else
    beside it, as near as may be.  ``spots`` are the ``roomiest`` ones."""
    taken: list[NDArray[np.float64]] = []
    places = {}
    small = np.zeros(visible.faces.shape, dtype=bool)
    for face, (_, room) in spots.items():
        if room < 0.6 * letter:
            small |= visible.faces == face
    for face, (spot, room) in sorted(spots.items(), key=lambda item: -item[1][1]):
        half = _half(labels[face], letter)
        tried = [spot] if room > 0.6 * letter else []
        tried += _around(spot, letter)
        free = (p for p in tried if _free(_box(p, half), taken, small, own=p == spot))
        places[face] = next(free, spot)
        taken.append(_box(places[face], half))
    return places


def _half(label: str, letter: int) -> tuple[float, float]:
    """Half the width and height of a label with its frame."""
    frame = FRAME * letter
    return 0.5 * LETTER * len(label) * letter + frame, 0.5 * letter + frame


def _around(spot: Pixel, letter: int) -> list[Pixel]:
    angles = 2 * np.pi * (np.arange(DIRECTIONS) + 0.5) / DIRECTIONS
    return [
        (spot[0] + reach * letter * np.cos(a), spot[1] + reach * letter * np.sin(a))
        for reach in 1.5 + 0.5 * np.arange(RINGS)
        for a in angles
    ]


def _box(middle: Pixel, half: tuple[float, float]) -> NDArray[np.float64]:
    return np.array(
        [middle[0] - half[0], middle[1] - half[1], middle[0] + half[0], middle[1] + half[1]]
    )


def _free(
    box: NDArray[np.float64],
    taken: list[NDArray[np.float64]],
    small: NDArray[np.bool_],
    own: bool,
) -> bool:
    """Whether a box lies in the picture, clear of labels and of the faces without room."""
    height, width = small.shape
    if box[0] < 0 or box[1] < 0 or box[2] > width or box[3] > height:
        return False
    if any((box[:2] < other[2:]).all() and (other[:2] < box[2:]).all() for other in taken):
        return False
    left, bottom, right, top = box.astype(int)
    return own or not small[bottom:top, left:right].any()


def add_labels(
    plotter: Any,
    visible: VisibleFaces,
    spots: Mapping[int, tuple[Pixel, float]],
    labels: Mapping[int, str],
    colours: Mapping[int, str],
    letter: int,
) -> None:
    """Labels on faces in the panel drawn at present, with lines to those too small for theirs."""
    places = place_labels(visible, spots, labels, letter)
    for face, (spot, _) in spots.items():
        if places[face] != spot:
            ends = np.stack([visible.position(spot), visible.position(places[face])])
            lines = load_pyvista().MultipleLines(ends)
            plotter.add_mesh(lines, color=INK, line_width=scaled(plotter, 2), lighting=False)
            dot = load_pyvista().PolyData(ends[:1])
            plotter.add_mesh(
                dot, color=INK, point_size=scaled(plotter, 7), render_points_as_spheres=True
            )
    for face, place in places.items():
        _write(plotter, labels[face], place, colours[face], letter)


def _write(plotter: Any, label: str, place: Pixel, colour: str, letter: int) -> None:
    """Text on pale ground; labels of VTK's own vanish where it finds them too close."""
    size = np.array(plotter.renderer.GetSize())
    share = (np.asarray(place) + 0.5) / size
    text = add_text(plotter, label, (float(share[0]), float(share[1])), letter)
    text.prop.color = colour
    text.prop.background_color, text.prop.background_opacity = BACKGROUND, 0.8
    text.prop.justification_horizontal = text.prop.justification_vertical = "center"
