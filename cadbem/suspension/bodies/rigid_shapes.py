"""Rigid particles of simple shapes."""

from __future__ import annotations

from numpy.typing import ArrayLike

from cadbem.boundary import Boundary, Patch
from cadbem.checks import one_of, positive, positive_array, whole
from cadbem.spline.outlines import ellipse
from cadbem.spline.shapes import ellipsoid
from cadbem.suspension.bodies.particle import RigidParticle
from cadbem.units import check


def rigid_ellipsoid(
    semi_axes: ArrayLike, position: ArrayLike | None = None, *, degree: int = 4, spans: int = 3
) -> RigidParticle:
    """A rigid ellipsoid, or in a plane an ellipse, around ``position``, by default the origin.

    Six patches (four arcs) with ``spans`` elements a direction, of at least the ``degree``: 294
    (28) points by default.  Raises ``UnitsError`` for quantities that are not lengths.
    """
    check("radius or semi-axis", semi_axes, "length")
    check("position", position, "length")
    axes = positive_array("semi_axes", semi_axes, None)
    one_of("the number of semi_axes", len(axes), (2, 3))
    whole("degree", degree)
    whole("spans", spans)
    patches = ellipsoid(axes) if len(axes) == 3 else ellipse(axes)
    shape = Boundary(tuple(Patch(p, "particle") for p in patches)).elevated(degree).refined(spans)
    return RigidParticle(shape, position)


def rigid_sphere(
    radius: float = 1.0, position: ArrayLike | None = None, *, degree: int = 4, spans: int = 3
) -> RigidParticle:
    """A rigid sphere: see ``rigid_ellipsoid``."""
    check("radius", radius, "length")
    positive("radius", radius)
    return rigid_ellipsoid((radius,) * 3, position, degree=degree, spans=spans)
