"""Droplets together: the velocities of several interfaces in one flow.

Outside itself droplet j makes the velocity

    V_j(x) = (-S_j[Δf_j] / μ + (1 - λ_j) D_j[u_j]) / 2h

(h as in ``interface_equation``).  What droplet i feels as u∞ is the flow without droplets, the
V_j of the others, and what walls make of all V_j.  The equations of all droplets are solved at
once, by GMRES; for λ = 1 nothing is left to solve.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import numpy as np
from scipy.sparse.linalg import LinearOperator, gmres

from cadbem.errors import ConditionError
from cadbem.operators.closed import ClosedLayers
from cadbem.operators.closed_field import off_surface
from cadbem.spline.basis import Array
from cadbem.suspension.droplet import Droplet
from cadbem.suspension.flows import BackgroundFlow
from cadbem.suspension.interface import Jump
from cadbem.suspension.interface_equation import InterfaceEquation

SOLVER_TOLERANCE = 1e-8

Induced = Callable[[Array], Array]


class Surroundings(Protocol):
    """The fluid that droplets are in."""

    @property
    def viscosity(self) -> float:
        """Viscosity of the fluid outside the droplets."""

    @property
    def background(self) -> BackgroundFlow | None:
        """The flow far away, if the fluid is unbounded."""

    @property
    def deflated(self) -> bool:
        """Whether to deflate the equations."""

    def velocity(self, points: Array, induced: Induced) -> Array:
        """Velocity (dim, M) at points (dim, M): the flow without droplets, and what walls add to
        the one that droplets make, ``induced(points)``."""

    def reflected(self, points: Array, induced: Induced) -> Array | float:
        """What walls add alone."""


@dataclass(frozen=True, eq=False)
class Response:
    """An interface's ``velocity``, coefficients (dim, *shape), the ``jump`` that goes with it, and
    the number of ``iterations`` that the equations took."""

    velocity: Array
    jump: Jump
    iterations: int


def respond_together(
    surroundings: Surroundings,
    droplets: Sequence[Droplet],
    layers: Sequence[ClosedLayers],
) -> list[Response]:
    """The velocities of all interfaces.

    Raises ConditionError where GMRES fails, and for several droplets of which one has an
    interface law with an unknown of its own.
    """
    together = _Together(surroundings, droplets, layers)
    counts: list[int] = []

    def velocities(jumps: Sequence[Jump]) -> list[Array]:
        found, count = together.solve(jumps)
        counts.append(count)
        return found

    if len(droplets) == 1:
        law = droplets[0].interface
        velocity, jump = law.close(layers[0], lambda jump: velocities([jump])[0])
        return [Response(velocity, jump, sum(counts))]
    jumps = [_explicit_jump(d, of) for d, of in zip(droplets, layers, strict=True)]
    found = velocities(jumps)
    return [Response(u, j, counts[0]) for u, j in zip(found, jumps, strict=True)]


def made_outside(
    layers: ClosedLayers, single: Array | None, double: Array | None, points: Array
) -> Array:
    """(S[q] + D[u]) / 2h at points (dim, M) off an interface, q and u given by coefficients."""
    if single is None and double is None:
        return np.zeros_like(points)
    return off_surface(layers, single, double, points) / (2 * layers.free_term)


def _explicit_jump(droplet: Droplet, layers: ClosedLayers) -> Jump:
    """The jump of a law that needs to know the shape only."""
    if not hasattr(droplet.interface, "jump_of"):
        raise ConditionError(
            f"{type(droplet.interface).__name__} has an unknown of its own, which is solved for "
            "one droplet alone; give several droplets SurfaceTension or Bending"
        )
    return droplet.interface.jump_of(layers)


@dataclass(frozen=True, eq=False)
class _Together:
    surroundings: Surroundings
    droplets: Sequence[Droplet]
    layers: Sequence[ClosedLayers]

    @cached_property
    def _equations(self) -> list[InterfaceEquation]:
        return [
            InterfaceEquation(of, d.viscosity_ratio, self.surroundings.deflated)
            for d, of in zip(self.droplets, self.layers, strict=True)
        ]

    @cached_property
    def _targets(self) -> list[Array]:
        return [of.targets.position for of in self.layers]

    @cached_property
    def _ends(self) -> list[int]:
        """Where one droplet's points end and the next one's begin."""
        return np.cumsum([t.shape[1] for t in self._targets])[:-1].tolist()

    def _incident(
        self,
        single: Sequence[Array | None],
        double: Sequence[Array | None],
        walls: Callable[[Array, Induced], Array | float],
    ) -> list[Array]:
        """What each droplet feels of the others and of ``walls``: [(dim, N), ...].

        Of the layers ∫ G q dS + ∫ u·T·n dS over 2h, q and u given by their coefficients.
        """

        def made(by: int, points: Array) -> Array:
            return made_outside(self.layers[by], single[by], double[by], points)

        def induced(points: Array) -> Array:
            return np.sum([made(j, points) for j in range(len(self.layers))], axis=0)

        everywhere = np.concatenate(self._targets, axis=1)
        total = np.zeros_like(everywhere) + walls(everywhere, induced)
        felt = np.split(total, self._ends, axis=1)
        for i, points in enumerate(self._targets):
            for j in range(len(self.layers)):
                if i != j:
                    felt[i] = felt[i] + made(j, points)
        return felt

    def solve(self, jumps: Sequence[Jump]) -> tuple[list[Array], int]:
        """Coefficients of all velocities, and the number of iterations."""
        rights = self._rights(jumps)
        if all(e.beta == 0.0 for e in self._equations):
            pairs = zip(self._equations, rights, strict=True)
            return [e.recover(right) for e, right in pairs], 0
        values, count = self._iterate(rights)
        return [e.recover(w) for e, w in zip(self._equations, values, strict=True)], count

    def _rights(self, jumps: Sequence[Jump]) -> list[Array]:
        """b (dim, N) of each equation: flow without droplets, and all single layers."""
        viscosity = self.surroundings.viscosity
        forces, own = [], []
        for jump, of in zip(jumps, self.layers, strict=True):
            at_targets, basis = jump(of.targets), of.operator.basis
            level = (at_targets * of.targets.normal).sum(axis=0)
            own.append(of.single(jump(of.points), level) / viscosity)
            forces.append(basis.fit(at_targets.reshape(-1, *basis.shape)) / -viscosity)
        felt = self._incident(forces, [None] * len(forces), self.surroundings.velocity)
        rights = []
        for e, single, incident in zip(self._equations, own, felt, strict=True):
            flow = 2 * incident - single / e.layers.free_term
            rights.append(e.prepared(flow / (1 + e.viscosity_ratio)))
        return rights

    def _apply(self, values: Sequence[Array]) -> list[Array]:
        """Left sides of all equations for w (dim, N) of each."""
        doubles = [
            None if e.beta == 0.0 else (1 - e.viscosity_ratio) * e.recover(w)
            for e, w in zip(self._equations, values, strict=True)
        ]
        felt = self._incident([None] * len(doubles), doubles, self.surroundings.reflected)
        return [
            e.apply(w) - e.prepared(2 / (1 + e.viscosity_ratio) * incident)
            for e, w, incident in zip(self._equations, values, felt, strict=True)
        ]

    def _iterate(self, rights: Sequence[Array]) -> tuple[list[Array], int]:
        residuals: list[float] = []
        shape = (len(rights[0]), -1)

        def apply(flat: Array) -> Array:
            values = np.split(flat.reshape(shape), self._ends, axis=1)
            values = [np.ascontiguousarray(v) for v in values]
            return np.concatenate(self._apply(values), axis=1).ravel()

        right = np.concatenate(rights, axis=1).ravel()
        system = LinearOperator((right.size, right.size), apply, dtype=float)
        solution, failed = gmres(
            system, right, x0=right, rtol=SOLVER_TOLERANCE,
            restart=60, maxiter=5, callback=residuals.append, callback_type="pr_norm",
        )  # fmt: skip
        if failed:
            ratios = ", ".join(f"{e.viscosity_ratio:g}" for e in self._equations)
            raise ConditionError(
                f"the velocities of droplets with viscosity ratios {ratios} did not converge: "
                f"residual {residuals[-1]:.1e} after {len(residuals)} iterations"
            )
        return np.split(solution.reshape(shape), self._ends, axis=1), len(residuals)
