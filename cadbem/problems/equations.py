"""The equations of Stokes flow in a boundary: given data, unknowns, and the linear system."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from cadbem.boundary import Boundary
from cadbem.checks import instance, positive
from cadbem.errors import ConditionError
from cadbem.kernels.stokes import stokes_kernels
from cadbem.operators.compressed.layers import own_layers
from cadbem.operators.compressed.storage import Storage
from cadbem.operators.interactions import Targets
from cadbem.operators.layers import Layers, OwnLayers, assemble_layers
from cadbem.problems.bodies import Surface, check_closed, closed_surfaces, point_inside
from cadbem.problems.conditions import (
    Background,
    Condition,
    Inflow,
    NoSlip,
    Pressure,
    RigidMotion,
    Traction,
    Velocity,
    check_vectors,
    split,
)
from cadbem.problems.constraints import (
    Constraints,
    joined,
    mean_normal_traction,
    net_flux,
    normals,
    pressures,
)
from cadbem.problems.mixed import MixedSystem, Split, check_names, patches_named
from cadbem.problems.profiles import Port, port
from cadbem.problems.regions import Region, check_balance, regions
from cadbem.quadrature import Quadrature, Rules
from cadbem.space import Field, Space, discontinuous_space
from cadbem.spline.basis import Array
from cadbem.units import check, check_same

GIVEN_VELOCITY = (NoSlip, Velocity, RigidMotion, Inflow)
PLATES = "add the faces that are missing, or say open=True if thin plates in fluid are meant"
KINDS = (*GIVEN_VELOCITY, Pressure, Traction)


@dataclass(frozen=True, eq=False)
class StokesEquations:
    """The data of a ``StokesProblem``, whose documentation says what they mean, and the linear
    system that follows from them."""

    boundary: Boundary
    viscosity: float
    conditions: Mapping[str, Condition]
    quadrature: Rules = field(default_factory=Quadrature)
    background: Background = Background()
    storage: Storage | None = None
    open: bool = False

    def __post_init__(self) -> None:
        check("viscosity", self.viscosity, "viscosity")
        positive("viscosity", self.viscosity)
        instance("boundary", self.boundary, Boundary, "a Boundary, as from read_cad")
        instance("conditions", self.conditions, Mapping, "a condition for each name: {name: ...}")
        instance("background", self.background, Background, "a Background")
        instance("quadrature", self.quadrature, Rules, "Quadrature(tolerance)")
        check_names(self.boundary, self.conditions, KINDS)
        for condition in (*self.conditions.values(), self.background):
            check_vectors(condition, self.boundary.dimension)
        data = [(f"'{n}'", v) for n, c in self.conditions.items() for v in vars(c).values()]
        check_same(self.boundary.unit, [("viscosity", self.viscosity), *data])
        if not self.open:
            check_closed(self.boundary, self.surfaces, PLATES)
        unbounded = not any(s.holds_fluid for s in self.surfaces)
        _check_data(self.boundary, self.conditions, self.background, unbounded)
        for region in self.regions:
            if not region.openings(self.kinds):
                check_balance(self.boundary, self.conditions, region, self.openings)

    @cached_property
    def space(self) -> Space:
        """Unknowns and collocation points."""
        return discontinuous_space(self.boundary)

    @cached_property
    def surfaces(self) -> list[Surface]:
        """The connected surfaces of the boundary."""
        return closed_surfaces(self.boundary)

    @cached_property
    def regions(self) -> list[Region]:
        """The regions of fluid that the boundary encloses."""
        return regions(self.boundary, self.surfaces)

    @property
    def kinds(self) -> list[Condition]:
        """The condition of each patch."""
        return [self.conditions[p.name] for p in self.boundary.patches]

    @cached_property
    def given_bodies(self) -> list[Surface]:
        """Bodies in the fluid whose velocity is given all over."""
        kinds = self.kinds
        return [
            s
            for s in self.surfaces
            if s.is_body and all(isinstance(kinds[i], GIVEN_VELOCITY) for i in s.patches)
        ]

    @cached_property
    def thin(self) -> NDArray[np.bool_]:
        """Which functions (F,) belong to open surfaces: plates with fluid on both sides.

        The double layers of both sides cancel there, and the traction is that of both together.
        """
        thin = np.zeros(self.space.count, dtype=bool)
        for surface in self.surfaces:
            for i in surface.patches:
                open_ = not (surface.holds_fluid or surface.is_body)
                thin[self.space.functions(i)] = open_
        return thin

    @cached_property
    def openings(self) -> dict[str, Port]:
        """The flat openings, by name, of inflow and pressure conditions."""
        return {
            name: port(name, [p for p in self.boundary.patches if p.name == name])
            for name, condition in self.conditions.items()
            if isinstance(condition, Inflow | Pressure)
        }

    @cached_property
    def layers(self) -> OwnLayers:
        """Both layers at the collocation points."""
        kernel, _ = stokes_kernels(self.boundary.dimension)
        return own_layers(kernel, self.space, self.quadrature, self.storage)

    @cached_property
    def inner_points(self) -> Array:
        """A point inside each of ``given_bodies``: (dim, bodies)."""
        points = [point_inside(self.boundary, body) for body in self.given_bodies]
        return np.ascontiguousarray(np.reshape(points, (-1, self.boundary.dimension)).T)

    @cached_property
    def inner_pressure(self) -> Layers:
        """Both layers' pressures at a point inside each of ``given_bodies``."""
        targets = Targets.free(self.inner_points)
        _, kernel = stokes_kernels(self.boundary.dimension)
        return assemble_layers(kernel, self.space, targets, self.quadrature)

    @cached_property
    def splits(self) -> list[Split]:
        """The given data and the unknowns on each patch."""
        return [
            split(self.conditions[p.name], self.openings.get(p.name), self.boundary.dimension)
            for p in self.boundary.patches
        ]

    @cached_property
    def constraints(self) -> Constraints:
        """The constraints for what the equations leave open, or conserve only approximately.

        Inside each of ``given_bodies`` the pressure of all layers vanishes, to which f = n
        contributes 1; forces and torques do not depend on it, as ∫ n dS = ∫ x × n dS = 0.  In each
        region either the mean of f·n on the container vanishes, or the net flux.
        """
        bodies = [normals(self.space, body.patches) for body in self.given_bodies]
        none = np.empty((0, *self.space.collocation.normal.shape))
        factor = 0.5 / self.layers.kernel.free_term
        inside = np.concatenate([none, *bodies])
        parts = [pressures(self.inner_pressure, self.viscosity, factor, inside)]
        for region in self.regions:
            openings = region.openings(self.kinds)
            if openings:
                room = normals(self.space, openings)
                parts.append(net_flux(self.space, region.patches, room))
            else:
                walls = region.container.patches
                room = normals(self.space, walls)
                parts.append(mean_normal_traction(self.space, walls, room))
        return joined(parts)

    @cached_property
    def system(self) -> MixedSystem:
        """The linear system, which keeps its factors."""
        border = self.constraints.border(self.space, self.splits)
        return MixedSystem(self.layers, -1 / self.viscosity, self.splits, border)

    def known(self) -> tuple[Array, Array]:
        """Coefficients of the known velocity and traction, inflows scaled to their flow rate."""
        velocity, traction = self.system.known()
        for name, condition in self.conditions.items():
            if isinstance(condition, Inflow):
                opening = self.openings[name]
                parts = patches_named(self.boundary, name)
                flow = sum(Field(self.space, velocity).integral(i) for i in parts)
                wanted = condition.mean(opening) * opening.area
                scale = wanted / (flow @ opening.normal) if wanted else 0.0  # 0: a closed inlet
                for i in parts:
                    velocity[:, self.space.functions(i)] *= scale
        return velocity, traction

    def fields(
        self, known: tuple[Array, Array], background: Array | float, values: Array | float
    ) -> tuple[Array, Array, int]:
        """Coefficients of the velocity and the traction, and the iterations that they took.

        ``known`` are the coefficients of given data, ``background`` a velocity (dim, T) at
        collocation points, ``values`` (k,) those of the constraints.
        """
        twice = 2 * self.system.free_term
        plates = np.where(self.thin, known[0], 0.0)
        source = twice * (background - self.space.values(plates))
        constraints = values - self.constraints.of(known[0] - plates, known[1])
        solved = self.system.unknowns(known[0] - plates, known[1], source, constraints)
        return *self.system.complete(*known, solved.unknowns), solved.iterations


def _check_data(
    boundary: Boundary,
    conditions: Mapping[str, Condition],
    background: Background,
    unbounded: bool,
) -> None:
    if unbounded and boundary.dimension == 2:
        raise ConditionError(
            "no closed curve holds the fluid, and plane flow past bodies has no solution far "
            "away; add walls around it, or turn curves so that the fluid is to their right"
        )
    if not background.is_at_rest and not unbounded:
        raise ConditionError(
            "a background flow is given, but walls enclose the fluid; leave it out, or turn the "
            "normals of bodies outwards"
        )
    values = list(conditions.values())
    names = ", ".join(f"'{n}'" for n in boundary.names)
    pressures = {c.value for c in values if isinstance(c, Pressure)}
    moving = Inflow | Velocity | RigidMotion
    drives = not background.is_at_rest or any(isinstance(c, moving) for c in values)
    drives |= len(pressures) > 1
    loads = [c.value for c in values if isinstance(c, Traction)]
    drives |= any(callable(load) or np.any(load) for load in loads)
    if not drives:
        raise ConditionError(
            f"there is no inlet: nothing drives the flow; give one of {names} an Inflow, "
            "or two of them different Pressures"
        )
