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
from cadbem.problems.conditions import (
    Condition,
    Inflow,
    NoSlip,
    Pressure,
    Traction,
    Velocity,
    split,
)
from cadbem.problems.mixed import MixedSystem, check_names, patches_named
from cadbem.problems.profiles import Port, port
from cadbem.problems.solution import StokesSolution
from cadbem.quadrature.options import Quadrature
from cadbem.space import Field, Space, discontinuous_space
from cadbem.spline.basis import Array

FREE_TERM = 4 * np.pi  # of a smooth boundary point
KINDS = (NoSlip, Velocity, Inflow, Pressure, Traction)


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
        check_names(self.boundary, self.conditions, KINDS)
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
        system = MixedSystem(self.layers, FREE_TERM, -1 / self.viscosity, splits)
        known = self._known(system)
        velocity, traction = system.complete(*known, system.unknowns(*known))
        return StokesSolution(self, Field(self.space, velocity), Field(self.space, traction))

    def _known(self, system: MixedSystem) -> tuple[Array, Array]:
        """Coefficients of the known velocity and traction, inflows scaled to their flow rate."""
        velocity, traction = system.known()
        for name, condition in self.conditions.items():
            if isinstance(condition, Inflow):
                opening = self.openings[name]
                parts = patches_named(self.boundary, name)
                flow = sum(Field(self.space, velocity).integral(i) for i in parts)
                scale = condition.mean(opening) * opening.area / (flow @ opening.normal)
                for i in parts:
                    velocity[:, self.space.functions(i)] *= scale
        return velocity, traction


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
