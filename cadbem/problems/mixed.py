"""Mixed boundary value problems of any equation: given data and unknowns on each patch.

On each patch a *value* u (velocity, temperature) and a *flux* f (traction, heat flux) are split
into known parts and an unknown q: u = u_known + U q, f = f_known + F q.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from cadbem.boundary import Boundary
from cadbem.checks import shaped
from cadbem.errors import ConditionError, SelectionError, ShapeError
from cadbem.kernels.kernel import Kernel
from cadbem.operators.compressed.iterate import Iteration
from cadbem.operators.compressed.layers import CompressedLayers
from cadbem.operators.interactions import Targets
from cadbem.operators.layers import OwnLayers
from cadbem.operators.locate import locate
from cadbem.operators.potentials import Potentials
from cadbem.operators.solve import Border, DenseFactors, Solved, factorise
from cadbem.points import SurfacePoints
from cadbem.quadrature import Rules
from cadbem.space import Space
from cadbem.spline.basis import Array

Given = Callable[[SurfacePoints], Array]


@dataclass(frozen=True, eq=False)
class Split:
    """Known data (None: zero) and mixing matrices U and F (components, unknowns) of a patch."""

    value: Given | None
    flux: Given | None
    value_mixing: Array
    flux_mixing: Array


@dataclass(frozen=True, eq=False)
class MixedSystem:
    """c u = flux_factor S f + D u + source at the collocation points of ``layers``.

    S and D are the layers without factors, c is their free term; ``splits`` one a patch; a
    ``border`` fixes what the equations leave open.
    """

    layers: OwnLayers
    flux_factor: float
    splits: Sequence[Split]
    border: Border | None = None

    @property
    def space(self) -> Space:
        """Unknowns and collocation points."""
        return self.layers.space

    @property
    def free_term(self) -> float:
        """The free term: the double layer of constant values."""
        return self.layers.kernel.free_term

    def known(self) -> tuple[Array, Array]:
        """Coefficients (components, F) of the known value and flux, by projection."""
        shape = (self.layers.kernel.components, self.space.count)
        value, flux = np.zeros(shape), np.zeros(shape)
        for i, s in enumerate(self.splits):
            for given, into in ((s.value, value), (s.flux, flux)):
                if given is not None:
                    into[:, self.space.functions(i)] = self.space.project(i, given)
        return value, flux

    @cached_property
    def factors(self) -> DenseFactors | Iteration:
        """The factorised system."""
        single = [self.flux_factor * s.flux_mixing for s in self.splits]
        double = [s.value_mixing for s in self.splits]
        if isinstance(self.layers, CompressedLayers):
            return self.layers.system(self.free_term, single, double, self.border)
        return factorise(self.layers, self.free_term, single, double, self.border)

    def with_data(self, splits: Sequence[Split]) -> MixedSystem:
        """The same matrix, its factors shared, with other data on patches of the same kinds."""
        other = replace(self, splits=splits)
        vars(other)["factors"] = self.factors
        return other

    def unknowns(
        self,
        value: Array,
        flux: Array,
        source: Array | float = 0.0,
        constraints: Array | float = 0.0,
    ) -> Solved:
        """Unknowns (k, F) that go with known coefficients and a ``source`` (rows, T).

        ``constraints`` (k,) are the right sides of the border's rows.
        """
        right = np.zeros((self.layers.kernel.rows, self.layers.count)) - source
        if value.any() or flux.any():
            right += self.free_term * self.space.values(value)
            right -= self.layers.apply(self.flux_factor * flux, value)
        return self.factors.solve(right, constraints)

    def flux_responses(self, patches: Sequence[int]) -> Array:
        """Unknowns (k, F, M) that each of the M coefficients of known flux on patches brings."""
        one = np.eye(self.layers.kernel.components)
        blocks = [self.layers.columns(i, one, 0 * one) for i in patches]
        right = np.concatenate([b.reshape(*b.shape[:2], -1) for b in blocks], axis=2)
        return self.factors.solve(-self.flux_factor * right).unknowns

    def complete(self, value: Array, flux: Array, unknowns: Array) -> tuple[Array, Array]:
        """Coefficients of the whole value and flux from known parts and unknowns."""
        value, flux = value.copy(), flux.copy()
        for i, s in enumerate(self.splits):
            part = self.space.functions(i)
            value[:, part] += s.value_mixing @ unknowns[:, part]
            flux[:, part] += s.flux_mixing @ unknowns[:, part]
        return value, flux


def represent(
    kernel: Kernel,
    space: Space,
    points: ArrayLike,
    quadrature: Rules,
    single: Array,
    double: Array,
    on_patch: Callable[..., Array],
    far_away: Callable[[Array], Array] | None = None,
) -> Array:
    """S single + D double at points (dim, M) off the boundary, ``on_patch`` at those on it.

    ``single`` and ``double`` (components, F) are coefficients, with the equation's factors;
    ``on_patch(patch, *parameters)`` gives (rows, ·).  ``far_away(position)``, what the layers
    come on top of, counts off the boundary only.  Result (rows, M).
    """
    position = np.ascontiguousarray(shaped("points", points, *[None] * np.ndim(points)))
    dimension = space.boundary.dimension
    if position.ndim != 2 or len(position) != dimension:
        one = ", ".join(["[x]", "[y]", "[z]"][:dimension])
        raise ShapeError(
            f"points have the shape {position.shape}; give coordinates ({dimension}, N), a column "
            f"a point: [{one}] is one"
        )
    owner, parameters = locate(space.boundary, position)
    inside = owner < 0
    result = np.empty((kernel.rows, position.shape[1]))
    targets = Targets.free(np.ascontiguousarray(position[:, inside]))
    result[:, inside] = Potentials(kernel, space, targets, quadrature).apply(single, double)
    if far_away is not None:
        result[:, inside] += far_away(position[:, inside])
    for patch in np.unique(owner[~inside]):
        here = owner == patch
        result[:, here] = on_patch(patch, *parameters[:, here])
    return result


def patches_named(boundary: Boundary, name: str) -> list[int]:
    """Indices of the patches of a name; ``SelectionError`` if there are none."""
    chosen = [i for i, p in enumerate(boundary.patches) if p.name == name]
    if not chosen:
        there = ", ".join(f"'{n}'" for n in boundary.names)
        raise SelectionError(f"no face is named '{name}'; the names are {there}")
    return chosen


def check_names(
    boundary: Boundary, conditions: Mapping[str, object], kinds: tuple[type, ...]
) -> None:
    """Refuse, by ``ConditionError``, conditions that do not match the faces one to one."""
    for index, patch in enumerate(boundary.patches):
        if not patch.name:
            raise ConditionError(
                f"{boundary.label(index)} has no name; give it one with boundary.named(...)"
            )
    for name, condition in conditions.items():
        if not isinstance(condition, kinds):
            known = ", ".join(k.__name__ + "(...)" for k in kinds)
            raise ConditionError(f"'{name}' has {condition!r} for a condition; give one of {known}")
        if name not in boundary.names:
            there = ", ".join(f"'{n}'" for n in boundary.names)
            raise ConditionError(f"a condition is given for '{name}'; the faces' names are {there}")
    for index, patch in enumerate(boundary.patches):
        if patch.name not in conditions:
            raise ConditionError(
                f"{boundary.label(index)} has no condition; give one for '{patch.name}'"
            )
