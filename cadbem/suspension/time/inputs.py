"""Checks of what a simulation is given."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from cadbem.checks import instance, offers, positive
from cadbem.errors import ConditionError, InputError
from cadbem.operators.far.equivalent import FarField
from cadbem.suspension.interface.mesh import RelaxMesh
from cadbem.suspension.interface.points import AdaptivePoints
from cadbem.suspension.interface.volume import CorrectVolume
from cadbem.suspension.surroundings.free_flow import FreeFlow
from cadbem.units import check

MOST_STATES = 1e6


def check_parts(simulation: Any) -> None:
    """Raises ``InputError`` for a part of a ``Simulation`` that is none, ``ConditionError`` for
    bodies in another dimension than the flow."""
    parts, chosen = simulation, simulation.choices
    offers("flow", parts.flow, ("at", "nearest", "viscosity"), "FreeFlow(...) or ChannelFlow(...)")
    offers("stepper", chosen.stepper, ("attempt", "choose"), "Adaptive(...) or Euler(step)")
    offers("contact", chosen.contact, ("reason", "pressure", "reach"), "StopAtGap() or Repel(...)")
    offers("motion", parts.motion, ("__call__",), "affine_velocity, or another motion of points")
    offers("rule", parts.rule, ("suited",), "PolarRule(tolerance)")
    instance("volume", parts.volume, CorrectVolume | None, "CorrectVolume() or None")
    instance("mesh", parts.mesh, RelaxMesh | None, "RelaxMesh() or None")
    instance("far", parts.far, FarField | None, "FarField(tolerance) or None")
    instance("points", chosen.points, AdaptivePoints | None, "AdaptivePoints(accuracy) or None")
    bodies = parts.bodies if isinstance(parts.bodies, Sequence) else (parts.bodies,)
    if not bodies:
        raise InputError("bodies is empty; give at least one droplet or particle")
    for body in bodies:
        offers("bodies", body, ("placed", "coordinates", "dimension"), "droplets or particles")
        _check_dimension(parts.flow, body.dimension)


def _check_dimension(flow: Any, dimension: int) -> None:
    channel = None if isinstance(flow, FreeFlow) else getattr(flow, "problem", None)
    rates = getattr(flow.background, "rates", None) if isinstance(flow, FreeFlow) else None
    own = channel.boundary.dimension if channel else None if rates is None else len(rates)
    if own not in (None, dimension):
        raise ConditionError(
            f"a body is in {dimension}D and the flow in {own}D; give both the same dimension, such "
            f"as shear(dimension={dimension})"
        )


def check_times(end: float, every: float | None) -> None:
    """Raises ``InputError`` or ``UnitsError`` for times of a run that are none."""
    check("end and every", (end, every), "time")
    positive("end", end)
    if every is not None and end / positive("every", every) > MOST_STATES:
        raise InputError(f"every is {every}; give more than a millionth of the end, {end}")
