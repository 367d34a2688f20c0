"""How wrong a state of bodies may be, and warnings of runs whose states are too wrong."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from cadbem.errors import AccuracyWarning
from cadbem.problems.estimates import DOUBTFUL, Accuracy, Estimate
from cadbem.suspension.bodies.body import Body
from cadbem.suspension.bodies.droplet import Response
from cadbem.suspension.multibody.multibody import MultibodySystem
from cadbem.suspension.multibody.slip import velocity_errors
from cadbem.suspension.surroundings.channel_flow import ChannelFlow

STRIDE = 1.0  # sizes that bodies move from one look to the next
BESIDE_WALLS, SURFACE, FLUX, STEP = "velocity beside walls", "surface", "net flux", "last step"


def state_accuracy(state: Any) -> Accuracy:
    """Estimates by body: its velocity, for the slip on walls near it, as a share of its speed; the
    displacement of a droplet's surface, for the decay of its waves, as a share of its size; the net
    flux through that, as a share of area times speed.  And the displacement in the last step."""
    found = [_of_step(state)]
    speeds = [_speed(r, b) for r, b in zip(state.responses, state.bodies, strict=True)]
    errors = [0.0] * len(speeds)
    if isinstance(state.flow, ChannelFlow):
        system = MultibodySystem(state.flow, tuple(state.placed), far=state.environment.far)
        densities = [r.densities for r in state.responses]
        sizes = [b.size for b in state.bodies]
        errors = velocity_errors(state.flow, system, densities, sizes)
    for number, speed, error in zip(state.numbers, speeds, errors, strict=True):
        found.append(Estimate(BESIDE_WALLS, f"body {number}", speed, error, speed))
    for number, resolution in state.resolutions.items():
        size = state.bodies[state.numbers.index(number)].size
        name = f"body {number}"
        found.append(Estimate(SURFACE, name, size, resolution.uncertainty, size))
        found.append(Estimate(FLUX, name, 0.0, resolution.flux, 1.0))
    return Accuracy(tuple(found))


def _of_step(state: Any) -> Estimate:
    return Estimate(STEP, "", state.length, state.error, 1.0)


def _speed(response: Any, body: Body) -> float:
    """The mean speed of a body's surface, about."""
    if isinstance(response, Response):
        return float(np.sqrt((response.velocity**2).sum(axis=0).mean()))
    turning = float(np.linalg.norm(response.angular_velocity)) * body.size / 2
    return float(np.hypot(np.linalg.norm(response.velocity), turning))


@dataclass(eq=False)
class Watch:
    """Looks at the states of a run, and warns once of each quantity that may be off by more than a
    relative ``limit``."""

    limit: float | None
    _said: set[str] = field(default_factory=set)
    _seen: dict[int, Any] = field(default_factory=dict)

    def look(self, state: Any) -> None:
        """Warn of a state, if its bodies have moved since the last one or are new."""
        if state.left.keys() & set(state.numbers) or not self._due(state.numbers, state.bodies):
            return  # a body at an opening is about to be taken out
        self._seen = {n: b.centre for n, b in zip(state.numbers, state.bodies, strict=True)}
        for estimate in state.accuracy.estimates:
            limit = DOUBTFUL if self.limit is None else self.limit
            if estimate.relative > limit and estimate.name not in self._said:
                self._said.add(estimate.name)
                warnings.warn(self._text(estimate, state.time), AccuracyWarning, stacklevel=2)

    def _due(self, numbers: Sequence[int], bodies: Sequence[Body]) -> bool:
        for number, body in zip(numbers, bodies, strict=True):
            old = self._seen.get(number)
            if old is None or np.linalg.norm(body.centre - old) > STRIDE * body.size:
                return True
        return False

    def _text(self, estimate: Estimate, time: float) -> str:
        share = f"{estimate.name} may be off by {estimate.relative:.1e} of its size"
        if self.limit is None:
            return f"{share} at time {time:.4g}: Simulation(accuracy=1e-3) refines what causes it"
        return (
            f"{share} at time {time:.4g}, where {self.limit:g} was asked for: ask for a smaller "
            "accuracy to see how results change"
        )
