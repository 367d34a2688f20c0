"""A chip as a network: flow rates through its openings against their pressures.

Stokes flow is linear, so that Q = G p for the flow rates Q into the fluid and the pressures p of n
openings.  G (n, n), the conductance, has rows that sum to 0 (equal pressures drive nothing),
columns that sum to 0 (fluid is conserved), and is symmetric (Lorentz's reciprocal theorem).
"""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from cadbem.boundary import Boundary
from cadbem.checks import finite, not_negative, positive
from cadbem.design.overview import network_overview
from cadbem.errors import AccuracyWarning, ConditionError, SelectionError
from cadbem.operators.compressed.layers import CompressedLayers
from cadbem.operators.compressed.storage import Storage
from cadbem.problems.conditions import OPEN, Condition, NoSlip, Pressure
from cadbem.problems.estimates import DOUBTFUL
from cadbem.problems.mixed import patches_named
from cadbem.problems.solution import StokesSolution
from cadbem.problems.stokes import StokesProblem
from cadbem.quadrature import Quadrature, Rules
from cadbem.spline.basis import Array
from cadbem.tables import text_table
from cadbem.units import Units, check


@dataclass(frozen=True, eq=False)
class OperatingPoint:
    """``flow_rates`` (n,) into the fluid and ``pressures`` (n,) of openings by ``names``, and the
    pressures ``outside`` (n,), beyond their tubing; ``rate_errors`` and ``pressure_errors`` (n,)
    are estimated, nan where they are not known."""

    names: tuple[str, ...]
    flow_rates: Array
    pressures: Array
    outside: Array
    rate_errors: Array
    pressure_errors: Array

    @property
    def fractions(self) -> dict[str, float]:
        """The share of the whole outflow that leaves through each outlet."""
        leaving = np.maximum(-self.flow_rates, 0.0)
        shares = leaving / leaving.sum()
        return {n: float(s) for n, s in zip(self.names, shares, strict=True) if s > 0}

    def table(self, units: Units) -> str:
        """Flow rates and pressures at each opening, in handy units."""
        columns = zip(self.names, self.flow_rates, self.pressures, self.outside, strict=True)
        rows = [
            (name, units.show(rate, "flow_rate"), *(units.show(p, "pressure") for p in pressures))
            for name, rate, *pressures in columns
        ]
        return text_table(("opening", "flow rate", "at the chip", "beyond the tube"), rows)


