"""The boundary of a body of fluid: NURBS patches with names and normals into the fluid."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from cadbem.checks import finite, instance, not_negative, positive, shaped, vector, whole
from cadbem.errors import InputError, SelectionError, printable
from cadbem.overviews import boundary_overview
from cadbem.points import SurfacePoints, gauss_measures, join, surface_points
from cadbem.quadrature.gauss import gauss_on_breaks, tensor_rule
from cadbem.refinement import Predicate, Size, count_rule, edge_rule, size_rule, spans_rule
from cadbem.spline.basis import Array
from cadbem.spline.nurbs import Nurbs
from cadbem.spline.project import closest_point

Selector = str | int | Sequence[int] | Sequence[float] | Predicate


MOST_DEGREE, MOST_LEVELS, MOST_ORDER = 20, 100, 1000


@dataclass(frozen=True, eq=False)
class Patch:
    """One smooth NURBS patch; its normal (see ``surface_points``) points into the fluid.

    ``name`` groups patches for conditions; ``face`` is the 1-based number of the CAD face. A
    ``port`` was found as an opening when the file was read: it is no wall, whatever the rest is.
    """

    surface: Nurbs
    name: str = ""
    face: int = 0
    port: bool = False

    def __post_init__(self) -> None:
        instance("surface", self.surface, Nurbs, "a Nurbs curve or surface")
        instance("name", self.name, str, "text")
        object.__setattr__(self, "name", printable(self.name))
        if not np.isfinite(self.surface.points).all():
            raise InputError("the surface's points are not all finite; give finite coordinates")

    def middle(self) -> SurfacePoints:
        """The point in the middle of the parameter domain."""
        return surface_points(self.surface, *[0.5 * (a + b) for a, b in self.surface.domain])

    def quadrature(self, order: int) -> tuple[SurfacePoints, Array]:
        """Gauss points, ``order`` a direction in each element, and weights (with Jacobian)."""
        whole("order", order, 1, MOST_ORDER)
        rules = [
            gauss_on_breaks(order, self.surface.breaks(d)) for d in range(len(self.surface.degrees))
        ]
        parameters, weights = tensor_rule(rules)
        points = surface_points(self.surface, *parameters)
        return points, weights * points.jacobian


@dataclass(frozen=True, eq=False)
class Boundary:
    """Patches that enclose the fluid, in one unit of length (``unit``, "" if dimensionless)."""

    patches: tuple[Patch, ...]
    source: str = ""
    unit: str = ""

    def __post_init__(self) -> None:
        instance("patches", self.patches, tuple | list, "Patches, as a tuple")
        kinds = {(p.surface.dimension, len(p.surface.degrees)) if isinstance(p, Patch) else None
                 for p in self.patches}  # fmt: skip
        if len(kinds) > 1 or None in kinds:
            raise InputError("patches are not what they should be; give Patches of one dimension")
        object.__setattr__(self, "source", printable(self.source))
        object.__setattr__(self, "unit", printable(self.unit))

    def __repr__(self) -> str:
        return boundary_overview(self).text()

    def _repr_html_(self) -> str:
        return boundary_overview(self).html()

    @property
    def names(self) -> tuple[str, ...]:
        """Names in use, sorted."""
        return tuple(sorted({p.name for p in self.patches}))

    @property
    def dimension(self) -> int:
        """2 for curves in a plane, 3 for surfaces in space."""
        if not self.patches:
            raise InputError("the boundary has no patches; give it at least one")
        return self.patches[0].surface.dimension

    def named(self, rest: str | None = None, **selectors: Selector) -> Boundary:
        """Give names to patches; those not selected keep theirs, or become ``rest`` (ports do not).

        A selector is an existing name, a CAD face number or several, a point on the face, or a
        predicate ``f(position, normal) -> bool`` that is evaluated in the middle of each patch.
        Raises ``SelectionError`` when one selects nothing, or two select the same face.
        """
        chosen: dict[int, str] = {}
        for name, selector in selectors.items():
            for index in self._selected(name, selector):
                if index in chosen:
                    raise SelectionError(
                        f"{self.label(index)} is selected both as '{chosen[index]}' and as "
                        f"'{name}'; make the selectors exclude each other"
                    )
                chosen[index] = name
        patches = [
            replace(p, name=chosen.get(i, p.name if rest is None or p.port else rest))
            for i, p in enumerate(self.patches)
        ]
        return replace(self, patches=tuple(patches))

    def select(self, selector: Selector) -> tuple[int, ...]:
        """Indices of the patches that a selector (see ``named``) chooses."""
        return tuple(self._selected("select", selector))

    def _selected(self, name: str, selector: Selector) -> list[int]:
        indices = self._matches(name, selector)
        if not indices:
            faces = "; ".join(self.label(i) for i in range(min(len(self.patches), 30)))
            raise SelectionError(
                f"'{name}' selects no face of {self.source or 'the boundary'} "
                f"({selector!r}); there are: {faces}"
            )
        return indices

    def _matches(self, name: str, selector: Selector) -> list[int]:
        numbered = list(enumerate(self.patches))
        if isinstance(selector, str):
            return [i for i, p in numbered if p.name == selector]
        if isinstance(selector, int):
            return [i for i, p in numbered if p.face == selector]
        if callable(selector):
            middles = [p.middle() for p in self.patches]
            return [i for i, m in enumerate(middles) if selector(m.position[:, 0], m.normal[:, 0])]
        if not isinstance(selector, Sequence | np.ndarray):
            raise SelectionError(f"'{name}' is {selector!r:.50}; give a name, face or function")
        if all(isinstance(s, int) for s in selector):
            return [i for i, p in numbered if p.face in selector]
        return self._at_point(name, shaped(f"'{name}'", selector, len(selector)))

    def _at_point(self, name: str, point: Array) -> list[int]:
        if point.shape != (self.dimension,):
            raise SelectionError(
                f"'{name}': a point has {self.dimension} coordinates, not {point.tolist()}"
            )
        low, high = self.bounds()
        tolerance = 1e-6 * float(np.linalg.norm(high - low))
        hits = [
            i for i, p in enumerate(self.patches) if closest_point(p.surface, point)[1] < tolerance
        ]
        if len({self.patches[i].face or -i for i in hits}) > 1:
            raise SelectionError(
                f"'{name}': the point {point.tolist()} lies on several faces: "
                + "; ".join(self.label(i) for i in hits)
                + "; move it off the common edge"
            )
        return hits

    def label(self, index: int) -> str:
        """Label of a patch for messages: CAD face, name, middle."""
        patch = self.patches[index]
        middle = np.array2string(patch.middle().position[:, 0], precision=4, separator=", ")
        number = f"face {patch.face}" if patch.face else f"patch {index}"
        return f"{number} '{patch.name}' at {middle}" if patch.name else f"{number} at {middle}"

    def transformed(self, matrix: ArrayLike, shift: ArrayLike = 0.0) -> Boundary:
        """Every point x moved to ``matrix`` x + ``shift``, a rotation and a vector (dim,).

        The matrix may stretch, too; one that mirrors turns the normals round, and is refused.
        """
        turn = shaped("matrix", matrix, self.dimension, self.dimension)
        vector("shift", shift, self.dimension)
        positive("the determinant of the matrix", float(np.linalg.det(turn)))
        moved = [replace(p, surface=p.surface.transformed(matrix, shift)) for p in self.patches]
        return replace(self, patches=tuple(moved))

    def elevated(self, degree: int) -> Boundary:
        """Every patch raised to at least ``degree`` in each direction; the shape stays."""
        whole("degree", degree, 1, MOST_DEGREE)
        return self._mapped(lambda s: s.elevated((degree,) * len(s.degrees)))

    def refined(
        self,
        spans: int | None = None,
        *,
        size: Size | None = None,
        elements: int | None = None,
        near: ArrayLike | None = None,
        growth: float = 0.5,
    ) -> Boundary:
        """Knots inserted until elements are small enough; existing knots and the shape stay.

        Give one of ``spans``, the number of elements in each direction of each patch; ``size``,
        how long elements may be in the boundary's unit: a length, one length an axis, or a
        function of positions (dim, N) -> (N,); ``elements``, about how many there may be in all.
        ``near`` is a path, points (dim, n) joined by straight lines, or one point (dim,):
        elements have the ``size`` there and grow by ``growth`` times the distance from it.

        A knot line runs across its whole patch, so that elements get smaller beside the path too.
        Raises ``InputError`` for sizes that are not positive or words that do not go together.
        """
        if sum(given is not None for given in (spans, size, elements)) != 1:
            raise InputError("give one of spans, size and elements")
        if near is not None and not (elements or isinstance(size, float | int)):
            raise InputError("near goes with a size that is one length, or with elements")
        if near is not None:
            shaped("near", near, self.dimension, *[None] * (np.ndim(near) - 1))
        not_negative("growth", growth)
        if spans is not None:
            rule = spans_rule(whole("spans", spans))
        elif size is not None:
            rule = size_rule(size, near, growth, self.dimension)
        else:
            whole("elements", elements)
            assert elements is not None
            rule = count_rule([p.surface for p in self.patches], elements, near, growth)
        return self._mapped(lambda s: s.inserted(rule(s)))

    def graded(
        self,
        levels: int | None = None,
        ratio: float = 0.45,
        *,
        size: float | None = None,
        toward: Predicate | None = None,
    ) -> Boundary:
        """Elements that shrink towards the patches' edges, where flows are singular.

        The element at an edge is cut at ``ratio``, ratio², ... of its width, ``levels`` times, or
        until the one at the edge is no longer than ``size`` (then at a somewhat larger ratio, so
        that it is just as long).
        ``toward(position, inward) -> bool`` is evaluated in the middle of each edge, with the
        direction from there into the patch; without it all edges are graded.
        """
        if not 0 < finite("ratio", ratio) < 1:
            raise InputError(f"the ratio {ratio} of grading must lie between 0 and 1")
        if (levels is None) == (size is None):
            raise InputError("give either the levels of grading or a positive size")
        if size is not None:
            positive("size", size)
        if levels is not None:
            whole("levels", levels, 0, MOST_LEVELS)
        rule = edge_rule(levels, ratio, size, toward)
        return self._mapped(lambda s: s.inserted(rule(s)))

    def turned(self) -> Boundary:
        """The same surface with its normals the other way: fluid and solid exchanged."""
        if self.dimension == 2:
            return self._mapped(lambda s: s.reversed())
        return self._mapped(lambda s: s.swapped())

    def _mapped(self, change: Callable[[Nurbs], Nurbs]) -> Boundary:
        patches = [replace(p, surface=change(p.surface)) for p in self.patches]
        return replace(self, patches=tuple(patches))

    def bounds(self) -> Array:
        """Corners (2, dim) of the box of all control points, which holds the boundary."""
        points = np.concatenate(
            [p.surface.points.reshape(-1, self.dimension) for p in self.patches]
        )
        return np.stack([points.min(axis=0), points.max(axis=0)])

    def quadrature(self, order: int = 16) -> tuple[SurfacePoints, Array]:
        """Gauss points and weights of all patches."""
        parts = [p.quadrature(order) for p in self.patches]
        return join([p for p, _ in parts]), np.concatenate([w for _, w in parts])

    def area(self, order: int = 16) -> float:
        """Area (or length, in 2D) in the square (first power) of the unit."""
        _, normal, weights = self._measures(order)
        return float(np.linalg.norm(normal, axis=0) @ weights)

    def volume(self, order: int = 16) -> float:
        """Volume (area) of the fluid, -∮ x·n dS / dim with n into the fluid; negative if the
        boundary's normals point out of what it encloses."""
        position, normal, weights = self._measures(order)
        centre = self.bounds().mean(axis=0)[:, None]
        flux = ((position - centre) * normal).sum(axis=0)
        return -float(flux @ weights) / self.dimension

    def _measures(self, order: int) -> tuple[Array, Array, Array]:
        whole("order", order)
        return gauss_measures([p.surface for p in self.patches], order)
