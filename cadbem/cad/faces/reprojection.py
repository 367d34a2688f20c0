"""Parameter curves made anew where those of a file are off edges that do lie on the face.

A file holds an edge both in space and in the parameters of the surface; some programs write the
latter roughly, or run along it at another pace. The edge in space counts.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import numpy as np
from scipy.interpolate import make_interp_spline

from cadbem.cad.faces.evaluate import KernelSurface, curve_point
from cadbem.cad.faces.face_geometry import curve_of, parameter_box, size_of
from cadbem.cad.kernel.brep import BrepFace, EdgeUse
from cadbem.cad.kernel.brep_geometry import BSPLINE, PLANE, CurveRecord, SplineRecord
from cadbem.errors import CadError
from cadbem.spline.basis import Array

OFF = 1e-6  # distance of a parameter curve from its edge, per size of the face, that is too much
ON = 1e-7  # distance of an edge from the face, per size, up to which it lies on it
SAMPLES = 65
STEPS = 12
FAR = 0.05  # distance of the first guess, per size, from which nothing is tried


def reprojected(faces: Iterable[BrepFace]) -> tuple[tuple[BrepFace, ...], int]:
    """The faces with parameter curves made anew where that helps, and the number of these."""
    found, count = [], 0
    for face in faces:
        new = [[_renewed(face, use) for use in loop] for loop in face.loops]
        changed = [n for loop, old in zip(new, face.loops, strict=True)
                   for n, o in zip(loop, old, strict=True) if n is not o]  # fmt: skip
        count += len(changed)
        found.append(replace(face, loops=tuple(map(tuple, new))) if changed else face)
    return tuple(found), count


def _renewed(face: BrepFace, use: EdgeUse) -> EdgeUse:
    """The pass with its curve projected to the face, where it has to be and can be."""
    box = parameter_box(face)
    if use.curve is None or face.surface.kind == PLANE or box is None:
        return use
    if len(use.parameter_curves) != 1:  # a seam: both of its curves are sides of the parameters
        return use
    surface, size = KernelSurface(face.surface, *box, face.matrix), size_of(face)
    t = np.linspace(*use.interval, SAMPLES)
    try:
        edge = use.matrix[:3, :3] @ curve_point(use.curve, t)[0] + use.matrix[:3, 3:]
        guess = curve_point(curve_of(use), t)[0]
        off = np.linalg.norm(surface.points(*guess) - edge, axis=0).max()
        if not OFF * size < off < FAR * size:
            return use
        places, gap = _projected(surface, guess, edge)
    except (CadError, np.linalg.LinAlgError):
        return use
    if gap > ON * size:
        return use
    spline = make_interp_spline(t, places.T, k=3)
    record = SplineRecord((3,), (spline.t,), spline.c, np.ones(len(spline.c)), (False,))
    renewed = CurveRecord(BSPLINE, np.zeros((0, 2)), spline=record)
    middle = 0.5 * (t[1:] + t[:-1])
    there = use.matrix[:3, :3] @ curve_point(use.curve, middle)[0] + use.matrix[:3, 3:]
    between = np.linalg.norm(surface.points(*curve_point(renewed, middle)[0]) - there, axis=0)
    return replace(use, parameter_curves=(renewed,)) if between.max() < off else use


def _projected(surface: KernelSurface, guess: Array, points: Array) -> tuple[Array, float]:
    """Parameters (2, n) of the surface's points nearest to points (3, n), by Newton's method
    without second derivatives, and the largest distance left."""
    at = guess.copy()
    for _ in range(STEPS):
        place, *tangents = surface.frames(*at)
        slope = np.stack(tangents, axis=-1).transpose(1, 0, 2)  # (n, 3, 2)
        step = np.linalg.pinv(slope) @ (points - place).T[:, :, None]
        at += step[:, :, 0].T
    return at, float(np.linalg.norm(surface.points(*at) - points, axis=0).max())
