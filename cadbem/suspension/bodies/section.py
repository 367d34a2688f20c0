"""The cross-section of a channel at a point, and the direction in which its walls run."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from cadbem.errors import ShapeError
from cadbem.problems.enclosure import Enclosure
from cadbem.spline.basis import Array

RAYS = 64  # directions in a cross-section
AROUND = 400  # directions in space in which walls are looked for
STEPS = 200  # of a ray towards a wall
ARRIVED = 1e-6  # distance to the wall, of the ray's length, at which it has arrived
FLAT = 0.3  # share of the walls' turn along the axis over that across, at most
WAVES = 4  # around a smooth cross-section
CENTRINGS = 8


@dataclass(frozen=True, eq=False)
class Section:
    """A cross-section around the ``centre`` (dim,), across the ``axis`` (dim,), spanned by unit
    vectors ``across`` (dim - 1, dim), of different ``scale`` (dim - 1,).

    ``reaches`` (M,) are those of its edge at equidistant angles, in the directions
    Σ scale_k across_k (cos, sin), in their units; in 2D there are two, at the angles ±π/2.
    """

    centre: Array
    axis: Array
    across: Array
    scale: Array
    reaches: Array

    @property
    def dimension(self) -> int:
        """2 or 3."""
        return len(self.centre)

    @property
    def edge(self) -> Array:
        """Points (dim, M) of the edge, from the centre."""
        return self._directions(self._angles) * self.reaches

    @property
    def narrowest(self) -> float:
        """The smallest distance of the edge from the centre."""
        return float(np.linalg.norm(self.edge, axis=0).min())

    @property
    def measure(self) -> float:
        """Area, or width in 2D."""
        if self.dimension == 2:
            return 2 * self.radius
        return float(np.pi * self.scale.prod() * (self.reaches**2).mean())

    @property
    def radius(self) -> float:
        """Of a circle of the same area, or half the width in 2D."""
        if self.dimension == 2:
            return float(np.linalg.norm(self.edge, axis=0).mean())
        return float(np.sqrt(self.measure / np.pi))

    @property
    def _angles(self) -> Array:
        if self.dimension == 2:
            return np.array([0.5, -0.5]) * np.pi
        return np.arange(RAYS) * 2 * np.pi / RAYS

    def _directions(self, angle: Array) -> Array:
        """Vectors (dim, M) of unit reach at angles (M,)."""
        if self.dimension == 2:
            return self.across[0][:, None] * self.scale[0] * np.sign(angle)
        plane = np.stack([np.cos(angle), np.sin(angle)])
        return self.across.T @ (self.scale[:, None] * plane)

    def inside(self, film: float) -> Section:
        """The section less a ``film``, with round corners: the first waves of the reaches, as large
        as they can be."""
        lengths = np.linalg.norm(self.edge, axis=0)
        inner = self.reaches * (1 - film / lengths)
        if self.dimension == 2:
            return replace(self, reaches=inner)
        modes = np.fft.rfft(self.reaches)
        modes *= np.maximum(1 - np.arange(len(modes)) / (WAVES + 1) ** 2, 0.0)
        modes[WAVES + 1 :] = 0.0
        smooth = np.fft.irfft(modes, n=RAYS)
        return replace(self, reaches=smooth * (inner / smooth).min())

    def points(self, place: Array, width: Array, angle: Array) -> Array:
        """Points (dim, N) at places along the axis, on sections ``width`` times as large, at
        angles: (N,) each."""
        reach = np.full_like(angle, self.reaches.mean())
        if self.dimension == 3:
            modes = np.fft.rfft(self.reaches) / RAYS
            for k in range(1, WAVES + 1):
                reach += 2 * (modes[k] * np.exp(1j * k * angle)).real
        aside = self._directions(angle) * reach * width
        return self.centre[:, None] + np.outer(self.axis, place) + aside


def channel_axis(enclosure: Enclosure, place: Array) -> Array:
    """The unit vector (dim,) along which the walls around a point run: across it are the normals
    of the walls that are seen from there, near ones above all.

    Raises ShapeError where there is no such direction.
    """
    directions = _even_directions(len(place))
    reach = _reach(enclosure, place, directions)
    seen = enclosure.clearance(place[:, None] + (1 - ARRIVED) * reach * directions)
    weighted = seen.normal / reach**2
    turns, vectors = np.linalg.eigh(weighted @ seen.normal.T)
    if turns[0] > FLAT * turns[1]:
        raise ShapeError(
            f"the walls around {place.tolist()} run in no clear direction; give the plug's, "
            "along=(x, y, z)"
        )
    return vectors[:, 0]


def section_at(enclosure: Enclosure, place: Array, axis: Array) -> Section:
    """The cross-section across a unit vector through a point, centred: its centre is moved to the
    middle of the section."""
    dim = len(place)
    across = np.linalg.svd(axis[None])[2][1:]
    if dim == 3 and np.linalg.det(np.stack([*across, axis])) < 0:
        across = across[::-1]
    section = Section(place, axis, across, np.ones(dim - 1), np.ones(2 if dim == 2 else RAYS))
    for number in range(CENTRINGS):
        section = _measured(enclosure, section)
        edge = section.edge
        if dim == 2:
            middle = edge.mean(axis=1)
        else:
            wedge = section.reaches**2
            middle = 2 / 3 * (edge * wedge).sum(axis=1) / wedge.sum()
        if number < CENTRINGS - 1:
            section = _turned(replace(section, centre=section.centre + middle))
    return section


def _turned(section: Section) -> Section:
    """The section with its vectors along its principal axes, as long as it is wide there."""
    if section.dimension == 2:
        return section
    flat = section.across @ section.edge
    lengths, vectors = np.linalg.eigh(flat @ flat.T / flat.shape[1])
    if lengths[1] < 1.2 * lengths[0]:
        return section
    across = vectors.T @ section.across
    if np.linalg.det(np.stack([*across, section.axis])) < 0:
        across = across * [[1.0], [-1.0]]
    wide = np.abs(across @ section.edge).max(axis=1)
    return replace(section, across=across, scale=wide / np.sqrt(wide.prod()))


def _measured(enclosure: Enclosure, section: Section) -> Section:
    """The section with the reaches that the walls leave it."""
    directions = section._directions(section._angles)
    lengths = np.linalg.norm(directions, axis=0)
    reach = _reach(enclosure, section.centre, directions / lengths)
    return replace(section, reaches=reach / lengths)


def _reach(enclosure: Enclosure, place: Array, directions: Array) -> Array:
    """Lengths (M,) of rays from a point in unit directions (dim, M) to the boundary.

    Each step is as long as the boundary is away, which is safe and soon arrives.
    """
    reach = np.zeros(directions.shape[1])
    moving = np.arange(len(reach))
    for _ in range(STEPS):
        ends = place[:, None] + reach[moving] * directions[:, moving]
        room = enclosure.clearance(ends).distance
        reach[moving] += np.maximum(room, 0.0)
        moving = moving[room > ARRIVED * reach[moving]]
        if not len(moving):
            break
    return reach


def _even_directions(dimension: int) -> Array:
    """Unit vectors (dim, M), about evenly spread."""
    if dimension == 2:
        angle = (np.arange(AROUND) + 0.5) * 2 * np.pi / AROUND
        return np.stack([np.cos(angle), np.sin(angle)])
    height = 1 - (2 * np.arange(AROUND) + 1) / AROUND
    angle = np.arange(AROUND) * np.pi * (3 - np.sqrt(5))
    return np.stack([*(np.sqrt(1 - height**2) * [np.cos(angle), np.sin(angle)]), height])
