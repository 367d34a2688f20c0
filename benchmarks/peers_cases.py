"""Channels that cadbem and finite elements both compute, with the pressures at their inlets."""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np

import cadbem as cb
from cadbem.boundary import Boundary

GEOMETRIES = Path(__file__).parents[1] / "geometries"
Place = tuple[int, float]  # an axis, and where along it an opening lies


@dataclass(frozen=True)
class Channel:
    """A STEP file, its openings, and the mean pressures at its inlets.

    ``openings`` are the planes of those that the file does not name.  ``edges`` are a point on
    each re-entrant edge.  ``outlet`` is the axis along which fluid leaves, ``width`` the shortest
    side.  ``pressures`` are what both codes agree on, to a relative ``doubt``.
    """

    file: Callable[[], Path]
    outlet: int
    pressures: tuple[float, ...]
    doubt: float
    width: float = 1.0
    openings: dict[str, Place] | None = None
    edges: tuple[tuple[float, float, float], ...] = ()

    def boundary(self) -> Boundary:
        """What cadbem reads, with names."""
        read = cb.read_cad(self.file())
        if self.openings is None:
            return read
        places = {name: _on(*place) for name, place in self.openings.items()}
        return read.named(rest="walls", **places)


@dataclass(frozen=True)
class Elements:
    """Velocities of ``order``, elements of a ``size``; and how they are refined at re-entrant
    edges: to a size ``near`` them, or cut ``levels`` times towards them by a ``factor``.
    ``care`` is netgen's own three rounds of mesh improvement instead of one quick one.
    """

    order: int
    size: float
    near: float | None = None
    levels: int = 0
    factor: float = 0.15
    care: bool = False


def _on(axis: int, place: float) -> Callable[[np.ndarray, np.ndarray], bool]:
    """Whether a face lies across an axis, at a place."""
    return lambda x, n: bool(abs(x[axis] - place) < 1e-6 and abs(n[axis]) > 0.9)


def _drawn(name: str) -> Callable[[], Path]:
    return lambda: GEOMETRIES / f"{name}.step"


@cache
def t_junction() -> Path:
    """Two boxes of section 1, joined by gmsh, in a temporary file."""
    import gmsh

    path = Path(tempfile.gettempdir(), "cadbem_peers_t.step")
    gmsh.initialize(interruptible=False, readConfigFiles=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.model.add("t")
        occ = gmsh.model.occ
        main, side = occ.addBox(-4, -0.5, -0.5, 8, 1, 1), occ.addBox(-0.5, -4.5, -0.5, 1, 4, 1)
        occ.fuse([(3, main)], [(3, side)])
        occ.synchronize()
        gmsh.write(str(path))
    finally:
        gmsh.finalize()
    return path


ROOT = 2**0.5
CHANNELS = {
    "T-junction": Channel(
        t_junction, 0, (333.92, 343.606), 5e-5,
        openings={"inlet_a": (0, -4.0), "inlet_b": (1, -4.5), "outlet": (0, 4.0)},
        edges=((-0.5, -0.5, 0.0), (0.5, -0.5, 0.0)),
    ),
    "Y-junction": Channel(
        _drawn("y_junction"), 0, (44.959, 44.959), 3e-5, width=4.0,
        edges=(
            (3 * ROOT, 5 * ROOT, 2.0),
            (7 * ROOT - 2, 5 * ROOT - 2, 2.0),
            (7 * ROOT - 2, 5 * ROOT + 2, 2.0),
        ),
    ),
    "serpentine": Channel(_drawn("serpentine"), 0, (720.935,), 1e-4),
    "bent pipe": Channel(_drawn("bent_pipe"), 1, (69.6010,), 1e-5, width=2.0),
    "constriction": Channel(_drawn("constriction"), 0, (355.210,), 9e-5, width=0.8),
}  # fmt: skip
