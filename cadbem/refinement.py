"""Refinement rules, which choose the knots to insert in a curve or surface."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import pairwise
from math import ceil, log

import numpy as np
from numpy.typing import ArrayLike

from cadbem.checks import positive, positive_array
from cadbem.errors import InputError
from cadbem.progress import progress
from cadbem.spline.basis import Array
from cadbem.spline.nurbs import Nurbs

SizeFunction = Callable[[Array], Array]
Size = float | Sequence[float] | SizeFunction
Predicate = Callable[[Array, Array], bool]
KnotRule = Callable[[Nurbs], list[Array]]

ROUNDING = 1e-6  # share by which an element may be longer than asked for
SAMPLES = 8  # pieces in which the length of an element is measured
MOST_PAIRS = 2_000_000  # of points and pieces of a path whose distances are worked out at once


def spans_rule(spans: int) -> KnotRule:
    """As many elements a direction, longer existing spans into more pieces than shorter ones."""

    def rule(spline: Nurbs) -> list[Array]:
        knots = []
        for direction in range(len(spline.degrees)):
            lengths = _span_lengths(spline, direction, np.ones(spline.dimension))
            knots.append(_equal_pieces(spline, direction, lengths / lengths.sum() * spans))
        return knots

    return rule


def size_rule(
    size: Size, near: ArrayLike | None = None, growth: float = 0.0, dimension: int | None = None
) -> KnotRule:
    """Elements no longer than ``size``: a length, one an axis, or a function of position.

    With ``near``, points (dim, n) of a path, the size grows by ``growth`` times the distance.
    """
    if callable(size):
        return lambda spline: _fitted_knots(spline, size)
    if isinstance(size, Sequence | np.ndarray):
        positive_array("size", size, dimension)
    else:
        positive("size", size)
    if near is not None:
        path = np.asarray(near, dtype=float)
        path = path[:, None] if path.ndim == 1 else path
        return lambda spline: _fitted_knots(
            spline, lambda x: size + growth * path_distance(x, path)
        )

    def rule(spline: Nurbs) -> list[Array]:
        scale = np.broadcast_to(np.asarray(size, dtype=float), (spline.dimension,))
        return [
            _equal_pieces(spline, d, _span_lengths(spline, d, scale))
            for d in range(len(spline.degrees))
        ]

    return rule


def count_rule(
    splines: Sequence[Nurbs], elements: int, near: ArrayLike | None, growth: float
) -> KnotRule:
    """The smallest size with which all splines together have at most so many ``elements``."""
    least = _element_count(splines, lambda s: [np.empty(0)] * len(s.degrees))
    if least > elements:
        raise InputError(f"there are {least} elements already, more than {elements}")
    points = np.concatenate([s.points.reshape(-1, s.dimension) for s in splines])
    coarse = fine = 2 * float(np.linalg.norm(np.ptp(points, axis=0)))
    with progress(label="sizes of elements") as bar:
        while _element_count(splines, size_rule(fine, near, growth)) <= elements:
            coarse, fine = fine, fine / 2
            bar.update()
        while coarse > 1.01 * fine:
            middle = float(np.sqrt(coarse * fine))
            fits = _element_count(splines, size_rule(middle, near, growth)) <= elements
            coarse, fine = (middle, fine) if fits else (coarse, middle)
            bar.update()
    return size_rule(coarse, near, growth)


def _element_count(splines: Sequence[Nurbs], rule: KnotRule) -> int:
    """Number of elements once the rule's knots are inserted."""
    return sum(
        int(np.prod([len(s.breaks(d)) - 1 + len(new) for d, new in enumerate(rule(s))]))
        for s in splines
    )


def edge_rule(
    levels: int | None, ratio: float, size: float | None, toward: Predicate | None
) -> KnotRule:
    """The element at an edge cut at ratio, ratio², ... of its width, ``levels`` times.

    With a ``size``, as often as it takes to make the first element that long, by a larger ratio.
    """

    def rule(spline: Nurbs) -> list[Array]:
        knots = []
        for direction in range(len(spline.degrees)):
            breaks = spline.breaks(direction)
            widths = _span_lengths(spline, direction, np.ones(spline.dimension))
            ends = [np.empty(0)]
            for edge, inner, width in (
                (breaks[0], breaks[1], widths[0]),
                (breaks[-1], breaks[-2], widths[-1]),
            ):
                if toward is None or toward(*_edge_middle(spline, direction, edge, inner)):
                    ends.append(edge + (inner - edge) * _shares(width, levels, ratio, size))
            knots.append(np.concatenate(ends))
        return knots

    return rule


