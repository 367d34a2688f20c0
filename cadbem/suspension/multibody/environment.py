"""The environment of bodies: surroundings, quadrature rule, contact rule and far field."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from cadbem.operators.far.equivalent import FarField
from cadbem.quadrature.closed import PolarRule, SelfRule
from cadbem.spline.basis import Array
from cadbem.suspension.bodies.body import Placed
from cadbem.suspension.multibody.contact import Contact, StopAtGap
from cadbem.suspension.multibody.multibody import velocity_responses
from cadbem.suspension.surroundings.surroundings import Surroundings


@dataclass(frozen=True, eq=False)
class Environment:
    """The ``flow`` that bodies are in, the ``rule`` that integrates over them, the ``contact`` rule
    in narrow gaps, and the equivalent sources of distant bodies (``far``, None: direct sums)."""

    flow: Surroundings
    rule: SelfRule = PolarRule()
    contact: Contact = StopAtGap()
    far: FarField | None = FarField()

    def responses(self, placed: Sequence[Placed], guess: Sequence[Array] = ()) -> list[Any]:
        """The ``Response`` of each droplet, the ``ParticleResponse`` of each particle."""
        return velocity_responses(self.flow, placed, self.contact, guess, self.far)
