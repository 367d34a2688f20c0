"""Bodies coloured by a field, within the same limits in all frames."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cadbem.checks import positive, shaped
from cadbem.errors import CadbemError
from cadbem.post.bodies.bodies import body_surface, density
from cadbem.post.bodies.droplets import tessellated_droplet
from cadbem.post.fields.body_fields import BodyField, control_values, fields_of
from cadbem.post.fields.cells import between, tessellated
from cadbem.post.fields.frames import Frame, Shape
from cadbem.post.style.style import colour_limits, light_colours, quantity_label
from cadbem.progress import progress
from cadbem.spline.basis import Array
from cadbem.spline.closed import ClosedSpline
from cadbem.units import UnitNames

NEUTRAL = "#8a939c"  # bodies that do not have the field
SAMPLES = 16  # points along each element of an outline


@dataclass(frozen=True, eq=False)
class Colouring:
    """The field ``name`` (the length of a vector field) in colours that end at ``limits``."""

    name: str
    limits: tuple[float, float]
    label: str

    @staticmethod
    def of(
        frames: Sequence[Frame],
        name: str,
        unit: str,
        units: UnitNames | None = None,
        limits: tuple[float, float] | None = None,
    ) -> Colouring | None:
        """Colours for all frames, nothing for an empty name; limits are the extremes unless given.

        Raises ``CadbemError`` when no body has such a field.
        """
        if not name:
            return None
        found = [
            (values.min(), values.max())
            for frame in progress(frames, name)
            for values in _all_values(frame, name)
        ]
        if not found:
            known = sorted({n for f in frames for b in f.shapes for n in fields_of(f, b)})
            others = f"there are: {', '.join(known)}" if known else "give the frames fields"
            raise CadbemError(f"no body has a field '{name}' to be coloured by; {others}")
        low, high = np.array(found).T
        ends = colour_limits(low.min(), high.max()) if limits is None else _checked(limits)
        return Colouring(name, ends, quantity_label(name, unit, units))

    def surface(self, frame: Frame, number: int) -> Any:
        """A body as ``body_surface`` gives it, in the colours of its values."""
        shape = frame.shapes[number]
        coefficients = fields_of(frame, number).get(self.name)
        if coefficients is None:
            return body_surface(number, shape, NEUTRAL)
        surface = _valued(shape, coefficients)
        surface.point_data["colour"] = self.colours(surface.point_data["value"])
        surface.point_data.active_normals_name = "Normals"
        return surface

    def scale(self, count: int) -> NDArray[np.uint8]:
        """Colours (count, 3) from end to end."""
        return self.colours(np.linspace(*self.limits, count))

    def colours(self, values: Array) -> NDArray[np.uint8]:
        """Red, green and blue (N, 3) of values (N,)."""
        share = (np.asarray(values) - self.limits[0]) / (self.limits[1] - self.limits[0])
        return light_colours()(np.clip(share, 0, 1), bytes=True)[..., :3]


def _all_values(frame: Frame, name: str) -> Iterator[Array]:
    for number, shape in frame.shapes.items():
        coefficients = fields_of(frame, number).get(name)
        if coefficients is None:
            continue
        if shape.dimension == 2:
            yield np.concatenate([values for _, values in outline_values(shape, coefficients)])
        else:
            yield np.asarray(_valued(shape, coefficients).point_data["value"])


def _valued(shape: Shape, coefficients: Array) -> Any:
    """A body in space as ``pyvista.PolyData`` with the point data ``value`` (N,)."""
    if isinstance(shape, ClosedSpline):
        return tessellated_droplet(shape, coefficients)
    field = BodyField(shape, control_values(shape, coefficients))
    surface = tessellated(shape, density(shape), {"value": field})
    surface.point_data["value"] = _lengths(np.asarray(surface.point_data["value"]).T)
    return surface


def outline_values(shape: Shape, coefficients: Array) -> list[tuple[Array, Array]]:
    """Points (2, n) along each part of an outline in a plane, with the values (n,) there."""
    if isinstance(shape, ClosedSpline):
        t = np.linspace(0, 2 * np.pi, SAMPLES * shape.basis.count + 1)[None]
        return [(shape.evaluate(t), _lengths(shape.basis.evaluate(coefficients, t)))]
    field = BodyField(shape, control_values(shape, coefficients))
    parts = []
    for index, patch in enumerate(shape.patches):
        t = between(patch.surface.breaks(0), SAMPLES)
        parts.append((patch.surface.evaluate(t), _lengths(field.on_patch(index, t))))
    return parts


def _lengths(values: Array) -> Array:
    """A scalar field (N,) or (1, N) as it is, the length of a vector field (dim, N)."""
    if values.ndim == 1:
        return values
    return values[0] if len(values) == 1 else np.linalg.norm(values, axis=0)


def _checked(limits: tuple[float, float]) -> tuple[float, float]:
    low, high = shaped("limits", limits, 2)
    positive("the difference of the limits", high - low)
    return float(low), float(high)
