"""Area of a face and volume under it, from the edges alone: no patches are needed.

With S = ∂u × ∂v, the flux (1/3) ∬ x·S du dv over the face is, by Green's theorem in the plane of
parameters, (1/3) ∮ F dv along its loops, F(u, v) = ∫ x·S du from a fixed u to u; with |S| for x·S/3
it is the area. The sum of fluxes over the faces of a closed shell is the volume it encloses,
positive if every S points out.
"""

from __future__ import annotations

import numpy as np

from cadbem.cad.faces.curves import Interval
from cadbem.cad.faces.evaluate import KernelSurface
from cadbem.cad.faces.face_geometry import parameter_box, parameter_curves
from cadbem.cad.faces.surfaces import splines_of, unrolled_knots
from cadbem.cad.kernel.brep import BrepFace
from cadbem.cad.kernel.brep_geometry import SurfaceRecord
from cadbem.errors import CadError
from cadbem.points import area_vector
from cadbem.quadrature.gauss import gauss_unit
from cadbem.spline.basis import Array
from cadbem.spline.nurbs import Nurbs

ORDER = 8  # Gauss points on each piece of an edge, and on each piece of a line v = const
LEAST, MOST = 4, 64  # pieces


def face_flux(face: BrepFace, centre: Array) -> float:
    """(1/3) ∬ (x - centre)·(∂u × ∂v) du dv over the face, of the located surface.

    Eight digits or so, fewer on surfaces with many spans. Raises CadError if an edge has no
    parameter curve, and for surfaces that cannot be evaluated.
    """
    return float(_integrals(face, centre)[1])


def face_area(face: BrepFace) -> float:
    """∬ |∂u × ∂v| du dv over the face, in the same way; raises CadError as `face_flux` does."""
    return float(abs(_integrals(face, np.zeros(3))[0]))


def _integrals(face: BrepFace, centre: Array) -> Array:
    """Area, up to its sign, and flux."""
    box, curves = parameter_box(face), parameter_curves(face)
    if box is None:
        raise CadError(f"face {face.number} has an edge without a parameter curve")
    surface = KernelSurface(face.surface, *box, face.matrix)
    uses = [use for loop in face.loops for use in loop]
    parts = zip(uses, curves, strict=True)
    return sum(
        (use.sign * _edge_integrals(surface, curve, centre) for use, curve in parts), np.zeros(2)
    )


def _edge_integrals(surface: KernelSurface, curve: Nurbs, centre: Array) -> Array:
    if (curve.points[:, 1] == curve.points[0, 1]).all():
        return np.zeros(2)  # dv = 0
    nodes, weights = gauss_unit(ORDER)
    ends = _pieces(_joints(surface, curve))
    steps = np.diff(ends)[:, None]
    t, t_weights = (ends[:-1, None] + steps * nodes).ravel(), (steps * weights).ravel()
    derivatives = curve.derivatives(1, t)
    (u, v), dv = derivatives[(0,)], derivatives[(1,)][1]
    breaks = _pieces(_breaks(surface.record, 0, surface.u))
    ends = np.minimum(breaks, u[:, None])
    ends[:, 0], ends[:, -1] = breaks[0], u  # edges may bulge out of the rectangle
    lengths = np.diff(ends, axis=1)
    across = ends[:, :-1, None] + lengths[:, :, None] * nodes
    along = np.broadcast_to(v[:, None, None], across.shape)
    x, x_u, x_v = surface.frames(across.ravel(), along.ravel())
    normal = area_vector(x_u, x_v)
    values = np.linalg.norm(normal, axis=0), ((x - centre[:, None]) * normal).sum(axis=0) / 3
    inner = [(w.reshape(across.shape) @ weights * lengths).sum(axis=1) for w in values]
    return np.array(inner) @ (t_weights * dv)


def _pieces(breaks: Array) -> Array:
    """Ends of LEAST to MOST pieces, at the breaks as far as that allows."""
    count = len(breaks) - 1
    if count >= LEAST:
        return breaks[np.unique(np.linspace(0, count, min(count, MOST) + 1).astype(int))]
    parts = -(-LEAST // count)
    fine = breaks[:-1, None] + np.diff(breaks)[:, None] * np.arange(parts) / parts
    return np.append(fine.ravel(), breaks[-1])


def _joints(surface: KernelSurface, curve: Nurbs) -> Array:
    """Parameters of an edge where it, or the surface under it, changes to another polynomial."""
    joints = np.unique(curve.knots[0])
    if len(curve.points) > 2:
        return joints
    first, last = curve.points[:, 1]  # a straight line in the plane of parameters
    if first == last:
        return joints
    rows = _breaks(surface.record, 1, (min(first, last), max(first, last)))
    across = joints[0] + (rows - first) / (last - first) * (joints[-1] - joints[0])
    return np.unique(np.clip([*joints, *across], *joints[[0, -1]]))


def _breaks(surface: SurfaceRecord, axis: int, interval: Interval) -> Array:
    """The interval of a parameter, cut where a spline surface's pieces meet."""
    breaks = list(interval)
    for own, spline, along in splines_of(surface):
        if own == axis:
            knots = unrolled_knots(spline, along)
            breaks += knots[(knots > interval[0]) & (knots < interval[1])].tolist()
    return np.unique(breaks)
