"""Which numbers of a heat conduction problem are judged, and how wrong they may be."""

from __future__ import annotations

import numpy as np

from cadbem.operators.layers import applied
from cadbem.problems.estimates import Analysis, Norm, adjoints, analysed, coarser
from cadbem.problems.functionals import Functional
from cadbem.problems.heat_conditions import HeatFlux
from cadbem.problems.heat_equations import HeatEquations
from cadbem.problems.mixed import MixedSystem, patches_named
from cadbem.problems.residual import CheckPoints, residual
from cadbem.space import Field
from cadbem.spline.basis import Array


def analyse_heat(
    equations: HeatEquations, system: MixedSystem, temperature: Field, flux: Field
) -> Analysis:
    """Estimated errors of heat rates, and of the temperature in the mean square.

    The largest heat rate and the range of the temperature are what errors are compared with.
    Radiation is judged as if its law were linear.
    """
    checks = CheckPoints.of(equations.space)
    rules = coarser(equations.quadrature)

    def source(checks: CheckPoints) -> Array:
        kernels, k = equations.source_kernels, equations.conductivity
        if kernels is None:
            return np.zeros((1, len(checks.weights)))
        ones = np.full((1, equations.space.count), 1 / k)
        return applied(kernels.value, equations.space, checks.targets, rules, 0 * ones, ones)

    value, rate = temperature.coefficients, flux.coefficients
    missed = residual(system, checks, value, rate, source, rules)
    values = checks.values(value)
    scale = float(np.ptp(values)) or float(abs(values).max())
    areas = checks.by_patch(np.ones(len(checks.weights)))
    spots = (missed[0] / (2 * system.free_term)) ** 2
    parts = np.sqrt(checks.by_patch(spots) / areas.sum())
    norms = [Norm("temperature in the mean square", scale, parts, 2.0, spots)]
    functionals = _rates(equations, flux)
    adjoint = adjoints(system, functionals)
    return analysed(functionals, norms, adjoint, checks, missed, (value, rate))


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
