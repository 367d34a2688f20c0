"""Curves and surfaces as OpenCASCADE's `.brep` text records them.

A record keeps the kernel's own parametrisation: `frame` holds the points and directions in the
order origin, X, Y (curves) or origin, Z, X, Y (surfaces); what each kind means is written in
`curves.py` and `surfaces.py`, which turn records into NURBS.
Format: OpenCASCADE documentation, "BRep format", version 1.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from cadbem.errors import CadError

LINE, CIRCLE, ELLIPSE, PARABOLA, HYPERBOLA = "line", "circle", "ellipse", "parabola", "hyperbola"
BEZIER, BSPLINE, TRIMMED, OFFSET = "Bezier", "B-spline", "trimmed", "offset"
PLANE, CYLINDER, CONE, SPHERE, TORUS = "plane", "cylinder", "cone", "sphere", "torus"
EXTRUSION, REVOLUTION = "extrusion", "revolution"

CURVE_KINDS = (
    LINE, CIRCLE, ELLIPSE, PARABOLA, HYPERBOLA, BEZIER, BSPLINE, TRIMMED, OFFSET
)  # fmt: skip
SURFACE_KINDS = (
    PLANE, CYLINDER, CONE, SPHERE, TORUS, EXTRUSION, REVOLUTION, BEZIER, BSPLINE, TRIMMED, OFFSET
)  # fmt: skip
CURVE_SIZES = {CIRCLE: 1, ELLIPSE: 2, PARABOLA: 1, HYPERBOLA: 2}  # radii or focal length
SURFACE_SIZES = {PLANE: 0, CYLINDER: 1, CONE: 2, SPHERE: 1, TORUS: 2}  # radii, half-angle


@dataclass(frozen=True, eq=False)
class SplineRecord:
    """A B-spline with the file's knots; those of a periodic direction are one period long."""

    degrees: tuple[int, ...]
    knots: tuple[np.ndarray, ...]  # flat, multiplicities written out
    points: np.ndarray  # (n_1[, n_2], dim)
    weights: np.ndarray  # (n_1[, n_2])
    periodic: tuple[bool, ...]


@dataclass(frozen=True, eq=False)
class CurveRecord:
    """A curve in 2D (parameters of a surface) or 3D."""

    kind: str
    frame: np.ndarray  # (k, dim): origin, X, Y
    sizes: tuple[float, ...] = ()
    spline: SplineRecord | None = None
    basis: CurveRecord | None = None


@dataclass(frozen=True, eq=False)
class SurfaceRecord:
    """A surface in 3D."""

    kind: str
    frame: np.ndarray  # (k, 3): origin, Z, X, Y
    sizes: tuple[float, ...] = ()
    spline: SplineRecord | None = None
    curve: CurveRecord | None = None
    basis: SurfaceRecord | None = None


class Tokens:
    """The words of the file, read one after the other."""

    def __init__(self, words: list[str]) -> None:
        self._words: Iterator[str] = iter(words)

    def word(self) -> str:
        word = next(self._words, None)
        if word is None:
            raise CadError("the kernel's record of the model ends too early")
        return word

    def integer(self) -> int:
        return int(self.word())

    def number(self) -> float:
        return float(self.word())

    def numbers(self, count: int) -> np.ndarray:
        return np.array([self.number() for _ in range(count)])

    def flag(self) -> bool:
        return self.word() != "0"

    def skip_to(self, *words: str) -> str:
        """Read up to and including the first of the words."""
        while (word := self.word()) not in words:
            pass
        return word

    def count_after(self, heading: str) -> int:
        self.skip_to(heading)
        return self.integer()


def read_curve(tokens: Tokens, dimension: int) -> CurveRecord:
    """The next curve of a `Curve2ds` (dimension 2) or `Curves` (dimension 3) section."""
    kind = CURVE_KINDS[tokens.integer() - 1]
    if kind == LINE:
        return CurveRecord(kind, tokens.numbers(2 * dimension).reshape(2, dimension))
    if kind in CURVE_SIZES:
        return _read_conic(tokens, kind, dimension)
    if kind == BEZIER:
        return CurveRecord(kind, np.zeros((0, dimension)), spline=_bezier_curve(tokens, dimension))
    if kind == BSPLINE:
        spline = _bspline_curve(tokens, dimension)
        return CurveRecord(kind, np.zeros((0, dimension)), spline=spline)
    # trimmed: first and last parameter; offset: distance, in space with a direction
    extra = 2 if kind == TRIMMED else 1 if dimension == 2 else 1 + dimension
    tokens.numbers(extra)
    basis = read_curve(tokens, dimension)
    return basis if kind == TRIMMED else CurveRecord(kind, np.zeros((0, dimension)), basis=basis)