@dataclass(frozen=True, eq=False)
class Network:
    """``conductance`` G (n, n) between openings: Q = G p, in flow rate over pressure; the estimated
    ``errors`` (n, n) of its entries, nan where they are not known (compressed matrices).

    ``problem`` has a pressure on each of them and keeps its factors.
    """

    names: tuple[str, ...]
    conductance: Array
    errors: Array
    problem: StokesProblem

    def __repr__(self) -> str:
        return network_overview(self).text()

    def _repr_html_(self) -> str:
        return network_overview(self).html()

    @property
    def asymmetry(self) -> float:
        """|G - Gᵀ| over |G|, largest entries: 0 but for errors of discretisation."""
        return float(abs(self.conductance - self.conductance.T).max() / abs(self.conductance).max())

    def resistance(self, reference: str) -> Array:
        """R (n-1, n-1): p_i - p_reference = Σ_j R_ij Q_j over the other openings, in their order.

        For two openings it is one number, pressure drop over flow rate.
        """
        kept = np.arange(len(self.names)) != self._index(reference)
        return np.asarray(np.linalg.inv(self.conductance[np.ix_(kept, kept)]), dtype=float)

    def tables(self, reference: str, units: Units) -> str:
        """G, and the resistance to a ``reference`` opening, in µL/min and Pa."""
        rate = units.si(1.0, "flow_rate") * 6e10
        others = [name for name in self.names if name != reference]
        parts = (
            "conductance G (uL/min/Pa): Q into the chip = G p",
            _table(self.conductance * rate / units.si(1.0, "pressure"), self.names),
            f"resistance to the {reference} (Pa min/uL)",
            _table(self.resistance(reference) * units.si(1.0, "resistance") / 6e10, others),
        )
        return "\n".join(parts)

    def operate(
        self,
        pressures: Mapping[str, float] | None = None,
        flow_rates: Mapping[str, float] | None = None,
        tubing: Mapping[str, float] | None = None,
    ) -> OperatingPoint:
        """All flow rates and pressures, from one of both at each opening.

        ``tubing`` has resistances (pressure over flow rate) outside; a pressure is then given at
        the tube's far end.  Raises ``ConditionError`` unless each opening has either a pressure or
        a flow rate (0: closed), and at least one a pressure; ``UnitsError`` for other quantities.
        """
        given, driven = dict(pressures or {}), dict(flow_rates or {})
        self._check(given, driven, tubing or {})
        tubes = np.array([(tubing or {}).get(n, 0.0) for n in self.names], dtype=float)
        fixed = np.array([n in given for n in self.names])
        right = np.array([{**given, **driven}[n] for n in self.names], dtype=float)
        # p + tube × Q = P where a pressure is given, Q = G p where a flow rate is
        held = np.eye(len(self.names)) + tubes[:, None] * self.conductance
        scale = abs(self.conductance).max()
        rows = np.where(fixed[:, None], held, self.conductance / scale)
        inside = np.linalg.solve(rows, np.where(fixed, right, right / scale))
        rates = np.where(fixed, self.conductance @ inside, right)
        outside = np.where(fixed, right, inside + tubes * rates)
        # to first order: errors of G act like flow rates that are wrong
        missed = self.errors @ abs(inside)
        wrong = np.where(fixed, tubes * missed, missed / scale)
        pressure_errors = abs(np.linalg.inv(rows)) @ wrong
        rate_errors = np.where(fixed, missed + abs(self.conductance) @ pressure_errors, 0.0)
        return OperatingPoint(self.names, rates, inside, outside, rate_errors, pressure_errors)

    def flow(self, point: OperatingPoint) -> StokesSolution:
        """The flow field at an operating point, without another factorisation."""
        pairs = zip(point.names, point.pressures, strict=True)
        return self.problem.with_data({n: Pressure(float(p)) for n, p in pairs}).solve()

    def _check(
        self, given: Mapping[str, float], driven: Mapping[str, float], tubing: Mapping[str, float]
    ) -> None:
        for name in (*given, *driven, *tubing):
            self._index(name)
        for name in self.names:
            check(f"pressure at '{name}'", given.get(name), "pressure")
            check(f"flow rate at '{name}'", driven.get(name), "flow_rate", "plane_flow_rate")
            check(f"tubing at '{name}'", tubing.get(name), "resistance")
            for what, at in (("pressure", given), ("flow rate", driven), ("tubing", tubing)):
                if name in at:
                    finite(f"{what} at '{name}'", at[name])
        for name in self.names:
            if (name in given) == (name in driven):
                raise ConditionError(
                    f"'{name}' must have either a pressure or a flow rate, not both or none; "
                    "a closed opening has the flow rate 0"
                )
        if not given:
            raise ConditionError("flow rates alone leave pressures open; give one opening its own")
        if min(tubing.values(), default=0.0) < 0:
            raise ConditionError(f"tubing={dict(tubing)}: resistances cannot be negative")

    def _index(self, name: str) -> int:
        if name not in self.names:
            there = ", ".join(f"'{n}'" for n in self.names)
            raise SelectionError(f"no opening is called '{name}'; the openings are {there}")
        return self.names.index(name)


