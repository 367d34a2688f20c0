"""A plane drawing: curves with the layers that they are on."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cadbem.cad.text.unit import Unit
from cadbem.errors import CadError
from cadbem.spline.basis import Array
from cadbem.spline.nurbs import Nurbs


@dataclass(frozen=True, eq=False)
class DrawnCurve:
    """A plane curve in the file's unit."""

    curve: Nurbs
    layer: str

    @property
    def ends(self) -> Array:
        """Start and end (2, 2)."""
        return self.curve.points[[0, -1]]


@dataclass(frozen=True, eq=False)
class Drawing:
    """All curves of a file; `warnings` are lines on what was left out or had to be assumed."""

    file: str
    unit: Unit
    curves: tuple[DrawnCurve, ...]
    warnings: tuple[str, ...] = ()

    @property
    def layers(self) -> tuple[str, ...]:
        return tuple(sorted({drawn.layer for drawn in self.curves}))

    def on_layer(self, layer: str | int | None) -> tuple[list[DrawnCurve], list[DrawnCurve]]:
        """The curves of a layer, by default of the only one, and all others.

        Raises CadError if there is no such layer, or if there are several to choose from.
        """
        counts = {name: sum(d.layer == name for d in self.curves) for name in self.layers}
        listed = ", ".join(f"{name!r} with {n} curves" for name, n in counts.items()) or "none"
        if layer is None and len(counts) != 1:
            raise CadError(f"{self.file}: layers are {listed}; choose one with layer=")
        wanted = [name for name in counts if layer is None or _is_called(name, layer)]
        if not wanted:
            raise CadError(f"{self.file}: there is no layer {layer!r}; layers are {listed}")
        mine = [d for d in self.curves if d.layer in wanted]
        return mine, [d for d in self.curves if d.layer not in wanted]


def _is_called(name: str, layer: str | int) -> bool:
    """A GDS layer "2/0" is also called 2."""
    return name == str(layer) or (isinstance(layer, int) and name.split("/")[0] == str(layer))


def segment(start: Array, end: Array) -> Nurbs:
    """The straight curve between two points (2,)."""
    return Nurbs((1,), (np.repeat([0.0, 1.0], 2),), np.array([start, end]), np.ones(2))
