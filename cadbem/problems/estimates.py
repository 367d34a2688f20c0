"""How wrong a solution may be, quantity by quantity.

Let A q = b be the boundary equation and r = A q_h - b the residual of a computed q_h, which
vanishes at the collocation points and not between them.  A linear functional J(q) = j·q has the
adjoint z with Aᵀ z = j, and the error

    J(q_h) - J(q) = ∫ z·r dS,

exactly.  The transposed matrix gives z at the collocation points, once their weights are divided
out.  Contributions of patches may cancel by luck; so the estimate is the sum of their absolute
values, times ``SAFETY`` for what coarse check points miss beside singular edges.
(Becker and Rannacher, Acta Numerica 10, 2001, for finite elements.)
"""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from cadbem.errors import AccuracyWarning, ConditionError
from cadbem.operators.solve import DenseFactors
from cadbem.problems.functionals import Functional
from cadbem.problems.mixed import MixedSystem
from cadbem.problems.residual import CheckPoints
from cadbem.quadrature import Quadrature, Rules
from cadbem.spline.basis import Array

SAFETY = 1.5
ROUGHER = 30.0  # times a solution's tolerance, that of its residuals, which need two digits
CHECKED = 1e-7, 1e-5  # tolerances of residuals, at best and at worst
DOUBTFUL = 0.02  # relative error from which a solution warns


@dataclass(frozen=True)
class Estimate:
    """A ``quantity``'s ``value`` and its estimated ``error``, both in its own unit, and the
    ``scale`` that makes the error relative."""

    quantity: str
    place: str
    value: float
    error: float
    scale: float

    @property
    def name(self) -> str:
        """What it is, in words."""
        return f"{self.quantity} '{self.place}'" if self.place else self.quantity

    @property
    def relative(self) -> float:
        """The error over the scale."""
        return self.error / self.scale if self.scale > 0 else 0.0

    def __str__(self) -> str:
        return f"{self.name}: {self.value:.6g} ± {self.error:.1g}"


@dataclass(frozen=True)
class Accuracy:
    """The ``estimates`` of a solution's errors, by quantity."""

    estimates: tuple[Estimate, ...]

    @property
    def worst(self) -> Estimate:
        """The estimate with the largest relative error."""
        return max(self.estimates, key=lambda e: e.relative)

    @property
    def relative(self) -> float:
        """The largest relative error."""
        return self.worst.relative

    def of(self, quantity: str, place: str = "") -> Estimate:
        """The estimate of a quantity, such as "mean pressure" at a place of some name.

        Raises ``KeyError`` for one that was not estimated.
        """
        for estimate in self.estimates:
            if (estimate.quantity, estimate.place) == (quantity, place):
                return estimate
        known = ", ".join(e.name for e in self.estimates)
        raise KeyError(f"no estimate of {quantity} {place!r}; there are: {known}")

    def error(self, quantity: str, place: str = "") -> float:
        """The estimated error of a quantity; 0 for what was given."""
        found = [e for e in self.estimates if (e.quantity, e.place) == (quantity, place)]
        return max((e.error for e in found), default=0.0)

    def __str__(self) -> str:
        return "\n".join(f"{e}  ({e.relative:.1e} relative)" for e in self.estimates)


def coarser(rules: Rules) -> Rules:
    """The rules with which residuals are worked out."""
    if isinstance(rules, Quadrature):
        return Quadrature(float(np.clip(ROUGHER * rules.tolerance, *CHECKED)))
    return rules


def warn_if_doubtful(accuracy: Accuracy) -> None:
    """An ``AccuracyWarning`` for a solution on elements that are too few."""
    worst = accuracy.worst
    if worst.relative > DOUBTFUL:
        warnings.warn(
            f"{worst.name} may be off by {worst.relative:.0%} of its size: the elements are too "
            "few or in the wrong places; solve(accuracy=1e-3) chooses them by itself",
            AccuracyWarning,
            stacklevel=3,
        )


