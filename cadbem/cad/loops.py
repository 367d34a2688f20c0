"""The border of a plane face: its loops as sides, or as one circle or ellipse."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from cadbem.cad.brep import BrepFace, EdgeUse
from cadbem.cad.brep_geometry import CIRCLE, ELLIPSE, PLANE, CurveRecord
from cadbem.cad.coons import joined, segment
from cadbem.cad.curves import arc
from cadbem.cad.face_geometry import FLAT, located, parameter_box, world_curve
from cadbem.cad.surfaces import surface_nurbs
from cadbem.spline.basis import Array
from cadbem.spline.nurbs import Nurbs

SHARPEST = 0.02  # sine of the smallest angle that counts as a corner


@dataclass(frozen=True, eq=False)
class Conic:
    """A whole circle or ellipse O + cos t X + sin t Y; the file's first edge starts at `start`."""

    origin: Array
    x: Array
    y: Array
    start: float

    def angle(self, point: Array) -> float:
        """The t at which a ray from O to a point of the plane meets it."""
        arm = point - self.origin
        return float(np.arctan2(arm @ self.y / (self.y @ self.y), arm @ self.x / (self.x @ self.x)))

    def arc(self, start: float, end: float) -> Nurbs:
        """The piece from one angle to another, which may be smaller."""
        piece = arc(self.origin, self.x, self.y, (min(start, end), max(start, end)))
        return piece if start < end else piece.reversed()


def conic_loop(face: BrepFace, loop: int = 0) -> Conic | None:
    """One loop of a plane face as a circle or ellipse, if all its edges are arcs of one."""
    if loop >= len(face.loops) or not _is_planar(face):
        return None
    uses = face.loops[loop]
    conics = [use.curve for use in uses if use.curve and use.curve.kind in (CIRCLE, ELLIPSE)]
    turn = sum(use.interval[1] - use.interval[0] for use in uses)
    if not conics or len(conics) != len(uses) or abs(turn - 2 * np.pi) > 1e-6:
        return None
    if not all(_same_conic(conics[0], conic) for conic in conics):
        return None
    origin, x, y = conics[0].frame
    turning, shift = uses[0].matrix[:3, :3], uses[0].matrix[:3, 3]
    a, b = conics[0].sizes[0], conics[0].sizes[-1]
    start = uses[0].interval[0]
    return Conic(turning @ origin + shift, a * turning @ x, b * turning @ y, start)


def _is_planar(face: BrepFace) -> bool:
    """A plane, or a spline surface whose control points lie in one."""
    if face.surface.kind == PLANE:
        return True
    box = parameter_box(face)
    if box is None or face.surface.basis is not None:
        return False
    points = surface_nurbs(face.surface, *box).points.reshape(-1, 3)
    sizes = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
    return bool(sizes[2] < FLAT * sizes[0])


def _chained(uses: tuple[EdgeUse, ...]) -> list[EdgeUse]:
    """A wire lists its edges in any order: follow them from vertex to vertex; [] if they part."""
    if not uses or any(use.curve is None for use in uses):
        return []
    ends = np.array([use.ends[:: use.sign] for use in uses])
    tolerance = 1e-5 * np.ptp(ends.reshape(-1, 3), axis=0).max()
    chain, free = [0], np.ones(len(uses), dtype=bool)
    free[0] = False
    while free.any():
        gaps = np.where(free, np.linalg.norm(ends[:, 0] - ends[chain[-1], 1], axis=1), np.inf)
        following = int(np.argmin(gaps))
        if gaps[following] > tolerance:
            return []
        chain.append(following)
        free[following] = False
    return [uses[index] for index in chain]


def _along_loop(use: EdgeUse) -> Nurbs:
    curve = world_curve(use)
    assert curve is not None
    return curve if use.sign > 0 else curve.reversed()


def loop_edges(face: BrepFace, loop: int = 0) -> list[Nurbs]:
    """The edges of one loop of a plane face, in its direction; [] if it is not such.

    Straight edges that continue each other are one.
    """
    if loop >= len(face.loops) or not _is_planar(face):
        return []
    edges = [_along_loop(use) for use in _chained(face.loops[loop])]
    return _merged(edges, _continues, lambda a, b: segment(a.points[0], b.points[-1]))


def loop_sides(face: BrepFace, loop: int = 0) -> list[Nurbs]:
    """As `loop_edges`, but all edges between two corners are one curve, with a kink in it."""
    return _merged(loop_edges(face, loop), _is_smooth, joined)


def _merged(
    curves: list[Nurbs],
    belong: Callable[[Nurbs, Nurbs], bool],
    merge: Callable[[Nurbs, Nurbs], Nurbs],
) -> list[Nurbs]:
    """Neighbours round the loop that belong together, merged."""
    merged = curves[:1]
    for curve in curves[1:]:
        if belong(merged[-1], curve):
            merged[-1] = merge(merged[-1], curve)
        else:
            merged.append(curve)
    if len(merged) > 1 and belong(merged[-1], merged[0]):
        merged[0] = merge(merged.pop(), merged[0])
    return merged


def _is_smooth(first: Nurbs, second: Nurbs) -> bool:
    """Whether the second goes on in the direction in which the first ends."""
    ahead, onward = first.points[-1] - first.points[-2], second.points[1] - second.points[0]
    product = np.linalg.norm(ahead) * np.linalg.norm(onward)
    turn = np.linalg.norm(np.cross(ahead, onward))
    return bool(turn < SHARPEST * product and ahead @ onward > 0)


def _continues(first: Nurbs, second: Nurbs) -> bool:
    points = np.concatenate([first.points, second.points])
    chord = points[-1] - points[0]
    length = np.linalg.norm(chord)
    if length == 0:
        return False
    steps = (points - points[0]) @ chord / length
    off = np.linalg.norm(points - points[0] - np.outer(steps, chord / length), axis=1)
    return bool(off.max() < FLAT * length and (np.diff(steps) > -FLAT * length).all())


def normal(face: BrepFace) -> Array:
    """Unit ∂u × ∂v of a planar face's surface."""
    box = parameter_box(face) or ((0.0, 1.0), (0.0, 1.0))
    surface = located(surface_nurbs(face.surface, *box), face)
    middle = [0.5 * (low + high) for low, high in surface.domain]
    tangents = surface.derivatives(1, *middle)
    direction = np.cross(tangents[1, 0], tangents[0, 1])
    return direction / np.linalg.norm(direction)


def _same_conic(first: CurveRecord, second: CurveRecord) -> bool:
    size = max(first.sizes)
    same_centre = np.allclose(first.frame[0], second.frame[0], rtol=0, atol=FLAT * size)
    same_axes = first.kind == CIRCLE or np.allclose(abs(first.frame), abs(second.frame))
    return bool(same_centre and same_axes and np.allclose(first.sizes, second.sizes, rtol=FLAT))
