"""Checks of the numbers of splines in a file; with wrong ones the kernel may crash or guess."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import pairwise

from cadbem.cad.text.step_syntax import records

_KINDS = {"CURVE": 1, "SURFACE": 2}


def check_knots(knots: Sequence[float], degree: int, count: int, place: str) -> None:
    """Raises ValueError if flat knots are not those of a spline with `count` functions."""
    fits = degree >= 1 and count > degree and len(knots) == count + degree + 1
    if not (fits and all(a <= b for a, b in pairwise(knots)) and knots[degree] < knots[count]):
        raise ValueError(f"the knots of {place} are not those of a spline")
    if any(a == b for a, b in zip(knots, knots[degree + 1 :], strict=False) if a != knots[0]
           and a != knots[-1]):  # fmt: skip
        raise ValueError(f"{place} is torn apart by a knot that is there too often")


def check_weights(weights: Iterable[float], place: str) -> None:
    """Raises ValueError if a weight is not positive."""
    if min(weights) <= 0:
        raise ValueError(f"{place} has a weight that is not positive")


def check_step_spline(number: int, body: str) -> None:
    """Raises ValueError if an entity is a spline with knots that does not fit together."""
    for kind, dimension in _KINDS.items():
        if f"B_SPLINE_{kind}_WITH_KNOTS(" in body:
            try:
                _check(records(body), kind, dimension, f"#{number}")
            except (LookupError, TypeError):
                raise ValueError(f"#{number} is not written as a spline is") from None


def _check(parts: dict[str, list], kind: str, dimension: int, place: str) -> None:
    whole = parts[f"B_SPLINE_{kind}_WITH_KNOTS"]
    # an entity that is many things has degrees and control points in another of its parts
    basic = parts.get(f"B_SPLINE_{kind}", whole[1:])
    degrees = [int(word) for word in basic[:dimension]]
    points = basic[dimension]
    counts = [len(points)] if dimension == 1 else [len(points), len(points[0])]
    own = whole if f"B_SPLINE_{kind}" in parts else whole[4 + 2 * dimension :]
    for axis, (degree, count) in enumerate(zip(degrees, counts, strict=True)):
        multiplicities = [int(word) for word in own[axis]]
        values = [float(word) for word in own[dimension + axis]]
        if min(multiplicities) < 1 or sum(multiplicities) != count + degree + 1:
            raise ValueError(f"the knots of {place} are not those of a spline")
        flat = [v for v, m in zip(values, multiplicities, strict=True) for _ in range(m)]
        check_knots(flat, degree, count, place)
    weights = parts.get(f"RATIONAL_B_SPLINE_{kind}")
    if weights:
        rows = weights[0] if dimension == 2 else weights
        check_weights([float(word) for row in rows for word in row], place)
