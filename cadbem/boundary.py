"""Named, oriented NURBS patches: the boundary of a body of fluid."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from math import ceil

import numpy as np

from cadbem.errors import SelectionError
from cadbem.points import SurfacePoints, join, surface_points
from cadbem.quadrature.gauss import gauss_on_breaks, tensor_rule
from cadbem.spline.basis import Array
from cadbem.spline.nurbs import Nurbs
from cadbem.spline.project import closest_point

Predicate = Callable[[Array, Array], bool]
Selector = str | int | Sequence[int] | Sequence[float] | Predicate


@dataclass(frozen=True, eq=False)
class Patch:
    """One smooth NURBS patch; its normal (see ``surface_points``) points into the fluid.

    ``name`` groups patches for conditions; ``face`` is the 1-based number of the CAD face.
    """

    surface: Nurbs
    name: str = ""
    face: int = 0

    def middle(self) -> SurfacePoints:
        """The point in the middle of the parameter domain."""
        return surface_points(self.surface, *[0.5 * (a + b) for a, b in self.surface.domain])

    def quadrature(self, order: int) -> tuple[SurfacePoints, Array]:
        """Gauss points, ``order`` a direction in each element, and weights (with Jacobian)."""
        rules = [
            gauss_on_breaks(order, self.surface.breaks(d))
            for d in range(len(self.surface.degrees))
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

    @property
    def names(self) -> tuple[str, ...]:
        """Names in use, sorted."""
        return tuple(sorted({p.name for p in self.patches}))

    @property
    def dimension(self) -> int:
        """2 for curves in a plane, 3 for surfaces in space."""
        return self.patches[0].surface.dimension

    def named(self, rest: str | None = None, **selectors: Selector) -> Boundary:
        """Give names to patches; those not selected keep theirs, or become ``rest``.

        A selector is an existing name, a CAD face number or several, a point on the face, or a
        predicate ``f(position, normal) -> bool`` that is asked in the middle of each patch.
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
            replace(p, name=chosen.get(i, p.name if rest is None else rest))
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
            return [
                i for i, m in enumerate(middles) if selector(m.position[:, 0], m.normal[:, 0])
            ]
        if all(isinstance(s, int) for s in selector):
            return [i for i, p in numbered if p.face in selector]
        return self._at_point(name, np.asarray(selector, dtype=float))

    def _at_point(self, name: str, point: Array) -> list[int]:
        if point.shape != (self.dimension,):
            raise SelectionError(
                f"'{name}': a point has {self.dimension} coordinates, not {point.tolist()}"
            )
        low, high = self.bounds()
        tolerance = 1e-6 * float(np.linalg.norm(high - low))
        hits = [
            i
            for i, p in enumerate(self.patches)
            if closest_point(p.surface, point)[1] < tolerance
        ]
        if len({self.patches[i].face or -i for i in hits}) > 1:
            raise SelectionError(
                f"'{name}': the point {point.tolist()} lies on several faces: "
                + "; ".join(self.label(i) for i in hits)
                + "; move it off the common edge"
            )
        return hits

    def label(self, index: int) -> str:
        """What to call a patch in a message: CAD face, name, middle."""
        patch = self.patches[index]
        middle = np.array2string(patch.middle().position[:, 0], precision=4, separator=", ")
        number = f"face {patch.face}" if patch.face else f"patch {index}"
        return f"{number} '{patch.name}' at {middle}" if patch.name else f"{number} at {middle}"

    def elevated(self, degree: int) -> Boundary:
        """Every patch raised to at least ``degree`` in each direction; the shape stays."""
        return self._mapped(lambda s: s.elevated((degree,) * len(s.degrees)))

    def refined(
        self, spans: int | None = None, *, size: float | Sequence[float] | None = None
    ) -> Boundary:
        """Knots inserted until each direction has ``spans`` elements, or elements of a ``size``.

        ``size`` is a length in the boundary's unit, or one length an axis for elements that are
        longer along some axes than along others.  Existing knots stay.
        """
        if (spans is None) == (size is None):
            raise ValueError("give either the number of spans or the size of elements")
        scale = np.broadcast_to(1.0 if size is None else np.asarray(size), (self.dimension,))
        return self._mapped(lambda s: s.inserted(_new_knots(s, spans, scale)))

    def graded(
        self,
        levels: int,
        ratio: float = 0.45,
        *,
        toward: Predicate | None = None,
    ) -> Boundary:
        """Elements that shrink towards the patches' edges, where flows are singular.

        The element at an edge is cut at ``ratio``, ratio², ... of its width, ``levels`` times.
        ``toward(position, inward) -> bool`` is asked in the middle of each edge, with the
        direction from there into the patch; without it all edges are graded.
        """
        if not 0 < ratio < 1:
            raise ValueError(f"the ratio {ratio} of grading must lie between 0 and 1")
        shares = np.array([ratio**k for k in range(levels, 0, -1)])
        return self._mapped(lambda s: s.inserted(_graded_knots(s, shares, toward)))

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
        return float(self.quadrature(order)[1].sum())

    def volume(self, order: int = 16) -> float:
        """Volume (area) of the fluid, -∮ x·n dS / dim with n into the fluid; negative if the
        boundary's normals point out of what it encloses."""
        points, weights = self.quadrature(order)
        centre = self.bounds().mean(axis=0)[:, None]
        flux = ((points.position - centre) * points.normal).sum(axis=0)
        return -float(flux @ weights) / self.dimension


