"""Loops that pass the seam of a closed surface: their curves in one piece of the parameters."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from cadbem.cad.faces.evaluate import curve_point
from cadbem.cad.faces.face_geometry import curve_of
from cadbem.cad.kernel.brep import BrepFace, EdgeUse
from cadbem.cad.kernel.brep_geometry import (
    CONE,
    CYLINDER,
    REVOLUTION,
    SPHERE,
    TORUS,
    CurveRecord,
    SurfaceRecord,
)
from cadbem.spline.basis import Array

ROUND = (CYLINDER, CONE, SPHERE, TORUS, REVOLUTION)  # the first parameter is an angle
MEET = 1e-3  # distance between parameters of curves that follow each other, per extent
SAMPLES = 17


@dataclass(frozen=True, eq=False)
class ParameterLoop:
    """Passes of a loop, whose curves follow each other in the parameter plane once they are moved
    by `shifts` (n, 2), and the area that they run round: negative for a hole."""

    uses: tuple[EdgeUse, ...]
    shifts: Array
    area: float
    middle: float  # of the first parameter


def parameter_loop(face: BrepFace, uses: Sequence[EdgeUse]) -> ParameterLoop | None:
    """None if curves are missing, or if the loop does not close, as one round the axis."""
    lines = [line for line in map(_sampled, uses) if line is not None]
    if not lines or len(lines) < len(uses):
        return None
    shifts, placed = [np.zeros(2)], [lines[0]]
    for line in lines[1:]:
        shifts.append(_turns(face, placed[-1][:, -1] - line[:, 0]))
        placed.append(line + shifts[-1][:, None])
    points: Array = np.concatenate(placed, axis=1)
    ends = np.array([[part[:, 0], part[:, -1]] for part in placed])
    gaps = np.abs(np.roll(ends[:, 0], -1, axis=0) - ends[:, 1]).max()
    if gaps > MEET * np.ptp(points, axis=1).max():
        return None
    x, y = points - points[:, :1]
    area = 0.5 * float(x @ np.roll(y, -1) - y @ np.roll(x, -1))
    middle = 0.5 * float(points[0].min() + points[0].max())
    return ParameterLoop(tuple(uses), np.array(shifts), area, middle)


def filled(face: BrepFace, loop: ParameterLoop) -> BrepFace | None:
    """The piece of the face's surface in a hole: number 0, border against the hole's. None if its
    curves pass a seam that cannot be moved."""
    turn, matrix = np.zeros(2), face.matrix
    if face.surface.kind in ROUND:
        angle = loop.middle - np.pi
        turn, matrix = np.array([-angle, 0.0]), face.matrix @ _rotation(face.surface, angle)
    elif loop.shifts.any():
        return None
    around = tuple(
        replace(use, sign=-use.sign, parameter_curves=(moved(curve_of(use), shift + turn),))
        for use, shift in zip(loop.uses, loop.shifts, strict=True)
    )
    return replace(face, number=0, matrix=matrix, loops=(around[::-1],))


def _rotation(surface: SurfaceRecord, angle: float) -> Array:
    """The matrix (4, 4) that turns a surface about its axis, as its first parameter does."""
    origin = surface.frame[0]
    axis = surface.frame[1] if surface.kind == REVOLUTION else np.cross(*surface.frame[2:])
    x, y, z = axis / np.linalg.norm(axis)
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    matrix = np.eye(4)
    matrix[:3, :3] += np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross
    matrix[:3, 3] = origin - matrix[:3, :3] @ origin
    return matrix


def moved(record: CurveRecord, shift: Array) -> CurveRecord:
    """A plane curve moved by a vector (2,)."""
    if record.spline is not None:
        return replace(record, spline=replace(record.spline, points=record.spline.points + shift))
    if record.basis is not None:
        return replace(record, basis=moved(record.basis, shift))
    return replace(record, frame=np.concatenate([record.frame[:1] + shift, record.frame[1:]]))


def _sampled(use: EdgeUse) -> Array | None:
    """Parameters (2, n) along a pass, as the loop runs; None without a parameter curve."""
    if not use.parameter_curves:
        return None
    first, last = use.interval[:: use.sign]
    t = np.linspace(first, last, SAMPLES)
    return curve_point(curve_of(use), t)[0]


def _turns(face: BrepFace, gap: Array) -> Array:
    """The whole turns nearest to a gap of parameters (2,)."""
    if face.surface.kind not in ROUND:
        return np.zeros(2)
    turns = 2 * np.pi * np.round(gap / (2 * np.pi))
    return turns if face.surface.kind == TORUS else turns * [1.0, 0.0]
