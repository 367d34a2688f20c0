"""Points and tangents of the CAD kernel's curves and surfaces in the kernel's own parameters.

The parametrisations are those of `curves.py` and `surfaces.py`. Parameter curves of faces refer to
them, while the exact NURBS of a circle runs through its angles unevenly.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from cadbem.cad.faces.curves import Interval, spline_domain, spline_nurbs
from cadbem.cad.kernel.brep_geometry import (
    CIRCLE,
    CONE,
    ELLIPSE,
    EXTRUSION,
    HYPERBOLA,
    LINE,
    OFFSET,
    PLANE,
    REVOLUTION,
    SPHERE,
    TORUS,
    CurveRecord,
    SplineRecord,
    SurfaceRecord,
)
from cadbem.errors import CadError
from cadbem.spline.basis import Array
from cadbem.spline.nurbs import Nurbs

STEP = 1e-5  # share of the parameters' range for differences of an offset's normals

Frame = tuple[Array, Array, Array]  # point, ∂u, ∂v: (3, n) each


def curve_point(record: CurveRecord, t: Array, spline: Nurbs | None = None) -> tuple[Array, Array]:
    """Point and tangent (dim, n) at parameters (n,). `spline` holds them if the record is one."""
    if record.spline is not None:
        curve = spline or spline_nurbs(record.spline, ((float(t.min()), float(t.max())),))
        found = curve.derivatives(1, np.clip(t, *curve.domain[0]))
        return found[(0,)], found[(1,)]
    if record.kind == LINE:
        origin, direction = record.frame[:, :, None]
        return origin + direction * t, direction + 0 * t
    if record.kind == OFFSET:
        raise CadError("an offset curve has no exact NURBS")
    origin, x, y = record.frame[:, :, None]
    a, b = record.sizes[0], record.sizes[-1]
    if record.kind in (CIRCLE, ELLIPSE):
        return (
            origin + a * np.cos(t) * x + b * np.sin(t) * y,
            -a * np.sin(t) * x + b * np.cos(t) * y,
        )
    if record.kind == HYPERBOLA:
        return (
            origin + a * np.cosh(t) * x + b * np.sinh(t) * y,
            a * np.sinh(t) * x + b * np.cosh(t) * y,
        )
    focal = 4 * a  # a parabola
    return origin + t * t / focal * x + t * y, 2 * t / focal * x + y


@dataclass(frozen=True, eq=False)
class KernelSurface:
    """A surface over the rectangle [u] × [v] of the kernel's parameters, placed by `matrix`."""

    record: SurfaceRecord
    u: Interval
    v: Interval
    matrix: Array  # (4, 4)

    def points(self, u: Array, v: Array) -> Array:
        """Points (3, n) at parameters (n,)."""
        return self.frames(u, v)[0]

    def frames(self, u: Array, v: Array) -> Frame:
        """Point, ∂u and ∂v."""
        point, along_u, along_v = self._local(self.record, u, v)
        turn, shift = self.matrix[:3, :3], self.matrix[:3, 3:]
        return turn @ point + shift, turn @ along_u, turn @ along_v

    def _local(self, record: SurfaceRecord, u: Array, v: Array) -> Frame:
        if record.basis is not None:
            return self._offset(record.basis, record.sizes[0], u, v)
        if record.spline is not None:
            patch = self._spline
            ends = patch.domain
            found = patch.derivatives(1, np.clip(u, *ends[0]), np.clip(v, *ends[1]))
            return found[0, 0], found[1, 0], found[0, 1]
        if record.kind == PLANE:
            origin, _, x, y = record.frame[:, :, None]
            return origin + u * x + v * y, x + 0 * u, y + 0 * u
        if record.kind == EXTRUSION and record.curve is not None:
            point, tangent = curve_point(record.curve, u, self._profile)
            return point + v * record.frame[0][:, None], tangent, record.frame[0][:, None] + 0 * u
        if record.kind == REVOLUTION and record.curve is not None:
            origin, axis = record.frame
            return _turned(origin, axis, *curve_point(record.curve, v, self._profile), u)
        return _quadric(record, u, v)

    @cached_property
    def _spline(self) -> Nurbs:
        record = self.record
        while record.basis is not None:
            record = record.basis
        assert record.spline is not None
        limits = [spline_domain(record.spline, axis) for axis in (0, 1)]
        return spline_nurbs(
            record.spline, (_widened(self.u, limits[0]), _widened(self.v, limits[1]))
        )

    @cached_property
    def _profile(self) -> Nurbs | None:
        record = self.record
        while record.basis is not None:
            record = record.basis
        spline: SplineRecord | None = record.curve.spline if record.curve else None
        along = self.u if record.kind == EXTRUSION else self.v
        if spline is None:
            return None
        return spline_nurbs(spline, (_widened(along, spline_domain(spline, 0)),))

    def _offset(self, basis: SurfaceRecord, distance: float, u: Array, v: Array) -> Frame:
        """Basis + distance × its unit normal; tangents by central differences of the normal."""
        point, along_u, along_v = self._local(basis, u, v)
        shift = distance * self._normal(basis, u, v)
        steps = STEP * (self.u[1] - self.u[0]), STEP * (self.v[1] - self.v[0])
        bend_u = self._normal(basis, u + steps[0], v) - self._normal(basis, u - steps[0], v)
        bend_v = self._normal(basis, u, v + steps[1]) - self._normal(basis, u, v - steps[1])
        return (
            point + shift,
            along_u + distance * bend_u / (2 * steps[0]),
            along_v + distance * bend_v / (2 * steps[1]),
        )

    def _normal(self, basis: SurfaceRecord, u: Array, v: Array) -> Array:
        _, along_u, along_v = self._local(basis, u, v)
        normal = np.cross(along_u, along_v, axis=0)
        return normal / np.linalg.norm(normal, axis=0)


