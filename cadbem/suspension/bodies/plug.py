"""The first shape of a droplet that fills a channel's cross-section, but for a film around it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from cadbem.boundary import Boundary
from cadbem.checks import direction, instance, positive, shaped
from cadbem.errors import ShapeError
from cadbem.problems.enclosure import Enclosure
from cadbem.spline.basis import Array
from cadbem.spline.closed import ClosedBasis, ClosedSpline, closed_spline
from cadbem.spline.closed_layout import spline_residuals
from cadbem.suspension.bodies.section import Section, channel_axis, section_at
from cadbem.suspension.interface.volume import nearest_with_volume
from cadbem.suspension.surroundings.channel_flow import ChannelFlow
from cadbem.units import check

FILM = 0.15  # of the smallest half width: that of a long plug at Ca = 0.07 in a round pipe
MOST = 10.0  # times the volume of a channel, from which a plug is not worth a try
SPACING = 0.2  # of points along a plug, of its half width
FINE = 20001  # samples of the outline along a plug
INTEGRAL = 4000  # samples of its integral
COLUMNS = (12, 16, 20, 24, 32)  # points around, until these carry the cross-section
CARRIED = 1e-3  # error of the cross-section's splines, of its half width, that is small enough
SHORTEST = 0.95  # half length over half width of the shortest plug: less would not fill
LEFT = 0.5  # share of the film that must be left everywhere


def plug(
    channel: ChannelFlow | Boundary,
    at: ArrayLike,
    volume: float,
    film: float | None = None,
    along: ArrayLike | None = None,
) -> ClosedSpline:
    """A round-ended droplet of a ``volume`` (an area in 2D) that fills a channel around the point
    ``at`` (dim,), for ``Droplet``; its poles are at its ends.

    The cross-section is that of the channel, less a ``film`` all around (0.15 of the smallest half
    width, if not given) and with round corners.  It is centred between the walls and goes straight
    ``along`` a direction (dim,), that in which the walls around the point run if not given.  In a
    cross-section of area A, r = √(A/π), half the width in 2D, the outline at a place x of the axis
    is the cross-section times √(1 - (x/l)^q), with an even q next to 2 l / r, for which the ends
    have a radius of r.

    Raises ShapeError for a volume that does not fill the channel there, for a plug that does not
    fit into it straight, where the walls have no clear direction, and for a point that is not in
    the fluid; UnitsError for quantities of other dimensions.
    """
    check("at and film", (at, 0.0 if film is None else film), "length")
    positive("volume", volume)
    if film is not None:
        positive("film", film)
    boundary = channel.problem.boundary if isinstance(channel, ChannelFlow) else channel
    instance("channel", boundary, Boundary, "a ChannelFlow or a Boundary")
    whole = abs(boundary.volume())
    if volume > MOST * whole:
        raise ShapeError(f"volume is {volume:.4g}, the channel's {whole:.4g}; give a smaller one")
    enclosure, place = Enclosure(boundary), shaped("at", at, boundary.dimension)
    if not enclosure.inside(place[:, None])[0]:
        raise ShapeError(f"at={place.tolist()}: give a point in the channel's fluid")
    axis = channel_axis(enclosure, place)
    if along is not None:
        axis = direction("along", along, boundary.dimension)
    section = section_at(enclosure, place, axis)
    thickness = _thickness(section, film)
    shape = _shape(section.inside(thickness), float(volume))
    room = enclosure.clearance(shape.evaluate(shape.basis.refined(2).parameters())).distance
    if room.min() < LEFT * thickness:
        raise ShapeError(
            f"a plug of volume {float(volume):.4g} around {place.tolist()} comes within "
            f"{max(room.min(), 0.0):.3g} of the channel's boundary: it goes straight and needs a "
            "straight piece of channel; give a smaller volume, another place or film"
        )
    return shape


def _thickness(section: Section, film: float | None) -> float:
    """The film that was asked for, or the usual one."""
    thickness = FILM * section.narrowest if film is None else float(film)
    if not 0 < thickness < section.narrowest / 2:
        raise ShapeError(
            f"film={thickness:.4g}: give a thickness above 0 and below half of the channel's "
            f"smallest half width, {section.narrowest / 2:.4g}"
        )
    return thickness


def _shape(section: Section, target: float) -> ClosedSpline:
    """The plug of a cross-section and of a volume."""
    profile = _profile(section, target)
    rows = max(14, round(profile.length / (SPACING * section.radius)))
    if section.dimension == 2:
        shape = closed_spline(ClosedBasis(6, (2 * rows,)), profile)
    else:
        for columns in COLUMNS:
            shape = closed_spline(ClosedBasis(6, (rows, columns)), profile)
            around = spline_residuals(shape.basis, shape.coefficients)[1]
            if around < CARRIED * section.radius:
                break
    return nearest_with_volume(shape, target)


def _profile(section: Section, target: float) -> _Profile:
    """The outline of a plug of a volume: V = 2 A l ∫ (1 - x^q) dx = 2 A l q / (q + 1), or in 2D
    V = 4 r l ∫ √(1 - x^q) dx, over x from 0 to 1."""
    mean = target / (2 * section.measure)
    power = 2 * max(1, round(mean / section.radius))
    x = (np.arange(INTEGRAL) + 0.5) / INTEGRAL
    share = np.sqrt(1 - x**power).mean() if section.dimension == 2 else power / (power + 1)
    half = mean / float(share)
    if half < SHORTEST * section.radius:
        round_end = np.pi / 4 if section.dimension == 2 else 2 / 3
        raise ShapeError(
            f"volume={target:.4g} does not fill the channel, whose plugs have "
            f"{2 * section.measure * section.radius * round_end:.4g} or more: place a sphere, "
            "cb.spline_sphere (cb.spline_circle in 2D)"
        )
    return _Profile(section, half, power)


@dataclass(frozen=True)
class _Profile:
    """The map of the unit circle or sphere onto a plug of a half ``length``, even along it."""

    section: Section
    half: float
    power: int

    def _line(self) -> tuple[Array, Array, Array]:
        """Places along the axis, shares of the cross-section, and lengths from the front."""
        cosine = np.cos(np.linspace(0, np.pi, FINE))
        share = np.sqrt(np.maximum(1 - cosine**self.power, 0.0))
        place = self.half * cosine
        pieces = np.hypot(np.diff(place), self.section.radius * np.diff(share))
        return place, share, np.concatenate([[0.0], np.cumsum(pieces)])

    @property
    def length(self) -> float:
        """Of the outline from the front to the rear."""
        return float(self._line()[2][-1])

    def __call__(self, unit: Array) -> Array:
        """Points (dim, N) of the plug for points of the circle or sphere; those on the circle run
        from its front, those on the sphere from its north pole."""
        place, share, lengths = self._line()
        ahead = unit[0] if len(unit) == 2 else unit[2]
        from_front = np.arccos(np.clip(ahead, -1.0, 1.0)) / np.pi * lengths[-1]
        x, width = (np.interp(from_front, lengths, line) for line in (place, share))
        angle = np.sign(unit[1]) * np.pi / 2 if len(unit) == 2 else np.arctan2(unit[1], unit[0])
        return self.section.points(x, width, angle)