def _read_conic(tokens: Tokens, kind: str, dimension: int) -> CurveRecord:
    origin = tokens.numbers(dimension)
    if dimension == 3:
        tokens.numbers(3)  # the axis: X and Y say it already
    directions = tokens.numbers(2 * dimension).reshape(2, dimension)
    sizes = tuple(tokens.numbers(CURVE_SIZES[kind]))
    return CurveRecord(kind, np.vstack([origin, directions]), sizes)


def _bezier_curve(tokens: Tokens, dimension: int) -> SplineRecord:
    rational, degree = tokens.flag(), tokens.integer()
    points, weights = _poles(tokens, (degree + 1,), dimension, rational)
    return SplineRecord((degree,), (_bezier_knots(degree),), points, weights, (False,))


def _bspline_curve(tokens: Tokens, dimension: int) -> SplineRecord:
    rational, periodic, degree = tokens.flag(), tokens.flag(), tokens.integer()
    pole_count, knot_count = tokens.integer(), tokens.integer()
    points, weights = _poles(tokens, (pole_count,), dimension, rational)
    return SplineRecord((degree,), (_knots(tokens, knot_count),), points, weights, (periodic,))


def read_surface(tokens: Tokens) -> SurfaceRecord:
    """The next surface of the `Surfaces` section."""
    kind = SURFACE_KINDS[tokens.integer() - 1]
    if kind in SURFACE_SIZES:
        frame = tokens.numbers(12).reshape(4, 3)
        return SurfaceRecord(kind, frame, tuple(tokens.numbers(SURFACE_SIZES[kind])))
    if kind in (EXTRUSION, REVOLUTION):
        rows = 1 if kind == EXTRUSION else 2  # direction; or a point and the direction of the axis
        return SurfaceRecord(kind, tokens.numbers(3 * rows).reshape(rows, 3),
                             curve=read_curve(tokens, 3))  # fmt: skip
    if kind == BEZIER:
        return SurfaceRecord(kind, np.zeros((0, 3)), spline=_bezier_surface(tokens))
    if kind == BSPLINE:
        return SurfaceRecord(kind, np.zeros((0, 3)), spline=_bspline_surface(tokens))
    sizes = tuple(tokens.numbers(4 if kind == TRIMMED else 1))  # an offset: its distance
    basis = read_surface(tokens)  # a trimmed surface keeps the parameters of its basis
    return basis if kind == TRIMMED else SurfaceRecord(kind, np.zeros((0, 3)), sizes, basis=basis)


def _bezier_surface(tokens: Tokens) -> SplineRecord:
    rational = any([tokens.flag(), tokens.flag()])
    degrees = (tokens.integer(), tokens.integer())
    points, weights = _poles(tokens, (degrees[0] + 1, degrees[1] + 1), 3, rational)
    knots = (_bezier_knots(degrees[0]), _bezier_knots(degrees[1]))
    return SplineRecord(degrees, knots, points, weights, (False, False))


def _bspline_surface(tokens: Tokens) -> SplineRecord:
    rational = any([tokens.flag(), tokens.flag()])
    periodic = (tokens.flag(), tokens.flag())
    degrees = (tokens.integer(), tokens.integer())
    pole_counts = (tokens.integer(), tokens.integer())
    knot_counts = (tokens.integer(), tokens.integer())
    points, weights = _poles(tokens, pole_counts, 3, rational)
    knots = (_knots(tokens, knot_counts[0]), _knots(tokens, knot_counts[1]))
    return SplineRecord(degrees, knots, points, weights, periodic)


def _poles(
    tokens: Tokens, shape: tuple[int, ...], dimension: int, rational: bool
) -> tuple[np.ndarray, np.ndarray]:
    width = dimension + rational
    values = tokens.numbers(int(np.prod(shape)) * width).reshape(*shape, width)
    weights = values[..., dimension] if rational else np.ones(shape)
    return values[..., :dimension], weights


def _knots(tokens: Tokens, count: int) -> np.ndarray:
    pairs = tokens.numbers(2 * count).reshape(count, 2)
    return np.repeat(pairs[:, 0], pairs[:, 1].astype(int))


def _bezier_knots(degree: int) -> np.ndarray:
    return np.repeat([0.0, 1.0], degree + 1)
