"""Constraints for what the equations of Stokes flow leave open, or fulfil only approximately.

f = n on a closed surface is a null vector of the single layer, for n·σ = n is a constant pressure
behind the surface and nothing before it.  So where a surface's velocity is given all over, its
traction is open by a multiple of n.  By symmetry ∮ n·S f dS = 0: the equations are compatible only
up to errors of discretisation, for which multiples of n on the surface make room.

Where the velocity of an opening is sought, the equations conserve mass, but for the same errors.
Then ∮ u·n dS = 0 takes the place of one of them, at the cost of multiples of n on such openings
alone: on walls these would disturb the flow everywhere by as much as mass was lost.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from cadbem.boundary import Boundary
from cadbem.operators.layers import Layers
from cadbem.operators.solve import Border
from cadbem.problems.mixed import Split
from cadbem.space import Field, Space, rational_basis
from cadbem.spline.basis import Array


@dataclass(frozen=True, eq=False)
class Constraints:
    """k linear functions of velocity and traction, and k fields that make room for them.

    ``velocity`` and ``traction`` (k, dim, F) are their coefficients on those of both, ``fields``
    (k, dim, T) are multiplied by unknown numbers and added to the equations.
    """

    velocity: Array
    traction: Array
    fields: Array

    def of(self, velocity: Array, traction: Array) -> Array:
        """Values (k,) for coefficients (dim, F) of velocity and traction."""
        return np.tensordot(self.velocity, velocity) + np.tensordot(self.traction, traction)

    def border(self, space: Space, splits: Sequence[Split]) -> Border:
        """The same for the unknowns alone."""
        rows = np.empty((len(self.velocity), splits[0].value_mixing.shape[1], space.count))
        for i, s in enumerate(splits):
            part = space.functions(i)
            rows[..., part] = s.value_mixing.T @ self.velocity[..., part]
            rows[..., part] += s.flux_mixing.T @ self.traction[..., part]
        return Border(rows, self.fields)


def joined(parts: Sequence[Constraints]) -> Constraints:
    """All constraints of several."""
    return Constraints(
        np.concatenate([p.velocity for p in parts]),
        np.concatenate([p.traction for p in parts]),
        np.concatenate([p.fields for p in parts]),
    )


def pressures(layers: Layers, viscosity: float, factor: float, fields: Array) -> Constraints:
    """The pressures at k points, ``factor`` (S f + μ D u), of both layers' pressures there."""
    one = np.eye(layers.kernel.components)
    patches = range(len(layers.space.boundary.patches))
    traction = [layers.columns(i, one, 0 * one)[0] for i in patches]
    velocity = [layers.columns(i, 0 * one, viscosity * one)[0] for i in patches]
    return Constraints(
        factor * np.concatenate(velocity, axis=2), factor * np.concatenate(traction, axis=2), fields
    )


def mean_normal_traction(space: Space, patches: Sequence[int], fields: Array) -> Constraints:
    """The mean of f·n over some patches."""
    area = Boundary(tuple(space.boundary.patches[i] for i in patches)).area()
    coefficients = normal_integrals(space, patches)[None] / area
    return Constraints(0 * coefficients, coefficients, fields)


def net_flux(space: Space, patches: Sequence[int], fields: Array) -> Constraints:
    """∫ u·n dS over some patches."""
    coefficients = normal_integrals(space, patches)[None]
    return Constraints(coefficients, 0 * coefficients, fields)


def normal_integrals(space: Space, patches: Iterable[int]) -> Array:
    """∫ R n dS of each function R on some patches, 0 on others: (dim, F)."""
    result = np.zeros((space.boundary.dimension, space.count))
    field = Field(space, result)
    for i in patches:
        parameters, points, weights = field.nodes(i)
        basis = rational_basis(space.boundary.patches[i].surface, parameters)
        result[:, space.functions(i)] = (points.normal * weights) @ basis
    return result


def normals(space: Space, patches: Iterable[int]) -> Array:
    """The normal at collocation points of some patches, 0 on others: one field (1, dim, T)."""
    field = np.zeros_like(space.collocation.normal)
    for i in patches:
        part = space.functions(i)
        field[:, part] = space.collocation.normal[:, part]
    return field[None]
