"""Boundary conditions of Stokes flow, as values.

A condition splits the velocity and the traction on a patch into known parts and an unknown with
as many components (see ``mixed``).  Vectors have dim = 2 or 3 components, like the boundary.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from cadbem.checks import finite, turning, values_at, vector
from cadbem.errors import ConditionError
from cadbem.problems.mixed import Given, Split
from cadbem.problems.profiles import Port
from cadbem.spline.basis import Array
from cadbem.units import check

Vector = Sequence[float] | Array


@dataclass(frozen=True)
class NoSlip:
    """Zero velocity: a wall at rest."""


@dataclass(frozen=True)
class Velocity:
    """Velocity given as a vector (dim,), or as a function of positions (dim, N) -> (dim, N)."""

    value: Vector | Callable[[Array], Array]


@dataclass(frozen=True)
class Inflow:
    """Fully developed flow through a flat rectangular or round opening, along its normal.

    In a plane it is the flow between parallel plates.  Give either ``mean_velocity``
    (length/time) or ``flow_rate`` (volume/time; area/time in a plane), positive into the fluid.
    Raises ``ConditionError`` when both or none are given, ``UnitsError`` for other quantities.
    """

    mean_velocity: float | None = None
    flow_rate: float | None = None

    def __post_init__(self) -> None:
        if (self.mean_velocity is None) == (self.flow_rate is None):
            raise ConditionError("Inflow takes either mean_velocity or flow_rate, not both or none")
        check("mean_velocity", self.mean_velocity, "velocity")
        check("flow_rate", self.flow_rate, "flow_rate", "plane_flow_rate")
        for name, value in vars(self).items():
            if value is not None:
                finite(f"Inflow's {name}", value)

    def mean(self, opening: Port) -> float:
        """Mean velocity through an opening."""
        if self.mean_velocity is not None:
            return self.mean_velocity
        assert self.flow_rate is not None
        return self.flow_rate / opening.area


@dataclass(frozen=True)
class Pressure:
    """Pressure and zero tangential velocity on a flat opening: flow leaves straight.

    This, not zero traction, is what a developed channel flow fulfils.  Raises ``UnitsError`` for a
    quantity that is not a pressure.
    """

    value: float = 0.0

    def __post_init__(self) -> None:
        check("Pressure", self.value, "pressure")
        finite("Pressure", self.value)


@dataclass(frozen=True)
class Traction:
    """Traction f = σ·n as a vector (dim,), or as a function of positions (dim, N) -> (dim, N),
    n into the fluid; 0: a free jet's opening."""

    value: Vector | float | Callable[[Array], Array] = 0.0


@dataclass(frozen=True)
class RigidMotion:
    """A body that moves without deforming: u = velocity + angular_velocity × (x - centre).

    All three are vectors (3,), or 0; the angular velocity is in radians per time.  In a plane it is
    one number, counter-clockwise, the others are vectors (2,).
    """

    velocity: Vector | float = 0.0
    angular_velocity: Vector | float = 0.0
    centre: Vector | float = 0.0

    def at(self, position: Array) -> Array:
        """Velocity (dim, N) at positions (dim, N)."""
        dimension = len(position)
        shift = vector("velocity", self.velocity, dimension)[:, None]
        turn = turning("angular_velocity", self.angular_velocity, dimension).reshape(-1, 1)
        arm = position - vector("centre", self.centre, dimension)[:, None]
        if dimension == 2:
            return shift + turn * np.stack([-arm[1], arm[0]])
        return shift + np.cross(np.broadcast_to(turn, arm.shape), arm, axis=0)


OPEN = Inflow | Pressure | Traction  # conditions through which fluid may pass
Condition = NoSlip | Velocity | Inflow | Pressure | Traction | RigidMotion


@dataclass(frozen=True)
class Background:
    """Flow far from all bodies in unbounded fluid: a Stokes flow without singularities.

    ``velocity`` as a vector (dim,) or a function of positions (dim, N) -> (dim, N); ``pressure``
    as a number or a function (dim, N) -> (N,).
    """

    velocity: Vector | float | Callable[[Array], Array] = 0.0
    pressure: float | Callable[[Array], Array] = 0.0

    @property
    def is_at_rest(self) -> bool:
        """Whether both are the number or vector 0."""
        return not any(callable(v) or np.any(v) for v in (self.velocity, self.pressure))

    def velocity_at(self, position: Array) -> Array:
        """Velocity (dim, N) at positions (dim, N)."""
        return _vectors("Background's velocity", self.velocity, position)

    def pressure_at(self, position: Array) -> Array:
        """Pressure (N,) at positions (dim, N)."""
        name, count = "Background's pressure", position.shape[1]
        if callable(self.pressure):
            return values_at(name, self.pressure(position), (count,))
        return np.full(count, finite(name, self.pressure))


def split(condition: Condition, opening: Port | None, dimension: int) -> Split:
    """The known and unknown parts of a condition on a patch; ``opening`` for those that need a flat
    one."""
    none, all_ = np.zeros((dimension, dimension)), np.eye(dimension)
    match condition:
        case NoSlip():
            return Split(None, None, none, all_)
        case Velocity(value):
            return Split(_given("Velocity", value), None, none, all_)
        case RigidMotion():
            return Split(_given("RigidMotion", condition.at), None, none, all_)
        case Traction(value):
            return Split(None, _given("Traction", value), all_, none)
        case Inflow():
            assert opening is not None
            return Split(_inflow(condition, opening), None, none, all_)
        case Pressure(value):
            assert opening is not None
            normal = opening.normal[:, None]
            along = normal @ normal.T
            return Split(None, _given("Pressure", -value * opening.normal), along, all_ - along)


def check_vectors(condition: Condition | Background, dimension: int) -> None:
    """Raises ``InputError`` for vectors that are not finite or have other than dim components."""
    middle = np.zeros((dimension, 1))
    match condition:
        case Velocity(value) | Traction(value) if not callable(value):
            _vectors(type(condition).__name__, value, middle)
        case RigidMotion():
            condition.at(middle)
        case Background(velocity, pressure):
            if not callable(velocity):
                condition.velocity_at(middle)
            if not callable(pressure):
                condition.pressure_at(middle)


def _vectors(name: str, value: Vector | float | Callable[[Array], Array], position: Array) -> Array:
    """A vector, or what a function returns, at positions (dim, N)."""
    if callable(value):
        return values_at(name, value(position), position.shape)
    return np.broadcast_to(vector(name, value, len(position))[:, None], position.shape)


def _given(name: str, value: Vector | float | Callable[[Array], Array]) -> Given:
    return lambda points: _vectors(name, value, points.position)


def _inflow(condition: Inflow, opening: Port) -> Given:
    profile, mean = opening.profile, condition.mean(opening)
    return lambda points: mean * profile(points.position) * opening.normal[:, None]
