"""The map of a face to the plane, and the way back for four-sided parts of it.

A plane face is only moved, and its parts become patches whose edges are exact. Other
faces are mapped by the parameters of their surface, scaled by the mean lengths of the tangents so
that angles and sizes are about those in space; parts that are not rectangles of parameters become
splines through points of the surface, within a tolerance.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import reduce
from itertools import pairwise

import numpy as np

from cadbem.cad.faces.evaluate import KernelSurface
from cadbem.cad.faces.face_geometry import (
    FLAT,
    curve_of,
    is_planar,
    located,
    parameter_box,
    plane_of,
)
from cadbem.cad.faces.surfaces import kink_lines, surface_nurbs
from cadbem.cad.kernel.brep import BrepFace, EdgeUse
from cadbem.cad.kernel.brep_geometry import CurveRecord
from cadbem.cad.layout.approximate import approximated
from cadbem.cad.layout.coons import coons_patch, joined, snapped
from cadbem.cad.layout.parts import Part, Side, along, ends_of
from cadbem.cad.layout.quality import least_element
from cadbem.cad.layout.region import Loop, Region, divided_along, merged, region_of
from cadbem.cad.layout.trimming_curves import TrimmingCurve, line
from cadbem.spline.basis import Array
from cadbem.spline.nurbs import Nurbs

TINY = 1e-9  # length of a trim, per size of the face, that is left out
JOINT = 1e-3  # distance between trims that follow each other, per size of the face

Piece = tuple[Nurbs, float]  # a patch and its largest deviation from the face
Lift = Callable[[Array], Array]  # (2, n) -> (3, n)


@dataclass(frozen=True, eq=False)
class PlaneChart:
    """Points O + x X + y Y of a plane; ∂u × ∂v of the face's surface is along X × Y."""

    regions: tuple[Region, ...]
    origin: Array
    axes: Array  # (2, 3)

    def pieces(self, part: Part, tolerance: float) -> Iterator[Piece]:
        """The part's patch; where blending its exact sides would fold it, patches within the
        tolerance."""
        try:
            sides = [reduce(joined, [trim.nurbs() for trim in side]) for side in part.sides]
            patch = coons_patch(sides)
            if least_element(patch) > 0:
                yield patch.transformed(self.axes.T, self.origin), 0.0
                return
        except ValueError:  # weights vanish inside
            pass
        yield from _blended(part, self.points, tolerance)

    def points(self, flat: Array) -> Array:
        """Points (3, n) of the plane's points (2, n)."""
        return self.axes.T @ flat + self.origin[:, None]


@dataclass(frozen=True, eq=False)
class SurfaceChart:
    """Parameters (u, v) times `scale`."""

    regions: tuple[Region, ...]
    face: BrepFace
    surface: KernelSurface
    scale: Array  # (2,)

    def pieces(self, part: Part, tolerance: float) -> Iterator[Piece]:
        """Patches of the part, several where its sides have joints."""
        box = self._rectangle(part)
        if box is not None:
            yield located(surface_nurbs(self.face.surface, *box), self.face), 0.0
            return
        yield from _blended(part, self.points, tolerance)

    def points(self, flat: Array) -> Array:
        """Points (3, n) of the surface at scaled parameters (2, n)."""
        return self.surface.points(*(flat / self.scale[:, None]))

    def _rectangle(self, part: Part) -> tuple | None:
        """The part's rectangle of parameters, if it is one."""
        corners = np.array([side[0].samples[:, 0] for side in part.sides])
        low, high = corners.min(axis=0), corners.max(axis=0)
        straight = all(len(side) == 1 and side[0].is_straight for side in part.sides)
        on_box = np.minimum(np.abs(corners - low), np.abs(corners - high)) < FLAT * (high - low)
        distinct = len(set(map(tuple, (corners > 0.5 * (low + high)).tolist()))) == 4
        fills = straight and bool(on_box.all()) and distinct  # a triangle has but three
        if not fills or self.face.surface.basis is not None:
            return None
        ends = np.stack([low, high]) / self.scale
        limits = np.array([self.surface.u, self.surface.v]).T
        close = np.abs(ends - limits) < FLAT * np.diff(limits, axis=0)
        return tuple(map(tuple, np.where(close, limits, ends).T.tolist()))


def _blended(part: Part, lift: Lift, tolerance: float) -> Iterator[Piece]:
    """Patches through points of the part, cut where trims of its sides meet."""
    ends, breaks = _ends(part.sides)
    blend = _Blend(part.sides, ends, lift)
    for u in pairwise(breaks[0].tolist()):
        for v in pairwise(breaks[1].tolist()):
            yield from approximated(blend, tolerance, (*u, *v))


@dataclass(frozen=True, eq=False)
class _Blend:
    """The map (ξ, η) -> face by blending the sides in the plane."""

    sides: tuple[Side, Side, Side, Side]
    ends: list[Array]  # shares of each side at which its trims meet
    lift: Lift

    def __call__(self, xi: Array, eta: Array) -> Array:
        places = xi, eta, 1 - xi, 1 - eta
        south, east, north, west = (
            along(side, at, ends)
            for side, at, ends in zip(self.sides, places, self.ends, strict=True)
        )
        a, b, c, d = (side[0].samples[:, :1] for side in self.sides)
        corners = (1 - xi) * (1 - eta) * a + xi * (1 - eta) * b + xi * eta * c + (1 - xi) * eta * d
        flat = (1 - eta) * south + eta * north + (1 - xi) * west + xi * east - corners
        return self.lift(flat)


