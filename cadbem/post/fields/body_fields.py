"""Fields on bodies for pictures and files: velocities, tractions, curvatures."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from cadbem.boundary import Boundary
from cadbem.closed_points import ClosedGrid
from cadbem.errors import ShapeError
from cadbem.post.fields.frames import Frame, Shape
from cadbem.spline.basis import Array
from cadbem.spline.closed import ClosedSpline

CURVATURE = "mean curvature"  # a field that every droplet has


@dataclass(frozen=True, eq=False)
class BodyField:
    """A field on the patches of a body by its control values, (components, n_u[, n_v]) each."""

    boundary: Boundary
    values: Sequence[Array]

    def patch_coefficients(self, index: int) -> Array:
        """Control values (components, n_u[, n_v]) of one patch."""
        return self.values[index]

    def on_patch(self, index: int, *parameters: ArrayLike) -> Array:
        """Values (components, *shape) at parameters of one patch."""
        control = np.moveaxis(self.values[index], 0, -1)
        surface = self.boundary.patches[index].surface
        return replace(surface, points=control).evaluate(*parameters)


def fields_of(frame: Frame, number: int) -> Mapping[str, Array]:
    """Coefficients of a body's fields by name, the mean curvature of a droplet among them.

    Raises ``ShapeError`` when there are not as many coefficients as functions on the body.
    """
    shape = frame.shapes[number]
    known = {name: np.asarray(array) for name, array in frame.fields.get(number, {}).items()}
    layout = shape.basis.shape if isinstance(shape, ClosedSpline) else (_functions(shape),)
    for name, coefficients in known.items():
        if coefficients.ndim > len(layout) + 1 or coefficients.shape[-len(layout) :] != layout:
            raise ShapeError(
                f"body {number}: the field '{name}' has coefficients of shape "
                f"{coefficients.shape}; give {layout} or (dim, {', '.join(map(str, layout))})"
            )
    return {CURVATURE: mean_curvature(shape), **known} if isinstance(shape, ClosedSpline) else known


def mean_curvature(spline: ClosedSpline) -> Array:
    """Coefficients (*shape) of the spline through the mean curvature at the collocation points:
    c / 2 with c = div n, or the curvature c of a plane curve."""
    grid = ClosedGrid(spline.basis, spline.basis.axes())
    curvature = grid.points(spline).curvature / (spline.dimension - 1)
    return spline.basis.fit(curvature.reshape(spline.basis.shape))


def control_values(shape: Shape, coefficients: Array) -> list[Array]:
    """Control values (components, n_u[, n_v]) on each of a body's patches."""
    if isinstance(shape, ClosedSpline):
        full = coefficients.reshape(-1, *shape.basis.shape)
        return [np.moveaxis(shape.patch(full).points, -1, 0)]
    sizes = [patch.surface.weights.shape for patch in shape.patches]
    ends = np.cumsum([int(np.prod(size)) for size in sizes])[:-1]
    parts = np.split(coefficients.reshape(-1, coefficients.shape[-1]), ends, axis=1)
    return [part.reshape(-1, *size) for part, size in zip(parts, sizes, strict=True)]


def _functions(boundary: Boundary) -> int:
    return sum(patch.surface.weights.size for patch in boundary.patches)
