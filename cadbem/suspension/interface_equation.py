"""The equation for the velocity of one droplet's interface (Eq. 3.4 and 4.1), deflated.

With h = 4π (2π in 2D), λ the viscosity ratio, μ the outer viscosity and u∞ the velocity that
everything but the droplet makes,

    (1 + λ) u = 2 u∞ - S[Δf] / (h μ) + (1 - λ) / h D[u],

or u - β D u / h = b with β = (1 - λ) / (1 + λ).  D / h has the eigenvalue -1 for rigid motions,
and +1 with n as left eigenvector; they make the equation ill-conditioned for λ → ∞ and λ → 0.  Both
are deflated (Kim and Karrila 1991, ch. 16; Pozrikidis 1992, ch. 4): with P the projection on rigid
motions and Q that on n,

    w - β (D / h + P - Q) w = b - Q b,    u = w - β / (1 + β) P w,

which also keeps the flux through the interface at zero.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from cadbem.closed_points import ClosedPoints
from cadbem.operators.closed import ClosedLayers
from cadbem.quadrature.closed import even_weights
from cadbem.spline.basis import Array


@dataclass(frozen=True, eq=False)
class InterfaceEquation:
    """u - β D u / h = b on one interface: see the top of this file."""

    layers: ClosedLayers
    viscosity_ratio: float
    deflated: bool = True

    @property
    def beta(self) -> float:
        """(1 - λ) / (1 + λ)."""
        return (1 - self.viscosity_ratio) / (1 + self.viscosity_ratio)

    @property
    def _targets(self) -> ClosedPoints:
        return self.layers.targets

    @cached_property
    def _weights(self) -> Array:
        """Area of each collocation point, as a share of the whole."""
        area = self._targets.jacobian * collocation_weights(self.layers)
        return area / area.sum()

    @cached_property
    def _rigid(self) -> Array:
        """Rigid motions (modes, dim, N), orthonormal in the mean over the interface."""
        modes = rigid_motions(self._targets.position, self._weights)
        flat = modes.reshape(len(modes), -1)
        root = np.sqrt(np.tile(self._weights, self.layers.spline.dimension))
        basis = np.linalg.qr((flat * root).T)[0].T / root
        return basis.reshape(modes.shape)

    def _project(self, values: Array) -> Array:
        """P: the nearest rigid motion."""
        amounts = np.einsum("mcn,cn,n->m", self._rigid, values, self._weights)
        return np.einsum("m,mcn->cn", amounts, self._rigid)

    def _flux(self, values: Array) -> Array:
        """Q: n times the mean flux through the interface."""
        normal = self._targets.normal
        return normal * ((values * normal).sum(axis=0) @ self._weights)

    def apply(self, values: Array) -> Array:
        """w - β (D / h + P - Q) w at the collocation points."""
        if self.beta == 0.0:
            return values
        basis = self.layers.operator.basis
        coefficients = basis.fit(values.reshape(-1, *basis.shape))
        doubled = self.layers.double(coefficients) / self.layers.free_term
        if self.deflated:
            doubled += self._project(values) - self._flux(values)
        return values - self.beta * doubled

    def prepared(self, right: Array) -> Array:
        """The right side, without flux if that is deflated."""
        return right - self._flux(right) if self.deflated else right

    def recover(self, values: Array) -> Array:
        """Coefficients (dim, *shape) of u from w (dim, N)."""
        basis = self.layers.operator.basis
        if self.deflated and self.beta != 0.0:
            values = values - self.beta / (1 + self.beta) * self._project(values)
        return basis.fit(values.reshape(-1, *basis.shape))


def collocation_weights(layers: ClosedLayers) -> Array:
    """Weights (N,) of the collocation points on the unit circle or sphere."""
    return even_weights(layers.operator.basis.shape).ravel()


def rigid_motions(position: Array, weights: Array) -> Array:
    """Translations and rotations about the mean point: (3 or 6, dim, N)."""
    dim = len(position)
    arm = position - (position @ weights)[:, None] / weights.sum()
    shifts = np.broadcast_to(np.eye(dim)[:, :, None], (dim, *arm.shape))
    if dim == 2:
        return np.concatenate([shifts, [np.stack([-arm[1], arm[0]])]])
    turns = [np.cross(axis, arm, axisa=0, axisb=0, axisc=0) for axis in np.eye(3)]
    return np.concatenate([shifts, turns])
