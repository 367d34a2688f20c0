"""Which elements are refined, and how: halved, cut near a singular side, or of a higher degree."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise, product
from math import ceil

import numpy as np

from cadbem.boundary import Patch
from cadbem.elements.initial import RATIO
from cadbem.spline.basis import Array

BOTH = 0.3  # share of the larger tail from which a direction is refined too
SMOOTH = 0.5  # decay over two degrees from which a higher degree pays
HIGHEST = 10  # degree
MOST_STEPS = 3  # by which a degree is raised at once
ONE_SIDED = 0.7  # share of the error near an end from which the cut is made there
NEAR = 0.3  # share of an element that is near an end


@dataclass(frozen=True, eq=False)
class Evidence:
    """What is known of one element: ``values``, a list of fields (c, n_u[, n_v]) at its Gauss
    points, and where its error sits: ``places`` (p, N) in its unit square with ``amounts`` (N,)."""

    values: Sequence[Array]
    places: Array
    amounts: Array


def reductions(shares: Array, exponents: Array, allowed: Array) -> dict[int, float]:
    """Patches to be refined, and by which factors their errors should fall.

    ``shares`` (K, P) of patches in K errors, which are the norms of these with ``exponents`` (K,).
    The patches are as few as possible so that what all others add up to is ``allowed`` (K,); they
    themselves should add up to as much.
    """
    found: dict[int, float] = {}
    for share, exponent, limit in zip(shares, exponents, allowed, strict=True):
        order = np.argsort(-share)
        rest = [float(np.linalg.norm(share[order[k:]], exponent)) for k in range(len(order))]
        count = int((np.array(rest) > limit).sum())
        for patch in order[:count].tolist():
            factor = float(share[patch]) / limit * count ** (1 / exponent)
            found[patch] = max(found.get(patch, 0.0), factor)
    return found


def refined(patch: Patch, evidence: Evidence, reduction: float) -> list[Patch]:
    """The elements that take a patch's place, whose error should fall by the factor ``reduction``.

    Where the Legendre coefficients of fields fall fast, degrees are raised by as much as that
    takes; elsewhere the element is cut.
    """
    surface = patch.surface
    spectra = _spectra(evidence.values)
    tails = np.array([s[-2:].sum() for s in spectra])
    wanted = [d for d, tail in enumerate(tails) if tail >= BOTH * tails.max()]
    degrees, cuts = list(surface.degrees), [list(ends) for ends in surface.domain]
    for d in wanted:
        decay = _decay(spectra[d])
        if decay < SMOOTH and degrees[d] < HIGHEST:
            steps = ceil(2 * np.log(min(reduction, 1e3)) / -np.log(max(decay, 1e-3)))
            degrees[d] = min(degrees[d] + int(np.clip(steps, 1, MOST_STEPS)), HIGHEST)
        else:
            low, high = surface.domain[d]
            cuts[d].insert(1, low + (high - low) * _cut(evidence.places[d], evidence.amounts))
    surface = surface.elevated(degrees)
    boxes = product(*[list(pairwise(c)) for c in cuts])
    return [replace(patch, surface=surface.restricted(*box)) for box in boxes]


def _cut(places: Array, amounts: Array) -> float:
    """Where to cut a direction: in the middle, or near the end at which the error sits."""
    total = max(float(amounts.sum()), 1e-300)
    if amounts[places < NEAR].sum() > ONE_SIDED * total:
        return RATIO
    if amounts[places > 1 - NEAR].sum() > ONE_SIDED * total:
        return 1 - RATIO
    return 0.5


def _spectra(values: Sequence[Array]) -> list[Array]:
    """For each direction the size of the Legendre coefficients of each degree, over all fields."""
    directions = values[0].ndim - 1
    spectra = [np.zeros(n) for n in values[0].shape[1:]]
    for value in values:
        coefficients = value
        for d in range(directions):
            table = _analysis(value.shape[1 + d])
            coefficients = np.moveaxis(np.tensordot(table, coefficients, (1, 1 + d)), 0, 1 + d)
        size = float(np.linalg.norm(coefficients))
        if size > 0:
            for d in range(directions):
                rows = np.moveaxis(coefficients, 1 + d, 0).reshape(value.shape[1 + d], -1)
                spectra[d] += np.linalg.norm(rows, axis=1) / size
    return spectra


def _analysis(count: int) -> Array:
    """From values at Gauss points to coefficients of normalised Legendre polynomials."""
    nodes, weights = np.polynomial.legendre.leggauss(count)
    table = np.polynomial.legendre.legvander(nodes, count - 1)
    return (table * weights[:, None] * np.sqrt(np.arange(count) + 0.5)).T


def _decay(spectrum: Array) -> float:
    """By how much coefficients fall over two degrees, from the first two to the last two."""
    if len(spectrum) < 3:
        return 0.0  # too few to tell: a higher degree will
    fall = spectrum[-2:].sum() / max(spectrum[:2].sum(), 1e-300)
    return float(fall) ** (2 / (len(spectrum) - 2))
