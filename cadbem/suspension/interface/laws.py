"""Interface laws: the jump of the traction across an interface, as a function of its shape.

A jump is Δf = (σ_out - σ_in)·n with n outwards.  A law closes the problem of a droplet: it is given
``velocity_response``, which maps a jump to the velocity of the interface, and returns that velocity
and the jump that belongs to it.  ``stiffness(k)`` is the jump per amplitude of short waves of wave
number k; it sets the largest stable step in time.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from cadbem.checks import not_negative, positive
from cadbem.closed_points import ClosedPoints
from cadbem.operators.closed.layers import ClosedLayers
from cadbem.spline.basis import Array
from cadbem.units import check

Jump = Callable[[ClosedPoints], Array]
VelocityResponse = Callable[[Jump], Array]


class InterfaceLaw(Protocol):
    """The protocol of interface laws."""

    def close(
        self, layers: ClosedLayers, velocity_response: VelocityResponse
    ) -> tuple[Array, Jump]:
        """Velocity coefficients (dim, *shape) of the interface, and the jump."""

    def stiffness(self, wave_number: float) -> float:
        """Jump per amplitude of short waves."""


@dataclass(frozen=True)
class SurfaceTension:
    """A clean interface of constant ``tension`` γ: Δf = γ c n, c = div n (Eq. 1.1, 4.2).

    In 2D and 3D alike: c is 1 / R on a circle and 2 / R on a sphere.  Raises ``UnitsError`` for a
    quantity that is not a force per length.
    """

    tension: float

    def __post_init__(self) -> None:
        check("tension", self.tension, "tension")
        not_negative("tension", self.tension)

    def jump(self, points: ClosedPoints) -> Array:
        """Δf (dim, N)."""
        return self.tension * points.curvature * points.normal

    def close(
        self, layers: ClosedLayers, velocity_response: VelocityResponse
    ) -> tuple[Array, Jump]:
        """See the top of this file."""
        return velocity_response(self.jump), self.jump

    def jump_of(self, layers: ClosedLayers) -> Jump:
        """The jump, whatever the surface."""
        return self.jump

    def stiffness(self, wave_number: float) -> float:
        """γ k²."""
        return self.tension * wave_number**2


def capillary_tension(capillary: float) -> SurfaceTension:
    """Tension where lengths are in radii, times in inverse shear rates, and the outer viscosity
    is 1: γ = 1 / Ca with Ca = μ × rate × R / γ."""
    return SurfaceTension(1.0 / positive("capillary", capillary))


def thesis_tension_2d(capillary: float) -> SurfaceTension:
    """Tension of the thesis's 2D droplets, Δf = (2 / Ca) c n (Eq. 3.3): its Ca is twice ours."""
    return SurfaceTension(2.0 / positive("capillary", capillary))


@dataclass(frozen=True)
class Bending:
    """A membrane that resists bending with a ``rigidity`` h and has no tension (Eq. 1.3).

    Δf = -h [c³/2 - 2 K c + Δ_s c] n, with c the sum of the principal curvatures and K the Gaussian
    curvature: the first variation of (h/2) ∫ c² dS, as a normal displacement ψ changes dS by c ψ dS
    and c by -(c² - 2 K) ψ - Δ_s ψ.  In 2D K = 0, and a circle has the uniform Δf = -h c³/2 n.

    Fourth derivatives of the shape: degree 6 is soon ten times as accurate as degree 4.
    """

    rigidity: float

    def __post_init__(self) -> None:
        not_negative("rigidity", self.rigidity)

    def close(
        self, layers: ClosedLayers, velocity_response: VelocityResponse
    ) -> tuple[Array, Jump]:
        """See the top of this file."""
        jump = self.jump_of(layers)
        return velocity_response(jump), jump

    def jump_of(self, layers: ClosedLayers) -> Jump:
        """The jump on one surface; curvature becomes a spline, to be differentiated."""
        basis = layers.operator.basis
        curvature = basis.fit(layers.targets.curvature.reshape(basis.shape))

        def jump(points: ClosedPoints) -> Array:
            c = points.curvature
            force = c**3 / 2 - 2 * points.gaussian * c + points.laplacian(curvature)
            return -self.rigidity * force * points.normal

        return jump

    def stiffness(self, wave_number: float) -> float:
        """h k⁴, and a third more: the curvature of splines' shortest waves overshoots."""
        return 4 / 3 * self.rigidity * wave_number**4


def no_jump(points: ClosedPoints) -> Array:
    """An interface without any force."""
    return np.zeros_like(points.normal)
