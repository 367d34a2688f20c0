"""Bodies at several times as files for ParaView, all at once or while a run goes on."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np

from cadbem.boundary import Boundary, Patch
from cadbem.files import write_whole
from cadbem.post.bodies.bodies import body_name
from cadbem.post.fields.bezier import bezier_grid
from cadbem.post.fields.body_fields import BodyField, control_values, fields_of
from cadbem.post.fields.frames import Frame, Shape, require_frames
from cadbem.post.files.export import prepared, write_vtu
from cadbem.post.style.display import load_pyvista
from cadbem.spline.basis import Array
from cadbem.spline.closed import ClosedSpline


def write_frames(
    folder: str | Path, frames: Sequence[Frame], channel: Boundary | None = None
) -> Path:
    """Bodies as exact Bézier cells, surfaces or, in a plane, curves: ``bodies_0000.vtu`` and so on,
    and a list of them with their times, ``bodies.pvd``, which ParaView opens; returns its path.  A
    channel becomes ``channel.vtu``.

    Cell data: ``body``, the number, and those of ``bezier_grid``.  Point data: the frames' fields,
    and the mean curvature of droplets (interpolated at their collocation points); not a number
    on bodies that have none.  Raises ``CadbemError`` without frames or bodies.
    """
    require_frames(None, frames)
    for index, frame in enumerate(frames):
        write_frame(folder, index, frame)
    if channel is not None:
        write_channel(folder, channel)
    return write_index(folder, [frame.time for frame in frames])


def write_frame(folder: str | Path, index: int, frame: Frame) -> Path:
    """One frame of ``write_frames``, ``bodies_0012.vtu`` for the ``index`` 12; without bodies it is
    empty."""
    return write_vtu(Path(folder) / _file_name(index), _grid(frame))


def write_index(folder: str | Path, times: Sequence[float]) -> Path:
    """The list ``bodies.pvd`` of the frames 0, 1, ... at ``times``; an older one is replaced as a
    whole, so that ParaView may read it at any moment."""
    collection = prepared(Path(folder) / "bodies.pvd")
    root = ElementTree.Element("VTKFile", type="Collection", version="0.1")
    listing = ElementTree.SubElement(root, "Collection")
    for index, time in enumerate(times):
        step = {"timestep": repr(float(time)), "part": "0", "file": _file_name(index)}
        ElementTree.SubElement(listing, "DataSet", step)
    ElementTree.indent(root)
    write_whole(collection, ElementTree.tostring(root, encoding="utf-8", xml_declaration=True))
    return collection


def write_channel(folder: str | Path, channel: Boundary) -> Path:
    """The channel's patches as exact Bézier cells, ``channel.vtu``."""
    return write_vtu(Path(folder) / "channel.vtu", bezier_grid(channel))


def _file_name(index: int) -> str:
    return f"bodies_{index:04d}.vtu"


def _grid(frame: Frame) -> Any:
    """All bodies of a frame, or an empty grid when they are gone."""
    owned = [
        (number, replace(patch, name=body_name(number, shape)))
        for number, shape in frame.shapes.items()
        for patch in _patches(shape)
    ]
    if not owned:
        return load_pyvista().UnstructuredGrid()
    boundary = Boundary(tuple(patch for _, patch in owned))
    grid = bezier_grid(boundary, _fields(frame, boundary))
    grid.cell_data["body"] = np.array([n for n, _ in owned])[grid.cell_data["patch"]]
    return grid


def _patches(shape: Shape) -> Sequence[Patch]:
    return (Patch(shape.patch()),) if isinstance(shape, ClosedSpline) else shape.patches


def _fields(frame: Frame, boundary: Boundary) -> dict[str, BodyField]:
    """Every field on the patches of all bodies, not a number on bodies without it."""
    found = {
        number: {n: control_values(shape, c) for n, c in fields_of(frame, number).items()}
        for number, shape in frame.shapes.items()
    }
    counts = {n: len(parts[0]) for fields in found.values() for n, parts in fields.items()}
    columns = {}
    for name, count in counts.items():
        values: list[Array] = []
        for number, shape in frame.shapes.items():
            sizes = [patch.surface.weights.shape for patch in _patches(shape)]
            missing = [np.full((count, *size), np.nan) for size in sizes]
            values += found[number].get(name, missing)
        columns[name] = BodyField(boundary, values)
    return columns