def chart_of(face: BrepFace) -> PlaneChart | SurfaceChart | None:
    """The face spread out; None if its loops do not close or it lacks parameter curves."""
    return _plane_chart(face) if is_planar(face) else _surface_chart(face)


def _plane_chart(face: BrepFace) -> PlaneChart | None:
    origin, axes = plane_of(face)
    loops = []
    for uses in face.loops:
        trims = [
            _trim(_projected(use.curve, axes @ use.matrix[:3, :3],
                               axes @ (use.matrix[:3, 3] - origin)), use)
            for use in uses if use.curve is not None
        ]  # fmt: skip
        loops.append(trims)
    region = region_from(loops)
    return PlaneChart((region,), origin, axes) if region else None


def _surface_chart(face: BrepFace) -> SurfaceChart | None:
    box = parameter_box(face)
    if box is None:
        return None
    surface = KernelSurface(face.surface, *box, face.matrix)
    u, v = np.meshgrid(*[np.linspace(low, high, 7)[1:-1] for low, high in box])
    _, along_u, along_v = surface.frames(u.ravel(), v.ravel())
    scale = np.array([np.linalg.norm(t, axis=0).mean() for t in (along_u, along_v)])
    loops = [
        [_trim(_projected(curve_of(use), np.diag(scale), np.zeros(2)), use) for use in uses]
        for uses in face.loops
    ]
    region = region_from(loops, lambda flat: surface.points(*(flat / scale[:, None])))
    if region is None:
        return None
    regions = [region]
    for axis, value in kink_lines(face.surface, box):
        regions = [part for r in regions for part in divided_along(r, axis, value * scale[axis])]
    return SurfaceChart(tuple(regions), face, surface, scale)


def _trim(record: CurveRecord, use: EdgeUse) -> TrimmingCurve:
    first, last = use.interval if use.sign > 0 else use.interval[::-1]
    return TrimmingCurve(record, first, last, is_degenerate=use.curve is None)


def _projected(record: CurveRecord | None, matrix: Array, shift: Array) -> CurveRecord:
    """The image of a curve in the plane under an affine map."""
    assert record is not None
    if record.spline is not None:
        spline = replace(record.spline, points=record.spline.points @ matrix.T + shift)
        return replace(record, frame=np.zeros((0, 2)), spline=spline)
    frame = record.frame @ matrix.T
    frame[0] += shift
    return replace(record, frame=frame)


def region_from(loops: list[list[TrimmingCurve]], lift: Lift | None = None) -> Region | None:
    """Loops with their trims in order, straight ones simplified; where trims part although
    their ends are one point in space (`lift`), at a pole, a straight one is put between."""
    ends = [trim.points(np.array([0.0, 1.0])) for trims in loops for trim in trims]
    if not ends:
        return None
    size = float(np.ptp(np.concatenate(ends, axis=1), axis=1).max())
    size = max(size, *(float(np.ptp(s.samples, axis=1).max()) for lp in loops for s in lp))
    closed = [_closed(trims, size, lift) for trims in loops]
    if not all(closed):
        return None
    return region_of([loop for loop in closed if loop])


def _closed(trims: list[TrimmingCurve], size: float, lift: Lift | None) -> Loop | None:
    """A wire lists its edges in any order: follow them from end to end."""
    parts = [part for trim in trims for part in trim.smooth_parts()]
    free = [_simple(part) for part in parts if part.length > TINY * size]
    if not free:
        return None
    chain = [free.pop(0)]
    while free:
        here = chain[-1].samples[:, -1]
        gaps = [float(np.hypot(*(trim.samples[:, 0] - here))) for trim in free]
        following = int(np.argmin(gaps))
        bridge = _bridge(here, free[following].samples[:, 0], size, lift)
        if bridge is None:
            return None
        chain += [*bridge, free.pop(following)]
    bridge = _bridge(chain[-1].samples[:, -1], chain[0].samples[:, 0], size, lift)
    return None if bridge is None else merged((*chain, *bridge))


def _bridge(start: Array, end: Array, size: float, lift: Lift | None) -> Loop | None:
    """The trims to insert between two trims: none, a degenerate edge, or None if they do not
    meet."""
    if np.hypot(*(end - start)) <= JOINT * size:
        return ()
    if lift is None:
        return None
    gap = np.linalg.norm(np.diff(lift(np.stack([start, end], axis=1))))
    return (line(start, end, is_degenerate=True),) if gap <= JOINT * size else None


def _simple(trim: TrimmingCurve) -> TrimmingCurve:
    if not trim.is_straight:
        return trim
    return line(trim.samples[:, 0], trim.samples[:, -1], trim.is_degenerate)


def _ends(sides: tuple[Side, Side, Side, Side]) -> tuple[list[Array], list[Array]]:
    """Shares of each side's length at which its trims meet, and all of them in ξ and in η: those
    of opposite sides that nearly agree are made one."""
    ends = [ends_of(side) for side in sides]
    breaks = []
    for k in (0, 1):
        facing = snapped((1 - ends[k + 2])[::-1], ends[k])
        ends[k + 2] = (1 - facing)[::-1]
        breaks.append(np.unique(np.concatenate([ends[k], facing])))
    return ends, breaks