def _widened(interval: Interval, limits: Interval) -> Interval:
    """A little more, within the limits: edges bulge between the points that gave the interval."""
    margin = 0.02 * (interval[1] - interval[0])
    return max(interval[0] - margin, limits[0]), min(interval[1] + margin, limits[1])


def _quadric(record: SurfaceRecord, u: Array, v: Array) -> Frame:
    """Cylinder, cone, sphere, torus: O + r(v) e(u) + z(v) Z."""
    origin, z, x, y = record.frame[:, :, None]
    radius, rise, slope, climb = _profile_at(record, v)
    outward, sideways = np.cos(u) * x + np.sin(u) * y, -np.sin(u) * x + np.cos(u) * y
    return (
        origin + radius * outward + rise * z,
        radius * sideways,
        slope * outward + climb * z,
    )


def _profile_at(record: SurfaceRecord, v: Array) -> tuple[Array, Array, Array, Array]:
    """r, z, dr/dv, dz/dv."""
    size = record.sizes[0]
    if record.kind == SPHERE:
        return size * np.cos(v), size * np.sin(v), -size * np.sin(v), size * np.cos(v)
    if record.kind == TORUS:
        minor = record.sizes[1]
        sine, cosine = minor * np.sin(v), minor * np.cos(v)
        return size + cosine, sine, -sine, cosine
    angle = record.sizes[1] if record.kind == CONE else 0.0
    sine, cosine = np.sin(angle) + 0 * v, np.cos(angle) + 0 * v
    return size + v * sine, v * cosine, sine, cosine


def _turned(origin: Array, axis: Array, point: Array, tangent: Array, angle: Array) -> Frame:
    """A curve turned about an axis."""
    axis = (axis / np.linalg.norm(axis))[:, None]

    def rotated(vector: Array) -> tuple[Array, Array]:
        along = axis * (axis * vector).sum(axis=0)
        radial, sideways = vector - along, np.cross(axis, vector, axis=0)
        turned = along + np.cos(angle) * radial + np.sin(angle) * sideways
        return turned, -np.sin(angle) * radial + np.cos(angle) * sideways

    place, along_u = rotated(point - origin[:, None])
    return origin[:, None] + place, along_u, rotated(tangent)[0]
