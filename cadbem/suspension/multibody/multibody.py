"""The equations of several bodies, droplets and rigid particles, that interact with each other and
with walls.

Each body has an equation A w = b + L[u∞] (see ``body``), where u∞ is the flow without bodies, the
velocity that the other bodies induce, and the velocity that walls reflect of all.  The bodies whose
induced velocity depends on w are coupled and solved at once, by GMRES; the w of the others, such as
droplets with λ = 1, then follows explicitly.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from scipy.sparse.linalg import LinearOperator, gmres

from cadbem.errors import ConditionError
from cadbem.kernels.stokes_sums import stokes_sums
from cadbem.operators.far.equivalent import FarField, ball_around
from cadbem.operators.far.interactions import FarInteractions, TargetCluster, target_clusters
from cadbem.operators.parallel import in_shares
from cadbem.spline.basis import Array
from cadbem.suspension.bodies.body import (
    NOTHING,
    ContactPressure,
    Densities,
    Equation,
    NearField,
    Placed,
)
from cadbem.suspension.bodies.droplet import PlacedDroplet
from cadbem.suspension.interface.laws import Jump
from cadbem.suspension.multibody.contact import Contact, StopAtGap, contact_pressure
from cadbem.suspension.multibody.neighbours import Neighbours
from cadbem.suspension.surroundings.surroundings import Incident, Surroundings

SOLVER_TOLERANCE = 1e-8
ABOVE_WALLS = 10.0  # times the error of the reflected velocity: no iteration comes below it
NO_CONTACT = StopAtGap()
FAR = FarField()

Numbers = tuple[int, ...]


def velocity_responses(
    surroundings: Surroundings,
    bodies: Sequence[Placed],
    contact: Contact = NO_CONTACT,
    guess: Sequence[Array] = (),
    far: FarField | None = FAR,
) -> list[Any]:
    """The response of each of several bodies, with the pressure of a ``contact`` rule.

    A ``guess`` of all unknowns, such as those of the time before, saves iterations.  Without
    ``far`` all pairs are summed directly, for comparison.

    Raises ConditionError when the iteration fails, or when two laws have an unknown of their own.
    """
    system = MultibodySystem(surroundings, tuple(bodies), contact, tuple(guess), far)
    for i, body in enumerate(bodies):
        if isinstance(body, PlacedDroplet) and body.jump is None:
            return _close(system, i, body)
    return system.solve({})


def _close(system: MultibodySystem, number: int, body: PlacedDroplet) -> list[Any]:
    """Responses when one droplet's law has an unknown of its own."""

    def velocity(jump: Jump) -> Array:
        return system.solve({number: jump})[number].velocity

    _, jump = body.body.interface.close(body.layers, velocity)
    return system.solve({number: jump})


@dataclass(frozen=True, eq=False)
class InducedField:
    """The velocity that ``bodies`` induce at the points of an ``interactions``."""

    bodies: Sequence[Placed]
    interactions: FarInteractions

    def velocity(self, densities: Sequence[Densities], sources: Sequence[int]) -> Array:
        """Velocity (dim, M) that some of them, the ``sources``, induce: Σ (S[q] + D[u]) / 2h."""
        active = [j for j in sources if densities[j] is not NOTHING]
        total = self.interactions.apply(active, lambda j: self.bodies[j].sources(densities[j]))
        total /= 2 * stokes_sums(len(total)).free_term
        close = in_shares(lambda j: self._near_fields[j].velocity(densities[j]), active)
        for j, part in zip(active, close, strict=True):
            total[:, self.interactions.near(j)] += part
        return total

    @cached_property
    def _near_fields(self) -> list[NearField]:
        """The evaluation of each body's layers at the points near it."""
        points, near = self.interactions.points, self.interactions.near
        return [body.near_field(points[:, near(j)]) for j, body in enumerate(self.bodies)]


