"""Elements of rigid particles that make their resistance as accurate as is asked."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache

from cadbem.boundary import Boundary
from cadbem.problems.conditions import Condition, RigidMotion
from cadbem.problems.stokes import StokesProblem
from cadbem.suspension.bodies.body import Body
from cadbem.suspension.bodies.particle import RigidParticle


def accurate_body(body: Body, accuracy: float) -> Body:
    """A particle on elements that make forces and the flow around it as accurate, alone in
    unbounded fluid; in a plane, where there is no such flow, on those that it has.  A droplet as it
    is."""
    if not isinstance(body, RigidParticle):
        return body
    return replace(body, shape=_accurate_shape(body.shape, accuracy))


@lru_cache(maxsize=64)
def _accurate_shape(shape: Boundary, accuracy: float) -> Boundary:
    if shape.dimension == 2:
        parts = [replace(p, surface=s) for p in shape.patches for s in p.surface.bezier_pieces()]
        return replace(shape, patches=tuple(parts))
    plain = [replace(p, surface=p.surface.without_knots()) for p in shape.patches]
    ends = shape.bounds()
    half = 0.5 * float((ends[1] - ends[0]).max())
    # a motion along and about all axes: every part of the resistance counts
    motion = RigidMotion((1.0,) * 3, (1.0 / half,) * 3, tuple(ends.mean(axis=0)))
    named = replace(shape, patches=tuple(replace(p, name="particle") for p in plain))
    conditions: dict[str, Condition] = {"particle": motion}
    return StokesProblem(named, 1.0, conditions).solve(accuracy).problem.boundary
