"""Bodies at several times as files for ParaView."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np

from cadbem.boundary import Boundary, Patch
from cadbem.errors import ShapeError
from cadbem.post.bezier import bezier_grid
from cadbem.post.bodies import Frame, Shape, body_name, require_frames
from cadbem.post.display import load_pyvista
from cadbem.post.export import write_vtu
from cadbem.spline.closed import ClosedSpline


def write_frames(folder: str | Path, frames: Sequence[Frame]) -> Path:
    """Bodies in space as exact Bézier cells: ``bodies_0000.vtu`` and so on, and a list of them
    with their times, ``bodies.pvd``, which ParaView opens; returns its path.

    Cell data: ``body``, the number, and those of ``bezier_grid``.  Raises ``CadbemError`` without
    frames or bodies, ``ShapeError`` for bodies in a plane.
    """
    if require_frames(None, frames) == 2:
        raise ShapeError("bodies in 2D have no surfaces to write: write_frames is for 3D")
    collection = Path(folder) / "bodies.pvd"
    root = ElementTree.Element("VTKFile", type="Collection", version="0.1")
    listing = ElementTree.SubElement(root, "Collection")
    for k, frame in enumerate(frames):
        target = write_vtu(collection.with_name(f"bodies_{k:04d}.vtu"), _grid(frame))
        time = repr(float(frame.time))
        ElementTree.SubElement(listing, "DataSet", timestep=time, part="0", file=target.name)
    ElementTree.indent(root)
    ElementTree.ElementTree(root).write(collection, encoding="utf-8", xml_declaration=True)
    return collection


def _grid(frame: Frame) -> Any:
    """All bodies of a frame, or an empty grid when they are gone."""
    patches, numbers = [], []
    for number, shape in frame.shapes.items():
        for patch in _patches(shape):
            patches.append(replace(patch, name=body_name(number, shape)))
            numbers.append(number)
    if not patches:
        return load_pyvista().UnstructuredGrid()
    grid = bezier_grid(Boundary(tuple(patches)))
    grid.cell_data["body"] = np.array(numbers)[grid.cell_data["patch"]]
    return grid


def _patches(shape: Shape) -> Sequence[Patch]:
    return (Patch(shape.patch()),) if isinstance(shape, ClosedSpline) else shape.patches