def hydraulic_network(
    channel: Boundary,
    viscosity: float,
    openings: Sequence[str],
    quadrature: Rules | None = None,
    storage: Storage | None = None,
    *,
    accuracy: float | None = None,
) -> Network:
    """The network of a ``channel`` whose flat ``openings`` are named; all other faces are walls.

    With an ``accuracy`` elements are chosen and refined until all flow rates are as accurate as
    that; without, the channel's patches are the elements.
    Raises ``ConditionError`` for fewer than two openings.
    """
    check("viscosity", viscosity, "viscosity")
    positive("viscosity", viscosity)
    _check_names(channel, openings)
    conditions: dict[str, Condition] = {n: Pressure(float(n == openings[0])) for n in openings}
    conditions |= {n: NoSlip() for n in channel.names if n not in conditions}
    rules = quadrature or Quadrature()
    problem = StokesProblem(channel, viscosity, conditions, rules, storage=storage)
    return network_of(problem, accuracy=accuracy)


def tube_resistance(viscosity: float, length: float, bore: float) -> float:
    """128 μ L / (π d⁴) of a round tube (Hagen and Poiseuille), pressure drop over flow rate."""
    positive("viscosity", viscosity)
    not_negative("length", length)  # 0: no tube
    positive("bore", bore)
    return 128 * viscosity * length / (np.pi * bore**4)


def _table(matrix: Array, names: Sequence[str]) -> str:
    """A matrix with names at its rows and columns."""
    rows = [(n, *(f"{x:.4g}" for x in row)) for n, row in zip(names, matrix, strict=True)]
    return text_table(("", *names), rows)


def network_of(problem: StokesProblem, *, accuracy: float | None = None) -> Network:
    """The network of a ``problem``'s openings: those with an inflow, a pressure or a traction.

    ``accuracy`` as in ``hydraulic_network``.
    Its data do not matter.  The matrix is assembled and factorised once for all openings.  Raises
    ``ConditionError`` where other faces are not at rest, or for fewer than two openings.
    """
    names = tuple(n for n, c in problem.conditions.items() if isinstance(c, OPEN))
    for name, condition in problem.conditions.items():
        if name not in names and not isinstance(condition, NoSlip):
            raise ConditionError(
                f"'{name}' has {condition!r}; between openings of a network walls are at rest, "
                "give it NoSlip()"
            )
    _check_names(problem.boundary, names)
    ends = [{n: Pressure(float(n == driven)) for n in names} for driven in names]
    whole = StokesProblem(
        problem.boundary, problem.viscosity, {**problem.conditions, **ends[0]},
        problem.quadrature, storage=problem.storage,
    )  # fmt: skip
    if accuracy is not None:
        refined = whole.solve(accuracy, goal="openings").problem
        assert isinstance(refined, StokesProblem)
        whole = refined
    columns, errors = zip(*(_driven(whole, end) for end in ends), strict=True)
    network = Network(names, np.array(columns).T, np.array(errors).T, whole)
    _warn_if_doubtful(network)
    return network


def _driven(problem: StokesProblem, pressures: Mapping[str, Pressure]) -> tuple[list, list]:
    """Flow rates at the openings for given pressures, and their estimated errors."""
    with warnings.catch_warnings():  # what counts here is said of the whole network
        warnings.simplefilter("ignore", AccuracyWarning)
        flow = problem.with_data(pressures).solve()
    known = not isinstance(problem.layers, CompressedLayers)
    errors = [flow.accuracy.error("flow rate", n) if known else np.nan for n in pressures]
    return [flow.flow_rate(n) for n in pressures], errors


def _warn_if_doubtful(network: Network) -> None:
    largest = abs(network.conductance).max()
    share = float(np.nan_to_num(network.errors).max() / largest)
    if share > DOUBTFUL:
        warnings.warn(
            f"flow rates of the network may be off by {share:.0%} of the largest: the elements are "
            "too few or in the wrong places; accuracy=1e-3 chooses them",
            AccuracyWarning,
            stacklevel=3,
        )


def _check_names(channel: Boundary, openings: Sequence[str]) -> None:
    for name in openings:
        patches_named(channel, name)
    if len(set(openings)) < 2:
        raise ConditionError(f"openings are {list(openings)}: a network has at least two")