@dataclass(frozen=True, eq=False)
class MultibodySystem:
    """Bodies at one moment, with all that their interactions need and that is evaluated once."""

    surroundings: Surroundings
    bodies: tuple[Placed, ...]
    contact: Contact = NO_CONTACT
    guess: tuple[Array, ...] = ()
    far: FarField | None = FAR
    _fields: dict[Numbers, InducedField] = field(default_factory=dict)
    _incidents: dict[Numbers, Incident] = field(default_factory=dict)

    def solve(self, jumps: dict[int, Jump]) -> list[Any]:
        """Responses, with given jumps of some of the bodies."""
        viscosity, deflated = self.surroundings.viscosity, self.surroundings.deflated
        equations = [
            b.equation(viscosity, deflated, self._contact_pressure(i), jumps.get(i))
            for i, b in enumerate(self.bodies)
        ]
        return _Equations(self, equations).responses()

    def _contact_pressure(self, number: int) -> ContactPressure | None:
        return contact_pressure(self.surroundings, self._neighbours, number, self.contact)

    @cached_property
    def _neighbours(self) -> Neighbours:
        return Neighbours(self.bodies)

    def velocity_at_walls(self, densities: Sequence[Densities]) -> Array:
        """The velocity (dim, W) that bodies induce at the walls' points."""
        return self.induced(densities, tuple(range(len(self.bodies))), ())[0]

    def induced(
        self, densities: Sequence[Densities], sources: Numbers, receivers: Numbers
    ) -> tuple[Array, list[Array]]:
        """The velocity that ``sources`` induce at the walls (dim, W), and that which others among
        them induce at the targets of each of the ``receivers`` (dim, N)."""
        if receivers not in self._fields:
            self._fields[receivers] = self._field(receivers)
        velocity = self._fields[receivers].velocity(densities, sources)
        targets = [self.bodies[i].targets for i in receivers]
        walls, *others = _split(velocity, [self._walls, *targets])
        return walls, others

    def induced_at(self, points: Array, densities: Sequence[Densities]) -> Array:
        """The velocity that all bodies induce at points (dim, M) off their surfaces."""
        induced = InducedField(self.bodies, self._interactions(points, target_clusters(points)))
        return induced.velocity(densities, range(len(self.bodies)))

    @cached_property
    def _walls(self) -> Array:
        """Points (dim, W) of the walls."""
        walls = self.surroundings.walls
        return self.bodies[0].targets[:, :0] if walls is None else walls

    def _field(self, receivers: Numbers) -> InducedField:
        """The velocity of all bodies at the walls and at some bodies' targets."""
        clusters, parts = target_clusters(self._walls), [self._walls]
        for i in receivers:
            first = sum(part.shape[1] for part in parts)
            parts.append(self.bodies[i].targets)
            clusters.append(TargetCluster(first + np.arange(parts[-1].shape[1]), i))
        return InducedField(
            self.bodies, self._interactions(np.concatenate(parts, axis=1), clusters)
        )

    def _interactions(self, points: Array, clusters: list[TargetCluster]) -> FarInteractions:
        balls = [ball_around(b.samples) for b in self.bodies]
        expansions = self.far.expansions(len(points)) if self.far else ()
        return FarInteractions(expansions, balls, points, clusters)

    def incident(self, receivers: Numbers) -> Incident:
        """The surroundings at some bodies' targets."""
        if receivers not in self._incidents:
            points = np.concatenate([self.bodies[i].targets for i in receivers], axis=1)
            self._incidents[receivers] = self.surroundings.at(points)
        return self._incidents[receivers]


