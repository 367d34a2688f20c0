"""Membranes that bend but do not stretch, such as those of vesicles (Eq. 1.2 and 1.3).

The tension τ is whatever keeps every piece of the membrane as large as it is, ∇_s·u = 0.  It is a
sum of harmonics ψ of the unit circle or sphere, and the equation is tested with the same harmonics:

    ∮ ψ_a ∇_s·u[τ] dS = 0,    u[τ] = u[no tension] + u of the jump τ c n - ∇_s τ.

The constant is among them, so that the whole length or area stays.  Integration by parts makes
∮ ψ ∇_s·u dS the work ∮ (ψ c n - ∇_s ψ)·u dS that one tension does on the flow of another: the
matrix is symmetric and not positive.  On a round membrane it is diagonal.  With equal viscosities,
on a circle,

    τ = cos nθ:  u = -sin nθ / (4 μ) t,  so  ∮ ψ ∇_s·u dS = -(n / 4 μ) ∮ ψ τ dθ,

and on a sphere (from the eigenvalues of the single layer on vector spherical harmonics)

    -l (l + 1) (2 l² + 2 l - 1) / [(2 l - 1) (2 l + 1) (2 l + 3) μ] R ∮ ψ τ dω,

about -l / 4 for short waves.  In a plane this is the leading part on any curve, whatever its
parameters, and the iteration starts from it.

A round membrane encloses as much as it can: uniform tension does not move the fluid, and its size
is undetermined (left at zero).  Nearly round ones have tensions inversely proportional to how far
they are from round.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
from scipy.sparse.linalg import LinearOperator, gmres
from scipy.special import lpmv

from cadbem.checks import not_negative, positive
from cadbem.closed_points import ClosedPoints
from cadbem.errors import ConditionError
from cadbem.operators.closed.layers import ClosedLayers
from cadbem.spline.basis import Array
from cadbem.spline.closed import ClosedBasis
from cadbem.suspension.interface.laws import Bending, Jump, VelocityResponse, no_jump

SOLVER_TOLERANCE = 1e-7
LARGEST_REST = 1e-3  # share of the stretching that may be left where rounding ends an iteration
ITERATIONS = 60
SHARE = 3 / 4  # of the waves that the points carry, those that the tension has


@dataclass(frozen=True)
class InextensibleMembrane:
    """A membrane without stretching, and with a bending ``rigidity`` h (0: it bends freely).

    Δf = τ c n - ∇_s τ - h [c³/2 - 2 K c + Δ_s c] n with the tension τ that makes ∇_s·u = 0.
    ``tension`` is the size of τ to be expected, about viscosity × shear rate × radius; time steps
    are chosen to be stable for it, and nothing else depends on it.
    """

    rigidity: float = 0.0
    tension: float = 1.0

    def __post_init__(self) -> None:
        not_negative("rigidity", self.rigidity)
        positive("tension", self.tension)

    def close(
        self, layers: ClosedLayers, velocity_response: VelocityResponse
    ) -> tuple[Array, Jump]:
        """Velocity coefficients and jump (see ``InterfaceLaw``).

        Raises ConditionError when no tension stops the stretching.
        """
        bending = Bending(self.rigidity).jump_of(layers) if self.rigidity else no_jump
        size = self.rigidity * float((layers.targets.curvature**2).mean())
        tension = _TensionEquation(layers, velocity_response).solve(bending, size)

        def jump(points: ClosedPoints) -> Array:
            return bending(points) + tension_jump(points, tension)

        return velocity_response(jump), jump

    def stiffness(self, wave_number: float) -> float:
        """The stiffness of bending, plus τ k²."""
        bending = Bending(self.rigidity).stiffness(wave_number)
        return bending + self.tension * wave_number**2


def tension_jump(points: ClosedPoints, tension: Array) -> Array:
    """τ c n - ∇_s τ (dim, N) for the coefficients (*shape) of a tension."""
    normal = points.grid.values(tension) * points.curvature * points.normal
    return normal - points.gradient(tension)


@dataclass(frozen=True, eq=False)
class _TensionEquation:
    """∮ ψ ∇_s·u dS = 0, for ψ and τ among harmonics that are scaled such that the matrix is near a
    multiple of the unit matrix."""

    layers: ClosedLayers
    velocity_response: VelocityResponse

    @cached_property
    def _harmonics(self) -> Array:
        """Coefficients (modes, points)."""
        harmonics, rates = round_tensions(self.layers.operator.basis)
        return harmonics.reshape(len(harmonics), -1) / np.sqrt(rates)[:, None]

    def stretching(self, velocity: Array) -> Array:
        """∮ ψ ∇_s·u dS (modes,)."""
        rate = self.layers.points.divergence(velocity) * self.layers.weights
        return self._harmonics @ self.layers.operator.grid.transposed(rate).ravel()

    def solve(self, bending: Jump, size: float) -> Array:
        """Coefficients (*shape) of the tension that goes with a jump by bending, whose stresses
        have the ``size`` h c²: what stretches as little as a tiny share of it, counts as rest."""
        shape, still = self.layers.operator.basis.shape, self.velocity_response(no_jump)

        def apply(amounts: Array) -> Array:
            tension = (amounts @ self._harmonics).reshape(shape)
            velocity = self.velocity_response(lambda points: tension_jump(points, tension))
            return self.stretching(velocity - still)

        right, least = -self.stretching(still), 0.0
        if size:
            right = -self.stretching(self.velocity_response(bending))
            first = np.linalg.norm(apply(np.eye(len(right))[1]))
            least = SOLVER_TOLERANCE * size * float(first)
        matrix = LinearOperator((len(right), len(right)), apply, dtype=float)
        amounts, stalled = gmres(
            matrix, right, rtol=SOLVER_TOLERANCE, atol=least, restart=ITERATIONS, maxiter=1
        )
        if stalled:
            left = np.linalg.norm(right - apply(amounts)) / np.linalg.norm(right)
            if not left < LARGEST_REST:
                raise ConditionError(
                    f"the tension of the membrane was not found: it leaves {left:.1e} of the "
                    "stretching; take more points"
                )
        return (amounts @ self._harmonics).reshape(shape)


@lru_cache(maxsize=8)
def round_tensions(basis: ClosedBasis) -> tuple[Array, Array]:
    """Harmonics of the unit circle or sphere, coefficients (modes, *shape), and the rates (modes,)
    at which they make a round membrane shrink; the constant's, 0, is replaced by the first."""
    functions, rates = [], []
    for degree in range(int(SHARE * min(basis.shape[0], basis.shape[-1] // 2)) + 1):
        for values in _harmonics(degree, basis):
            functions.append(values / np.sqrt((values**2).mean()))
            rates.append(_round_rate(max(degree, 1), basis.dimension))
    return basis.fit(np.stack(functions).reshape(-1, *basis.shape)), np.array(rates)


def _round_rate(degree: int, dimension: int) -> float:
    if dimension == 2:
        return degree / 4
    middle = degree * (degree + 1)
    return middle * (2 * middle - 1) / ((2 * degree + 1) * (4 * middle - 3))


def _harmonics(degree: int, basis: ClosedBasis) -> list[Array]:
    """All of one degree at the collocation points."""
    *colatitude, longitude = basis.parameters()
    orders = range(degree + 1) if colatitude else [degree]
    waves = []
    for m in orders:
        height = lpmv(m, degree, np.cos(colatitude[0])) if colatitude else np.ones_like(longitude)
        waves.append(height * np.cos(m * longitude))
        if m:
            waves.append(height * np.sin(m * longitude))
    return waves
