"""Surfaces, colours and names of bodies in pictures."""

from __future__ import annotations

import colorsys
from collections import Counter
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cadbem.boundary import Boundary
from cadbem.post.bodies.droplets import tessellated_droplet
from cadbem.post.fields.cells import tessellated
from cadbem.post.fields.frames import Frame, Shape
from cadbem.post.style.style import PALETTE, WALL
from cadbem.spline.closed import ClosedSpline

CELLS = 12  # flat cells along a particle's patches, at least
PALE = 0.72  # share of white in a particle's pale chequers
LEGIBLE = 8  # bodies that a legend names one by one


def body_name(number: int, shape: Shape) -> str:
    """The name of a body in legends."""
    return f"{'droplet' if isinstance(shape, ClosedSpline) else 'particle'} {number}"


def body_colour(number: int) -> str:
    """A body's colour, which depends on nothing but its number."""
    if 0 <= number < len(PALETTE):
        return PALETTE[number]
    # the golden ratio spreads any number of hues
    red, green, blue = colorsys.hls_to_rgb(0.618034 * number % 1, 0.42 + 0.16 * (number % 2), 0.6)
    return f"#{round(255 * red):02x}{round(255 * green):02x}{round(255 * blue):02x}"


def pale(colour: str) -> str:
    """A colour mixed with white."""
    mixed = 255 * PALE + (1 - PALE) * _rgb(colour)
    return "#" + bytes(mixed.round().astype(int).tolist()).hex()


def _rgb(colour: str) -> NDArray[np.uint8]:
    return np.frombuffer(bytes.fromhex(colour[1:]), dtype=np.uint8)


def legend_of(frames: Sequence[Frame]) -> dict[str, str]:
    """Names of bodies and their colours; many bodies are counted instead."""
    shapes = {n: shape for frame in frames for n, shape in frame.shapes.items()}
    if len(shapes) <= LEGIBLE:
        return {body_name(n, shapes[n]): body_colour(n) for n in sorted(shapes)}
    kinds = Counter(body_name(n, shape).split()[0] for n, shape in shapes.items())
    return {f"{n} {kind}{'s' * (n > 1)}": WALL for kind, n in sorted(kinds.items())}


def body_surface(number: int, shape: Shape, colour: str = "") -> Any:
    """A body in space as ``pyvista.PolyData`` with unit ``Normals`` outwards and the point or
    cell data ``colour``: droplets plain, particles chequered, so that one sees them turn; in the
    body's own colour or another one."""
    colour = colour or body_colour(number)
    if isinstance(shape, ClosedSpline):
        surface = tessellated_droplet(shape)
        surface.point_data["colour"] = np.tile(_rgb(colour), (surface.n_points, 1))
    else:
        surface = tessellated(shape, density(shape))
        surface.cell_data["colour"] = _chequers(shape, colour)
    surface.point_data.active_normals_name = "Normals"
    return surface


def density(boundary: Boundary) -> int:
    """Cells a direction in each element, an even number, for chequers."""
    spans = min(len(p.surface.breaks(d)) - 1 for p in boundary.patches for d in (0, 1))
    return 2 * max(1, round(0.5 * CELLS / spans))


def _chequers(boundary: Boundary, colour: str) -> NDArray[np.uint8]:
    """Colours of the cells of ``tessellated``: each patch is cut into two by two fields."""
    colours = []
    for patch in boundary.patches:
        rows, columns = (density(boundary) * (len(patch.surface.breaks(d)) - 1) for d in (0, 1))
        i, j = np.indices((rows, columns)).reshape(2, -1)
        dark = (2 * i // rows + 2 * j // columns) % 2 == 0
        colours.append(np.where(dark[:, None], _rgb(colour), _rgb(pale(colour))))
    return np.concatenate(colours)
