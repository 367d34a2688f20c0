"""Tetrahedra in the volume of the fluid, for the display of fields."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from cadbem.cad.body.model import file_unit
from cadbem.cad.kernel.process import mesh_model
from cadbem.cad.text.source import read_source
from cadbem.checks import positive
from cadbem.spline.basis import Array


def mesh_volume(
    path: str | Path, size: float, *, time_limit: float = 60.0
) -> tuple[Array, np.ndarray]:
    """Points (3, N) and tetrahedra (4, M), indices of points, of the file's only solid.

    `size` is the largest length of an element; it and the points are in the file's unit.
    Raises CadError as `read_cad` does for files that cannot be read, and if there is not exactly
    one solid; InputError for a size that is not positive.
    """
    positive("size", size)
    positive("time_limit", time_limit)
    source = read_source(path)
    factor = file_unit(source).millimetres
    points, tetrahedra = mesh_model(source, size * factor, time_limit)
    return points / factor, tetrahedra