def _new_knots(surface: Nurbs, spans: int | None, scale: Array) -> list[Array]:
    knots = []
    for direction in range(len(surface.degrees)):
        breaks = surface.breaks(direction)
        lengths = _span_lengths(surface, direction, scale)
        if spans is not None:
            lengths = lengths / lengths.sum() * spans
        pieces = [max(1, ceil(length - 1e-6)) for length in lengths]
        inner = [
            np.linspace(a, b, n + 1)[1:-1]
            for a, b, n in zip(breaks[:-1], breaks[1:], pieces, strict=True)
        ]
        knots.append(np.concatenate(inner))
    return knots


def _graded_knots(
    surface: Nurbs, shares: Array, toward: Predicate | None
) -> list[Array]:
    knots = []
    for direction in range(len(surface.degrees)):
        breaks = surface.breaks(direction)
        ends = []
        for edge, inner in ((breaks[0], breaks[1]), (breaks[-1], breaks[-2])):
            if toward is None or toward(*_edge_middle(surface, direction, edge, inner)):
                ends.append(edge + (inner - edge) * shares)
        knots.append(np.concatenate(ends) if ends else np.empty(0))
    return knots


def _edge_middle(
    surface: Nurbs, direction: int, edge: float, inner: float
) -> tuple[Array, Array]:
    """Middle of an edge, and the unit vector from there into the patch."""
    middle = [0.5 * (a + b) for a, b in surface.domain]
    middle[direction] = edge
    start = surface.evaluate(*middle)
    middle[direction] = inner
    inward = surface.evaluate(*middle) - start
    return start, inward / np.linalg.norm(inward)


def _span_lengths(surface: Nurbs, direction: int, scale: Array, samples: int = 8) -> Array:
    """Longest scaled length of each span of a direction among lines across the other one."""
    breaks = surface.breaks(direction)
    fractions = np.linspace(0, 1, samples + 1)
    along = breaks[:-1, None] + np.diff(breaks)[:, None] * fractions
    across = [
        np.linspace(*ends, samples + 1) for d, ends in enumerate(surface.domain) if d != direction
    ]
    grids = list(np.meshgrid(along.ravel(), *across, indexing="ij"))
    if direction == 1:
        grids.reverse()
    points = surface.evaluate(*grids).reshape(len(scale), *along.shape, -1)
    steps = np.linalg.norm(np.diff(points, axis=2) / scale.reshape(-1, 1, 1, 1), axis=0)
    return steps.sum(axis=1).max(axis=-1)