def path_distance(points: Array, path: Array) -> Array:
    """Distance (N,) of points (dim, N) from a path (dim, n) of straight pieces, or one point."""
    starts = path[:, :-1] if path.shape[1] > 1 else path
    steps = path[:, 1:] - starts if path.shape[1] > 1 else np.zeros_like(path)
    squares = (steps**2).sum(axis=0)
    block = max(1, MOST_PAIRS // len(squares))
    distances = []
    for first in range(0, points.shape[1], block):
        arms = points[:, first : first + block, None] - starts[:, None]
        along = np.einsum("inm,im->nm", arms, steps) / np.where(squares > 0, squares, 1.0)
        arms -= np.clip(along, 0, 1) * steps[:, None]
        distances.append(np.linalg.norm(arms, axis=0).min(axis=1))
    return np.concatenate(distances)


def _fitted_knots(spline: Nurbs, size: SizeFunction) -> list[Array]:
    """Knots span by span, at equal shares of ∫ ds / size on the line across which has most, as
    few as make every element no longer than the smallest size on it."""
    lines = _resolving_lines(spline, size)
    knots = []
    for direction in range(len(spline.degrees)):
        inner = [np.empty(0)]
        across = lines[:direction] + lines[direction + 1 :]
        for low, high in pairwise(spline.breaks(direction)):
            fine = lines[direction]
            fine = fine[(low <= fine) & (fine <= high)]
            steps, wanted = _measured(spline, direction, fine, across, size)
            parts = (2 * steps / (wanted[:-1] + wanted[1:])).max(axis=1)
            shares = np.concatenate([[0.0], np.cumsum(parts)])
            pieces = max(1, ceil(shares[-1] - ROUNDING))
            while True:
                ends = np.interp(np.linspace(0, shares[-1], pieces + 1), shares, fine)
                if _fits(spline, direction, ends, across, size):
                    break
                pieces += 1 + pieces // 20
            inner.append(ends[1:-1])
        knots.append(np.concatenate(inner))
    return knots


def _resolving_lines(spline: Nurbs, size: SizeFunction) -> list[Array]:
    """Parameters in each direction, their lines nowhere farther apart than half the size there."""
    lines = [spline.breaks(d) for d in range(len(spline.degrees))]
    lines = [np.sort(np.append(k, 0.5 * (k[:-1] + k[1:]))) for k in lines]
    while True:
        finer = []
        for direction, along in enumerate(lines):
            across = lines[:direction] + lines[direction + 1 :]
            steps, wanted = _measured(spline, direction, along, across, size)
            crowded = (steps > 0.5 * np.minimum(wanted[:-1], wanted[1:])).any(axis=1)
            middles = 0.5 * (along[:-1] + along[1:])
            finer.append(np.sort(np.append(along, middles[crowded])))
        if all(len(new) == len(old) for new, old in zip(finer, lines, strict=True)):
            return lines
        lines = finer


def _fits(
    spline: Nurbs, direction: int, ends: Array, across: list[Array], size: SizeFunction
) -> bool:
    """Whether the elements between the ends are no longer than the smallest size on them."""
    inside = np.linspace(ends[:-1], ends[1:], SAMPLES, endpoint=False).T.ravel()
    steps, wanted = _measured(spline, direction, np.append(inside, ends[-1]), across, size)
    shape = (len(ends) - 1, SAMPLES, -1)
    smallest = np.minimum(wanted[:-1], wanted[1:]).reshape(shape).min(axis=1)
    return bool((steps.reshape(shape).sum(axis=1) <= (1 + ROUNDING) * smallest).all())


def _measured(
    spline: Nurbs, direction: int, along: Array, across: list[Array], size: SizeFunction
) -> tuple[Array, Array]:
    """Chords (n - 1, m) between parameters (n,) on m lines across, and the sizes (n, m) wanted."""
    points = _on_lines(spline, direction, along, across).reshape(spline.dimension, len(along), -1)
    wanted = np.asarray(size(points.reshape(spline.dimension, -1)), dtype=float)
    wanted = np.broadcast_to(wanted, points[0].size).reshape(points.shape[1:])
    if not (wanted > 0).all():
        place = points[:, *np.argwhere(~(wanted > 0))[0]]
        raise InputError(f"the size of elements must be positive; it is not at {place.round(4)}")
    return np.linalg.norm(np.diff(points, axis=1), axis=0), wanted


def _on_lines(spline: Nurbs, direction: int, along: Array, across: list[Array]) -> Array:
    """Points (dim, n, ...) at parameters along one direction, on lines across the other one."""
    grids = list(np.meshgrid(along, *across, indexing="ij"))
    if direction == 1:
        grids.reverse()
    return spline.evaluate(*grids)


def _span_lengths(spline: Nurbs, direction: int, scale: Array) -> Array:
    """Longest scaled length of each span of a direction among lines across the other one."""
    breaks = spline.breaks(direction)
    along = breaks[:-1, None] + np.diff(breaks)[:, None] * np.linspace(0, 1, SAMPLES + 1)
    across = [
        np.linspace(*ends, SAMPLES + 1) for d, ends in enumerate(spline.domain) if d != direction
    ]
    points = _on_lines(spline, direction, along.ravel(), across)
    points = points.reshape(len(scale), *along.shape, -1)
    steps = np.linalg.norm(np.diff(points, axis=2) / scale.reshape(-1, 1, 1, 1), axis=0)
    return steps.sum(axis=1).max(axis=-1)


def _equal_pieces(spline: Nurbs, direction: int, lengths: Array) -> Array:
    """Knots that cut each span into as many equal pieces of its parameter as it is long."""
    pieces = [max(1, ceil(length - ROUNDING)) for length in lengths]
    ends = pairwise(spline.breaks(direction))
    return np.concatenate(
        [np.linspace(a, b, n + 1)[1:-1] for (a, b), n in zip(ends, pieces, strict=True)]
    )


def _shares(width: float, levels: int | None, ratio: float, size: float | None) -> Array:
    """Where, from 0 at the edge to 1, an element of a width is cut."""
    if size is not None:
        levels = max(0, ceil(log(size / width) / log(ratio) - ROUNDING))
        ratio = (size / width) ** (1 / levels) if levels else ratio
    return ratio ** np.arange(levels or 0, 0, -1.0)


def _edge_middle(spline: Nurbs, direction: int, edge: float, inner: float) -> tuple[Array, Array]:
    """Middle of an edge, and the unit vector from there into the patch."""
    middle = [0.5 * (a + b) for a, b in spline.domain]
    middle[direction] = edge
    start = spline.evaluate(*middle)
    middle[direction] = inner
    inward = spline.evaluate(*middle) - start
    return start, inward / np.linalg.norm(inward)