def adjoints(system: MixedSystem, functionals: Sequence[Functional]) -> list[Array]:
    """Coefficients (rows, F) of the adjoint of each functional.

    Raises ``ConditionError`` for a compressed matrix.
    """
    if not functionals:
        return []
    factors = system.factors
    if not isinstance(factors, DenseFactors):
        raise ConditionError(
            "errors are estimated with the factors of a dense matrix; solve with storage=Dense(), "
            "or judge the flow by one on fewer points"
        )
    unknowns = system.splits[0].value_mixing.shape[1]
    right = np.zeros((len(functionals), unknowns, system.space.count))
    for m, functional in enumerate(functionals):
        for i, split in enumerate(system.splits):
            part = system.space.functions(i)
            right[m][:, part] = split.value_mixing.T @ functional.value_weights[:, part]
            right[m][:, part] += split.flux_mixing.T @ functional.flux_weights[:, part]
    values = factors.solve_transposed(right) / system.space.weights
    return [system.space.interpolate(z) for z in values]


@dataclass(frozen=True, eq=False)
class Analysis:
    """What is known of a solution's errors.

    ``accuracy`` has the estimates.  Patches have ``shares`` (K, P) in each relative error, which is
    their norm with the ``exponents`` (K,): 1 for numbers, 2 for mean squares, inf for the largest
    of something.  ``spots`` (K, N) say where within patches errors come from, in any unit, at the
    ``checks``; ``fields`` (·, F) are coefficients of all fields whose resolution counts: the
    solution's and the adjoints'.
    """

    accuracy: Accuracy
    checks: CheckPoints
    shares: Array
    exponents: Array
    spots: Array
    fields: tuple[Array, ...]


@dataclass(frozen=True, eq=False)
class Norm:
    """An error that is the norm with an ``exponent`` of the ``parts`` (P,) of all patches: its
    ``quantity``, the ``scale``, and ``spots`` (N,) as in ``Analysis``."""

    quantity: str
    scale: float
    parts: Array
    exponent: float
    spots: Array


def analysed(
    functionals: Sequence[Functional],
    norms: Sequence[Norm],
    adjoint: Sequence[Array],
    checks: CheckPoints,
    residual: Array,
    fields: Sequence[Array],
) -> Analysis:
    """Errors of functionals by their ``adjoint`` fields (rows, F), and of norms as they are."""
    spots = [(checks.values(z) * residual).sum(axis=0) for z in adjoint]
    found = [_estimate(f, checks, s) for f, s in zip(functionals, spots, strict=True)]
    for norm in norms:
        error = float(np.linalg.norm(norm.parts, norm.exponent))
        estimate = Estimate(norm.quantity, "", norm.scale, error, norm.scale)
        found.append((estimate, norm.parts / max(norm.scale, 1e-300)))
    exponents = [1.0] * len(functionals) + [norm.exponent for norm in norms]
    everywhere = [*map(abs, spots), *(norm.spots for norm in norms)]
    return Analysis(
        Accuracy(tuple(e for e, _ in found)), checks, np.array([s for _, s in found]),
        np.array(exponents), np.array(everywhere), (*fields, *adjoint),
    )  # fmt: skip


def by_difference(analysis: Analysis, values: Sequence[float]) -> Analysis:
    """The analysis of a quantity of which nothing is known but its ``values``, one a round: the
    last difference, times ``SAFETY``, is the estimate."""
    value = values[-1]
    error = SAFETY * abs(value - values[-2]) if len(values) > 1 else np.inf
    estimate = Estimate("the goal", "", value, float(error), abs(value))
    return replace(analysis, accuracy=Accuracy((estimate,)))


def _estimate(functional: Functional, checks: CheckPoints, spots: Array) -> tuple[Estimate, Array]:
    parts = abs(checks.by_patch(spots))
    safety = SAFETY * functional.safety
    error = safety * float(parts.sum())
    estimate = Estimate(
        functional.kind, functional.place, functional.value, error, functional.scale
    )
    # where z·r changes sign within a patch, the patch's sum says too little of where to refine
    absolute = checks.by_patch(abs(spots))
    balance = parts.sum() / max(float(absolute.sum()), 1e-300)
    return estimate, 0.5 * safety * (parts + balance * absolute) / max(functional.scale, 1e-300)