@dataclass(frozen=True, eq=False)
class _Equations:
    """The equations of all bodies of a system."""

    system: MultibodySystem
    equations: Sequence[Equation]

    @property
    def _all(self) -> Numbers:
        return tuple(range(len(self.equations)))

    @cached_property
    def _coupled(self) -> Numbers:
        """Bodies whose fields depend on their unknowns."""
        return tuple(i for i in self._all if self.equations[i].couples)

    @property
    def _explicit(self) -> Numbers:
        """Bodies whose unknowns follow explicitly from those of the coupled ones."""
        return tuple(i for i in self._all if i not in self._coupled)

    def responses(self) -> list[Any]:
        """The responses of all bodies, from the solution of the coupled system."""
        unknowns, iterations = self._rights(), 0
        if self._coupled:
            found, iterations = self._iterate([unknowns[i] for i in self._coupled])
            for i, w in zip(self._coupled, found, strict=True):
                unknowns[i] = w
            incident = self._incident(unknowns, self._explicit)
            for i, velocity in zip(self._explicit, incident, strict=True):
                unknowns[i] = unknowns[i] + self.equations[i].incident_term(velocity)
        pairs = zip(self.equations, unknowns, strict=True)
        return [e.response(w, iterations) for e, w in pairs]

    def _rights(self) -> list[Array]:
        """b + L[u∞] of each equation, for the flow without bodies and the velocity that the fixed
        densities induce."""
        fixed = [e.fixed_densities for e in self.equations]
        sources = tuple(i for i in self._all if fixed[i] is not NOTHING)
        walls, induced = self.system.induced(fixed, sources, self._all)
        rights = [e.right_side for e in self.equations]
        for group in filter(None, (self._coupled, self._explicit)):
            incident = self.system.incident(group).velocity(walls if sources else None)
            for i, part in zip(group, self._split(incident, group), strict=True):
                rights[i] = rights[i] + self.equations[i].incident_term(part + induced[i])
        return rights

    def _incident(self, unknowns: Sequence[Array], receivers: Numbers) -> list[Array]:
        """Incident velocities (dim, N) at receivers' targets that the unknowns of coupled bodies
        cause, directly and by reflection from walls."""
        if not receivers:
            return []
        densities = [NOTHING] * len(self.equations)
        for i in self._coupled:
            densities[i] = self.equations[i].densities(unknowns[i])
        walls, induced = self.system.induced(densities, self._coupled, receivers)
        reflected = self.system.incident(receivers).reflected(walls)
        return [a + b for a, b in zip(induced, self._split(reflected, receivers), strict=True)]

    def _split(self, values: Array, receivers: Numbers) -> list[Array]:
        """The parts (dim, N) that belong to each receiver's targets."""
        return _split(values, [self.system.bodies[i].targets for i in receivers])

    def _apply(self, values: Sequence[Array]) -> list[Array]:
        """Left sides of the coupled equations for w (dim, N) of each."""
        unknowns: list[Array] = [np.empty(0)] * len(self.equations)
        for i, w in zip(self._coupled, values, strict=True):
            unknowns[i] = np.ascontiguousarray(w)
        incident = self._incident(unknowns, self._coupled)
        active = [self.equations[i] for i in self._coupled]
        own = in_shares(lambda pair: pair[0].apply(pair[1]), zip(active, values, strict=True))
        return [w - e.incident_term(v) for e, w, v in zip(active, own, incident, strict=True)]

    def _iterate(self, rights: Sequence[Array]) -> tuple[list[Array], int]:
        residuals: list[float] = []
        dim = len(rights[0])

        def apply(flat: Array) -> Array:
            values = _split(flat.reshape(dim, -1), rights)
            return np.concatenate(self._apply(values), axis=1).ravel()

        right, start = np.concatenate(rights, axis=1).ravel(), None
        if self.system.guess:
            parts = [self.system.guess[i] for i in self._coupled]
            start = np.concatenate(parts, axis=1).ravel()
        tolerance = max(SOLVER_TOLERANCE, ABOVE_WALLS * self.system.surroundings.accuracy)
        operator = LinearOperator((right.size, right.size), apply, dtype=float)
        solution, failed = gmres(
            operator, right, x0=right if start is None else start, rtol=tolerance,
            restart=60, maxiter=5, callback=residuals.append, callback_type="pr_norm",
        )  # fmt: skip
        if failed:
            raise ConditionError(
                f"the velocities of {len(rights)} bodies did not converge: residual "
                f"{residuals[-1]:.1e} after {len(residuals)} iterations; some may touch"
            )
        return _split(solution.reshape(dim, -1), rights), len(residuals)


def _split(values: Array, like: Sequence[Array]) -> list[Array]:
    """Parts of an array (dim, ·) with as many columns as those of a list."""
    return np.split(values, np.cumsum([a.shape[1] for a in like])[:-1], axis=1)
