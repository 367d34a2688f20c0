"""Which numbers of a heat conduction problem are judged, and how wrong they may be."""

from __future__ import annotations

import numpy as np

from cadbem.operators.interactions import Targets
from cadbem.operators.layers import applied, assemble_layers
from cadbem.problems.estimates import Analysis, Norm, adjoints, analysed, coarser
from cadbem.problems.functionals import HEAT_RATES, Functional, Goal, points_of
from cadbem.problems.heat_conditions import HeatFlux
from cadbem.problems.heat_equations import HeatEquations
from cadbem.problems.mixed import MixedSystem, patches_named
from cadbem.problems.residual import CheckPoints, residual
from cadbem.quadrature import Rules
from cadbem.space import Field
from cadbem.spline.basis import Array


def analyse_heat(
    equations: HeatEquations,
    system: MixedSystem,
    temperature: Field,
    flux: Field,
    goal: Goal | None = None,
) -> Analysis:
    """Estimated errors of heat rates, and of the temperature in the mean square.

    A ``goal`` is "heat rates" for them alone, or points (dim, M) for the temperature there.  The
    largest heat rate and the range of the temperature are what errors are compared with.
    Radiation is judged as if its law were linear.
    """
    checks = CheckPoints.of(equations.space)
    rules = coarser(equations.quadrature)

    def source(checks: CheckPoints) -> Array:
        return _source(equations, checks.targets, rules)

    value, rate = temperature.coefficients, flux.coefficients
    missed = residual(system, checks, value, rate, source, rules)
    values = checks.values(value)
    scale = float(np.ptp(values)) or float(abs(values).max())
    areas = checks.by_patch(np.ones(len(checks.weights)))
    spots = (missed[0] / (2 * system.free_term)) ** 2
    parts = np.sqrt(checks.by_patch(spots) / areas.sum())
    norms = [Norm("temperature in the mean square", scale, parts, 2.0, spots)]
    functionals = _rates(equations, flux)
    if goal is not None:
        norms = []
        if not (isinstance(goal, str) and goal == HEAT_RATES):
            points = points_of(goal, equations.boundary, HEAT_RATES)
            functionals = _temperatures(equations, temperature, flux, points, scale)
    adjoint = adjoints(system, functionals)
    return analysed(functionals, norms, adjoint, checks, missed, (value, rate))


def _source(equations: HeatEquations, targets: Targets, rules: Rules) -> Array:
    """What the source adds to the boundary equation at targets: (1, N)."""
    kernels = equations.source_kernels
    if kernels is None:
        return np.zeros((1, targets.count))
    ones = np.full((1, equations.space.count), 1 / equations.conductivity)
    return applied(kernels.value, equations.space, targets, rules, 0 * ones, ones)


def _rates(equations: HeatEquations, flux: Field) -> list[Functional]:
    """Heat rates that are not given."""
    space, found = equations.space, []
    for name, condition in equations.conditions.items():
        weights = np.zeros((1, space.count))
        for i in patches_named(space.boundary, name):
            weights[0, space.functions(i)] = space.integrals(i)
        found.append((name, condition, float((weights * flux.coefficients).sum()), weights))
    largest = max(abs(value) for _, _, value, _ in found)
    return [
        Functional("heat rate", name, value, largest, 0 * weights, weights)
        for name, condition, value, weights in found
        if not isinstance(condition, HeatFlux)
    ]


def _temperatures(
    equations: HeatEquations, temperature: Field, flux: Field, points: Array, scale: float
) -> list[Functional]:
    """Temperatures at points (dim, M) in the body."""
    targets = Targets.free(np.ascontiguousarray(points))
    layers = assemble_layers(equations.kernel, equations.space, targets, equations.quadrature)
    within = 2 * equations.kernel.free_term
    added = _source(equations, targets, equations.quadrature)[0] / within
    found = []
    for m, (single, double) in enumerate(zip(*layers.entries, strict=True)):
        a, b = double[None] / within, single[None] / (within * equations.conductivity)
        value = float((a * temperature.coefficients + b * flux.coefficients).sum() + added[m])
        found.append(Functional("temperature", f"point {m}", value, scale, a, b))
    return found
