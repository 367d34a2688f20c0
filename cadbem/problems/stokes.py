"""Stokes flow through a channel: the problem, its linear system, its solution."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from cadbem.boundary import Boundary
from cadbem.errors import ConditionError
from cadbem.kernels.stokes_3d import STOKES_3D
from cadbem.operators.layers import Layers, assemble_layers, collocation_targets
from cadbem.operators.solve import factorise
from cadbem.problems.conditions import (
    Condition,
    Inflow,
    NoSlip,
    Pressure,
    Split,
    Traction,
    Velocity,
    split,
)
from cadbem.problems.profiles import Port, port
from cadbem.problems.solution import StokesSolution
from cadbem.quadrature.options import Quadrature
from cadbem.space import Field, Space, discontinuous_space
from cadbem.spline.basis import Array

FREE_TERM = 4 * np.pi  # of a smooth boundary point


@dataclass(frozen=True, eq=False)
class StokesProblem:
    """Slow viscous flow in a ``boundary`` of degree-elevated, refined patches.

    ``viscosity`` in pressure × time, in whatever consistent units; ``conditions`` one a name of
    the boundary.  Raises ``ConditionError`` for a face without a condition, a condition without
    a face, data that drive no flow, data that leave the pressure open, a viscosity that is not
    positive.
    """

    boundary: Boundary
    viscosity: float
    conditions: Mapping[str, Condition]
    quadrature: Quadrature = field(default_factory=Quadrature)

    def __post_init__(self) -> None:
        if not self.viscosity > 0:
            raise ConditionError(f"viscosity is {self.viscosity}; it must be positive")
        _check_names(self.boundary, self.conditions)
        _check_data(self.boundary, self.conditions)

    @cached_property
    def space(self) -> Space:
        """Unknowns and collocation points."""
        return discontinuous_space(self.boundary)

    @cached_property
    def openings(self) -> dict[str, Port]:
        """The flat openings, by name, of inflow and pressure conditions."""
        return {
            name: port(name, [p for p in self.boundary.patches if p.name == name])
            for name, condition in self.conditions.items()
            if isinstance(condition, Inflow | Pressure)
        }

    @cached_property
    def layers(self) -> Layers:
        """Both layers at the collocation points."""
        targets = collocation_targets(self.space)
        return assemble_layers(STOKES_3D, self.space, targets, self.quadrature)

    def solve(self) -> StokesSolution:
        """Velocity and traction on the boundary, whence everything else follows.

        Solves 4π u + (1/μ) S f - D u = 0 at the collocation points, n into the fluid.
        """
        splits = [
            split(self.conditions[p.name], self.openings.get(p.name))
            for p in self.boundary.patches
        ]
        velocity, traction = self._known(splits)
        right = FREE_TERM * self.space.values(velocity)
        right -= self.layers.apply(-traction / self.viscosity, velocity)
        unknown = factorise(self.layers, FREE_TERM, *self._mixings(splits)).solve(right)
        for i, s in enumerate(splits):
            part = self.space.functions(i)
            velocity[:, part] += s.velocity_mixing @ unknown[:, part]
            traction[:, part] += s.traction_mixing @ unknown[:, part]
        fields = Field(self.space, velocity), Field(self.space, traction)
        return StokesSolution(self, *fields)

    def _mixings(self, splits: list[Split]) -> tuple[list[Array], list[Array]]:
        single = [-s.traction_mixing / self.viscosity for s in splits]
        return single, [s.velocity_mixing for s in splits]

    def _known(self, splits: list[Split]) -> tuple[Array, Array]:
        """Coefficients of the known velocity and traction, inflows scaled to their flow rate."""
        shape = (3, self.space.count)
        velocity, traction = np.zeros(shape), np.zeros(shape)
        for i, s in enumerate(splits):
            part = self.space.functions(i)
            if s.velocity is not None:
                velocity[:, part] = self.space.project(i, s.velocity)
            if s.traction is not None:
                traction[:, part] = self.space.project(i, s.traction)
        for name, condition in self.conditions.items():
            if isinstance(condition, Inflow):
                opening = self.openings[name]
                parts = [i for i, p in enumerate(self.boundary.patches) if p.name == name]
                flow = sum(Field(self.space, velocity).integral(i) for i in parts)
                scale = condition.mean(opening) * opening.area / (flow @ opening.normal)
                for i in parts:
                    velocity[:, self.space.functions(i)] *= scale
        return velocity, traction


def _check_names(boundary: Boundary, conditions: Mapping[str, Condition]) -> None:
    for index, patch in enumerate(boundary.patches):
        if not patch.name:
            raise ConditionError(
                f"{boundary.label(index)} has no name; give it one with boundary.named(...)"
            )
    known = (NoSlip, Velocity, Inflow, Pressure, Traction)
    for name, condition in conditions.items():
        if not isinstance(condition, known):
            kinds = ", ".join(k.__name__ + "(...)" for k in known)
            raise ConditionError(f"'{name}' has {condition!r} for a condition; give one of {kinds}")
        if name not in boundary.names:
            there = ", ".join(f"'{n}'" for n in boundary.names)
            raise ConditionError(f"a condition is given for '{name}'; the faces' names are {there}")
    for index, patch in enumerate(boundary.patches):
        if patch.name not in conditions:
            raise ConditionError(
                f"{boundary.label(index)} has no condition; give one for '{patch.name}'"
            )


def _check_data(boundary: Boundary, conditions: Mapping[str, Condition]) -> None:
    values = list(conditions.values())
    names = ", ".join(f"'{n}'" for n in boundary.names)
    pressures = {c.value for c in values if isinstance(c, Pressure)}
    drives = any(isinstance(c, Inflow | Velocity) for c in values) or len(pressures) > 1
    drives |= any(isinstance(c, Traction) and np.any(c.value) for c in values)
    if not drives:
        raise ConditionError(
            f"there is no inlet: nothing drives the flow; give one of {names} an Inflow, "
            "or two of them different Pressures"
        )
    if not any(isinstance(c, Pressure | Traction) for c in values):
        raise ConditionError(
            f"there is no outlet, so the pressure is open; give one of {names} a Pressure"
        )
