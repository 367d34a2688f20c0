"""The resistance of a rigid body: its motion in a given flow (Eq. 4.14 and 4.15).

On the surface of a body that moves rigidly the double layer drops out.  With h = 4π (2π in 2D), μ
the viscosity and u∞ the velocity that everything but the body makes,

    S[f] / (2 h μ) + U + Ω × (x - c) = u∞,    ∫ f dS = -F,    ∫ (x - c) × f dS = -T

for the traction f of the fluid on the body, the velocity U of its centre c, the angular velocity Ω,
and the external force F and torque T on it.  The traction f = n, a pressure inside, has no velocity
outside; it is excluded by ∫ f·n dS = 0, with a multiple of n to make room.  In the body's own axes
the matrix is constant.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
from scipy.sparse import block_diag, csr_array, diags_array

from cadbem.boundary import Boundary
from cadbem.elements.pieces import Elements
from cadbem.errors import ShapeError
from cadbem.kernels.kernel import Kernel
from cadbem.kernels.stokes import stokes_kernels
from cadbem.operators.layers import OwnLayers
from cadbem.operators.nearest import NearestSearch
from cadbem.operators.solve import Border, DenseFactors, factorise
from cadbem.points import SurfacePoints
from cadbem.quadrature import Rules
from cadbem.space import Field, Space, discontinuous_space, rational_basis
from cadbem.spline.basis import Array
from cadbem.suspension.rigid.pose import rigid_motions

OPEN = 1e-6  # |∫ n dS| over the area from which a surface counts as open
SURFACE_ORDER = 8  # Gauss points a direction in each element


@dataclass(frozen=True, eq=False)
class Resistance:
    """A rigid ``boundary``, normals outwards, in its own axes, with its factorised matrix."""

    boundary: Boundary
    quadrature: Rules

    def __post_init__(self) -> None:
        points, weights = self.surface
        if np.linalg.norm(points.normal @ weights) > OPEN * weights.sum():
            raise ShapeError(
                f"the rigid particle's shape {self.boundary.source} is not closed: give all faces "
                "of a solid"
            )
        if self.volume < 0:
            raise ShapeError(
                "the normals of the rigid particle's shape point inwards, as those of a fluid's "
                "boundary: use shape.turned()"
            )

    @property
    def dimension(self) -> int:
        """2 or 3."""
        return self.boundary.dimension

    @cached_property
    def kernel(self) -> Kernel:
        """The kernel of the velocity."""
        return stokes_kernels(self.dimension)[0]

    @cached_property
    def space(self) -> Space:
        """Unknown tractions and collocation points."""
        return discontinuous_space(self.boundary)

    @cached_property
    def volume(self) -> float:
        """Volume, or area in 2D."""
        return -self.boundary.volume()

    @cached_property
    def surface(self) -> tuple[SurfacePoints, Array]:
        """Points and weights for integrals over the surface."""
        return self.boundary.quadrature(SURFACE_ORDER)

    @cached_property
    def spacing(self) -> float:
        """Mean distance of the collocation points."""
        share = float(self.surface[1].sum()) / self.space.count
        return share ** (1 / (self.dimension - 1))

    @cached_property
    def centre(self) -> Array:
        """Centre of volume (dim,): ∫ x dV = ∫ (x·x) n dS / 2."""
        points, weights = self.surface
        middle = self.boundary.bounds().mean(axis=0)
        arm = points.position - middle[:, None]
        first = 0.5 * (points.normal * (arm**2).sum(axis=0)) @ weights
        return middle + first / self.volume

    @cached_property
    def elements(self) -> Elements:
        """The boundary's elements."""
        return Elements.of(self.boundary)

    @cached_property
    def nearest(self) -> NearestSearch:
        """The search for nearest points on the surface."""
        return NearestSearch(self.boundary)

    @cached_property
    def nodes(self) -> tuple[Array, csr_array]:
        """Nodes (dim, K) on the surface, and each function's values (F, K) there with weights."""
        unit = Field(self.space, np.ones((1, self.space.count)))
        positions, values = [], []
        for i, patch in enumerate(self.boundary.patches):
            parameters, points, weights = unit.nodes(i)
            positions.append(points.position)
            values.append(rational_basis(patch.surface, parameters).T @ diags_array(weights))
        return np.concatenate(positions, axis=1), csr_array(block_diag(values))

    @cached_property
    def factors(self) -> DenseFactors:
        """Factors of the matrix for f / μ, bordered by rigid motions and n."""
        layers = OwnLayers(self.kernel, self.space, self.quadrature)
        one = np.eye(self.dimension)
        count = len(self.boundary.patches)
        single = [one / (2 * self.kernel.free_term)] * count
        border = Border(self._functionals, self._fields(self.space.collocation))
        return factorise(layers, 0.0, single, [0 * one] * count, border)

    def _fields(self, points: SurfacePoints) -> Array:
        """Rigid motions and n at points: (modes + 1, dim, N)."""
        motions = rigid_motions(points.position - self.centre[:, None])
        return np.concatenate([motions, points.normal[None]])

    @cached_property
    def _functionals(self) -> Array:
        """∫ N_j m dS (modes + 1, dim, F) of each function with each of ``_fields``."""
        rows = []
        unit = Field(self.space, np.ones((1, self.space.count)))
        for i in range(len(self.boundary.patches)):
            parameters, points, weights = unit.nodes(i)
            basis = rational_basis(self.boundary.patches[i].surface, parameters)
            fields = self._fields(points) * weights
            rows.append((fields.reshape(-1, len(weights)) @ basis).reshape(*fields.shape[:2], -1))
        return np.concatenate(rows, axis=2)

    def solve(self, velocity: Array, load: Array) -> tuple[Array, Array]:
        """f / μ, coefficients (dim, F), and (U, Ω) in one array, in a velocity u∞ (dim, F) at the
        collocation points, with (F, T) / μ in one array ``load``."""
        solved = self.factors.solve(velocity, np.append(-load, 0.0))
        return solved.unknowns, solved.border[:-1]


@lru_cache(maxsize=64)
def resistance(boundary: Boundary, quadrature: Rules) -> Resistance:
    """The resistance of a boundary; equal bodies that share one share its matrix."""
    return Resistance(boundary, quadrature)
