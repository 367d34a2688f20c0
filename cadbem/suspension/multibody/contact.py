"""Gaps between bodies, walls and openings, and the contact rules for narrow ones.

Between surfaces that nearly touch, the flow varies over lengths far below their distance from
anything else, and sooner or later below what their points resolve.  A ``Contact`` rule says
whether a run then ends, or which pressure acts.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from cadbem.checks import positive
from cadbem.errors import ConditionError
from cadbem.spline.basis import Array
from cadbem.suspension.bodies.body import ContactPressure, Placed
from cadbem.suspension.bodies.droplet import PlacedDroplet
from cadbem.suspension.multibody.neighbours import Neighbours
from cadbem.suspension.surroundings.surroundings import Surroundings

WATCHED = 3.0  # spacings of a body's points within which its gaps are known
AT_OPENING = 1.0  # spacings from an opening at which a body has left


@dataclass(frozen=True)
class Gap:
    """The narrowest gap of a ``body`` (its number): its ``length``, negative where they overlap,
    to what ``other``, and the larger ``spacing`` of points on either side; the distance
    ``to_opening`` of which name, and the body's ``own_spacing``; the larger ``uncertainty`` of the
    place of either side's surface, as far as bodies' own points tell."""

    body: int
    length: float
    other: str
    spacing: float
    to_opening: float
    opening: str
    own_spacing: float
    uncertainty: float

    @property
    def share(self) -> float:
        """The gap as a share of the spacing."""
        return self.length / self.spacing

    @property
    def at_opening(self) -> bool:
        """Whether the body has arrived at an opening."""
        return self.to_opening < AT_OPENING * self.own_spacing


class Contact(Protocol):
    """A rule for narrow gaps."""

    def reason(self, gap: Gap) -> str:
        """Why a run cannot go on, or an empty text."""

    def pressure(self, gaps: Array) -> Array:
        """Contact pressure (M,) on surfaces at points with ``gaps`` (M,)."""

    @property
    def reach(self) -> float:
        """Gap from which on there is no pressure."""


@dataclass(frozen=True)
class StopAtGap:
    """A run ends when a gap is narrower than a ``share`` of the spacing of points."""

    share: float = 0.2

    reach = 0.0

    def __post_init__(self) -> None:
        positive("StopAtGap's share", self.share)

    def reason(self, gap: Gap) -> str:
        """Why a run cannot go on, or an empty text."""
        if gap.share >= self.share:
            return ""
        return (
            f"body {gap.body} is {max(gap.length, 0.0):.3g} from {gap.other}, and points "
            f"{gap.spacing:.3g} apart do not resolve so narrow a gap: take more points, or choose "
            "contact=Repel(...)"
        )

    def pressure(self, gaps: Array) -> Array:
        """Zero (M,)."""
        return np.zeros_like(gaps)


@dataclass(frozen=True)
class StopAtError:
    """A run ends when a surface beside a gap may be out of place by more than a ``share`` of it.

    However far points are apart: splines through points carry a smooth film that is much thinner,
    and the decay of the surface's shortest waves says when they do no more.  A rigid particle's
    place is exact and its traction is not; it counts as out of place by 0.06 spacings.
    """

    share: float = 0.3

    reach = 0.0

    def __post_init__(self) -> None:
        positive("StopAtError's share", self.share)

    def reason(self, gap: Gap) -> str:
        """Why a run cannot go on, or an empty text."""
        if gap.length > 0 and gap.uncertainty <= self.share * gap.length:
            return ""
        return (
            f"body {gap.body} is {max(gap.length, 0.0):.3g} from {gap.other}, and its points leave "
            f"its surface uncertain by {gap.uncertainty:.3g}: take more points, "
            "points=AdaptivePoints(...), or contact=Repel(...)"
        )

    def pressure(self, gaps: Array) -> Array:
        """Zero (M,)."""
        return np.zeros_like(gaps)


@dataclass(frozen=True)
class Repel:
    """A pressure pushes surfaces apart that are nearer than ``reach`` (a length):

        Π(gap) = strength (1 - gap / reach)²,

    on both sides of the gap, along their normals.  Choose a ``strength`` (a pressure) of some
    times γ / R, or of the viscous stresses, and a reach as small as the points allow, about half
    their spacing.  The rule stands for what is not resolved or not known, and makes results in
    narrow gaps depend on it.
    """

    reach: float
    strength: float

    def __post_init__(self) -> None:
        positive("Repel's reach", self.reach)
        positive("Repel's strength", self.strength)

    def reason(self, gap: Gap) -> str:
        """An empty text: the pressure keeps the surfaces apart."""
        return ""

    def pressure(self, gaps: Array) -> Array:
        """Π (M,)."""
        return self.strength * np.clip(1 - gaps / self.reach, 0.0, 1.5) ** 2


def narrowest(
    surroundings: Surroundings, bodies: Sequence[Placed], numbers: Sequence[int], everywhere: bool
) -> list[Gap]:
    """The narrowest gap of each body, as far as it is watched, or ``everywhere``."""
    gaps, neighbours = [], Neighbours(bodies)
    for i, body in enumerate(bodies):
        own = body.spacing
        reach = np.inf if everywhere else WATCHED * own
        wall, name, opening, which = _to_walls(surroundings, body, reach)
        gap = Gap(numbers[i], wall, f"'{name}'", own, opening, which, own, body.uncertainty)
        length, j = neighbours.nearest(i, reach)
        if length < gap.length:
            spacing = max(own, bodies[j].spacing)
            unsure = max(body.uncertainty, bodies[j].uncertainty)
            gap = replace(
                gap, length=length, other=f"body {numbers[j]}", spacing=spacing, uncertainty=unsure
            )
        gaps.append(gap)
    return gaps


def _to_walls(
    surroundings: Surroundings, body: Placed, reach: float
) -> tuple[float, str, float, str]:
    """Signed distance to the nearest wall, and its name; the same for openings."""
    boundary = surroundings.nearest(body.samples, reach)
    result: list = []
    for of_kind in (~boundary.opening, boundary.opening):
        here = np.nonzero(of_kind)[0]
        if len(here) == 0:
            result += [np.inf, ""]
            continue
        best = here[int(boundary.distance[here].argmin())]
        result += [float(boundary.distance[best]), boundary.names[best]]
    return result[0], result[1], result[2], result[3]


def contact_pressure(
    surroundings: Surroundings, neighbours: Neighbours, number: int, contact: Contact
) -> ContactPressure | None:
    """The pressure (M,) of a contact rule at points (dim, M) of one of the bodies, if any."""
    if not contact.reach:
        return None

    def pressure(points: Array) -> Array:
        boundary = surroundings.nearest(points, contact.reach)
        walls = np.where(boundary.opening, np.inf, boundary.distance)
        others = neighbours.gaps(number, points, contact.reach)
        return contact.pressure(np.minimum(walls, others))

    return pressure


def check_start(
    surroundings: Surroundings, bodies: Sequence[Placed], numbers: Sequence[int]
) -> list[Gap]:
    """Gaps of bodies before they move.

    Raises ConditionError for a body that is not inside the channel, or overlaps another.
    """
    gaps = narrowest(surroundings, bodies, numbers, everywhere=True)
    for gap, body in zip(gaps, bodies, strict=True):
        centre = ", ".join(f"{x:.4g}" for x in body.targets.mean(axis=1))
        if gap.length <= 0 or gap.at_opening:
            other = gap.other if gap.length <= 0 else f"the opening '{gap.opening}'"
            hint = "" if other.startswith("body") else _room(surroundings, body)
            raise ConditionError(
                f"body {gap.body}, around ({centre}), is not clear of {other}: place it inside "
                f"the fluid and away from other bodies{hint}"
            )
    return gaps


def _room(surroundings: Surroundings, body: Placed) -> str:
    """How large a droplet may be where one is that is too large, and what fills a channel."""
    middle = body.targets.mean(axis=1)[:, None]
    room = float(surroundings.nearest(middle, np.inf).distance[0])
    if not isinstance(body, PlacedDroplet) or not 0 < room < np.inf:
        return ""
    return (
        f"; a sphere there has a radius below {room:.4g}, and cb.plug(channel, at=..., volume=...) "
        "makes a droplet that fills the channel but for a film"
    )
