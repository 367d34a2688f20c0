"""The equation for the velocity of one droplet's interface (Eq. 3.4 and 4.1), deflated.

With h = 4π (2π in 2D), λ the viscosity ratio, μ the outer viscosity and u∞ the velocity that
everything but the droplet makes,

    (1 + λ) u = 2 u∞ - S[Δf] / (h μ) + (1 - λ) / h D[u].

For w = (1 + λ) u this is w - β D w / h = b, β = (1 - λ) / (1 + λ).  D / h has the eigenvalue -1 for
rigid motions, and +1 with n as left eigenvector; they make the equation ill-conditioned for λ → ∞
and λ → 0.  Both are deflated (Kim and Karrila 1991, ch. 16; Pozrikidis 1992, ch. 4): with P the
projection on rigid motions and Q that on n,

    w - β (D / h + P - Q) w = b - Q b,    u = (w - P w) / (1 + λ) + P w / 2,

which also keeps the flux through the interface at zero.  Outside, rigid motions make nothing, and
the droplet's double layer (1 - λ) D[u] is that of β (w - P w).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from cadbem.closed_points import ClosedPoints
from cadbem.operators.closed.layers import ClosedLayers
from cadbem.quadrature.closed import even_weights
from cadbem.spline.basis import Array
from cadbem.suspension.rigid.pose import rigid_motions


@dataclass(frozen=True, eq=False)
class InterfaceEquation:
    """w - β D w / h = b on one interface: see the top of this file."""

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
        arm = self._targets.position - (self._targets.position @ self._weights)[:, None]
        modes = rigid_motions(arm)
        flat = modes.reshape(len(modes), -1)
        root = np.sqrt(np.tile(self._weights, self.layers.spline.dimension))
        basis = np.linalg.qr((flat * root).T)[0].T / root
        return basis.reshape(modes.shape)

    def _rigid_part(self, values: Array) -> Array | float:
        """P: the nearest rigid motion, if the equation is deflated."""
        if not self.deflated:
            return 0.0
        amounts = np.einsum("mcn,cn,n->m", self._rigid, values, self._weights)
        return np.einsum("m,mcn->cn", amounts, self._rigid)

    def _flux(self, values: Array) -> Array | float:
        """Q: n times the mean flux through the interface, if the equation is deflated."""
        if not self.deflated:
            return 0.0
        normal = self._targets.normal
        return normal * ((values * normal).sum(axis=0) @ self._weights)

    def apply(self, values: Array) -> Array:
        """w - β (D / h + P - Q) w at the collocation points."""
        if self.beta == 0.0:
            return values
        doubled = self.layers.double(self._fit(values)) / self.layers.free_term
        doubled += self._rigid_part(values) - self._flux(values)
        return values - self.beta * doubled

    def right(self, incident: Array) -> Array:
        """Right side that a velocity u∞ (dim, N) brings: 2 u∞, without its flux."""
        return 2 * (incident - self._flux(incident))

    def right_of_layer(self, density: Array, at_targets: Array) -> Array:
        """Right side that the interface's own single layer brings: S[q] / h for q = -Δf / μ at the
        nodes (dim, nodes) and at the collocation points (dim, N)."""
        level = (at_targets * self._targets.normal).sum(axis=0)
        single = self.layers.single(density, level) / self.layers.free_term
        return single - self._flux(single)

    def velocity(self, values: Array) -> Array:
        """Coefficients (dim, *shape) of u from w (dim, N)."""
        rigid = self._rigid_part(values)
        return self._fit((values - rigid) / (1 + self.viscosity_ratio) + 0.5 * rigid)

    def density(self, values: Array) -> Array:
        """Coefficients (dim, *shape) of the double layer that goes with w (dim, N)."""
        return self._fit(self.beta * (values - self._rigid_part(values)))

    def _fit(self, values: Array) -> Array:
        basis = self.layers.operator.basis
        return basis.fit(values.reshape(-1, *basis.shape))


def collocation_weights(layers: ClosedLayers) -> Array:
    """Weights (N,) of the collocation points on the unit circle or sphere."""
    return even_weights(layers.operator.basis.shape).ravel()
