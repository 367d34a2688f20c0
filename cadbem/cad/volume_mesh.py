"""Tetrahedra in the volume of the fluid, for the display of fields."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from cadbem.cad.body.model import file_unit
from cadbem.cad.kernel.process import mesh_model
from cadbem.cad.text.source import read_source
from cadbem.errors import CadError
from cadbem.spline.basis import Array


def mesh_volume(
    path: str | Path, size: float, *, time_limit: float = 60.0
) -> tuple[Array, np.ndarray]:
    """Points (3, N) and tetrahedra (4, M), indices of points, of the file's only solid.

    `size` is the largest length of an element; it and the points are in the file's unit.
    Raises CadError as `read_cad` does for files that cannot be read, if there is not exactly one
    solid, and for a size that is not positive.
    """
    if not (np.isfinite(size) and size > 0):
        raise CadError(f"size of the tetrahedra: {size} is not a positive length")
    source = read_source(path)
    factor = file_unit(source).millimetres
    points, tetrahedra = mesh_model(source, size * factor, time_limit)
    return points / factor, tetrahedra
