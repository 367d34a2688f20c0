"""The regions of fluid in a boundary, and the check that given velocities conserve volume."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from cadbem.boundary import Boundary
from cadbem.errors import ConditionError
from cadbem.points import join
from cadbem.problems.bodies import Surface
from cadbem.problems.conditions import Condition, Inflow, Pressure, Traction, split
from cadbem.problems.enclosure import inside
from cadbem.problems.profiles import Port
from cadbem.spline.basis import Array

LEAK = 1e-6  # share of ∮ |u| dS that may pile up: errors of CAD surfaces, not of data
ORDER = 16  # Gauss points an element and direction, for given velocities


@dataclass(frozen=True, eq=False)
class Region:
    """Fluid in a ``container``, a closed surface, around ``bodies``."""

    container: Surface
    bodies: tuple[Surface, ...]

    @property
    def patches(self) -> tuple[int, ...]:
        """All patches (indices) of its boundary."""
        return sum((s.patches for s in (self.container, *self.bodies)), ())

    def openings(self, kinds: Sequence[Condition]) -> list[int]:
        """Patches of the container where the velocity is not given, or not all of it."""
        return [i for i in self.container.patches if isinstance(kinds[i], Pressure | Traction)]


def regions(boundary: Boundary, surfaces: Sequence[Surface]) -> list[Region]:
    """One region a container; a body belongs to the smallest container around it."""
    containers = sorted((s for s in surfaces if s.holds_fluid), key=lambda s: s.volume)
    shells = [Boundary(tuple(boundary.patches[i] for i in c.patches)) for c in containers]
    bodies: list[list[Surface]] = [[] for _ in containers]
    for body in (s for s in surfaces if s.is_body):
        point = boundary.patches[body.patches[0]].middle().position
        around = (k for k, shell in enumerate(shells) if inside(shell, point)[0])
        owner = next(around, None)
        if owner is not None:
            bodies[owner].append(body)
    return [Region(c, tuple(b)) for c, b in zip(containers, bodies, strict=True)]


def check_balance(
    boundary: Boundary,
    conditions: Mapping[str, Condition],
    region: Region,
    ports: Mapping[str, Port],
) -> None:
    """Refuse, by ``ConditionError``, velocities given all around a region that let fluid pile up,
    and a body with a traction in a container whose velocity is given."""
    remedy = " or ".join(f"'{n}'" for n in _names(boundary, region.container.patches))
    names = _names(boundary, region.patches)
    for name in names:
        if isinstance(conditions[name], Pressure | Traction):
            raise ConditionError(
                f"'{name}' is a body with a Traction in a container whose velocity is given all "
                f"over; give {remedy} a Pressure or Traction"
            )
    flows = [_flow(boundary, region, name, conditions[name], ports.get(name)) for name in names]
    flow, speed = np.concatenate(flows, axis=1)
    into, out = flow.clip(min=0).sum(), -flow.clip(max=0).sum()
    excess = abs(into - out)
    if excess > LEAK * speed.sum():
        more = "in than out" if into > out else "out than in"
        raise ConditionError(
            f"the given velocities let {excess:.3g} more {more} "
            f"({100 * excess / max(into, out):.3g} %); balance them, or give {remedy} a Pressure"
        )


def _names(boundary: Boundary, patches: Sequence[int]) -> list[str]:
    return sorted({boundary.patches[i].name for i in patches})


def _flow(
    boundary: Boundary, region: Region, name: str, condition: Condition, port: Port | None
) -> Array:
    """Parts of ∫ u·n dS and ∫ |u| dS over the patches of a name: (2, N)."""
    if isinstance(condition, Inflow):
        assert port is not None
        rate = condition.mean(port) * port.area
        return np.array([[rate], [abs(rate)]])
    given = split(condition, port, boundary.dimension).value
    if given is None:
        return np.zeros((2, 1))
    parts = [boundary.patches[i].quadrature(ORDER) for i in region.patches
             if boundary.patches[i].name == name]  # fmt: skip
    points, weights = join([p for p, _ in parts]), np.concatenate([w for _, w in parts])
    velocity = given(points)
    normal = (velocity * points.normal).sum(axis=0)
    return np.stack([normal, np.linalg.norm(velocity, axis=0)]) * weights
