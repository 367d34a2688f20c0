"""Which numbers of a Stokes flow are judged, and how wrong they may be."""

from __future__ import annotations

import numpy as np

from cadbem.elements.shape import lengths
from cadbem.errors import ConditionError
from cadbem.kernels.stokes import stokes_kernels
from cadbem.operators.compressed.layers import CompressedLayers
from cadbem.operators.interactions import Targets
from cadbem.operators.layers import assemble_layers
from cadbem.problems.conditions import OPEN, Background, Inflow, NoSlip, Pressure, Traction
from cadbem.problems.constraints import normal_integrals
from cadbem.problems.continuity import shear, shear_jumps
from cadbem.problems.equations import StokesEquations
from cadbem.problems.estimates import Analysis, Norm, adjoints, analysed, coarser
from cadbem.problems.functionals import (
    FLOW_RATE,
    FORCES,
    MEAN_PRESSURE,
    OPENINGS,
    WALL_SHEAR,
    Functional,
    Goal,
    points_of,
)
from cadbem.problems.mixed import patches_named
from cadbem.problems.reciprocity import reciprocal_adjoints
from cadbem.problems.residual import CheckPoints, residual
from cadbem.space import Field, rational_basis
from cadbem.spline.basis import Array

POINTWISE = 3.0  # safety factor for tractions at a point: their adjoints are singular
SLIP_SAFETY = 1.5  # by comparison with finer flows
LEAST_FLOW = 0.1  # share of speed times area that errors of small flow rates are compared with


def analyse(
    equations: StokesEquations,
    velocity: Field,
    traction: Field,
    background: Background,
    goal: Goal | None = None,
) -> Analysis:
    """Estimated errors of a flow with ``velocity`` and ``traction`` on its boundary.

    Without a ``goal``: of flow rates, mean pressures and forces, and of the velocity in the mean
    square.  A goal is "openings" for flow rates and mean pressures alone, "wall shear" for the
    largest one, or points (dim, M) for the velocity there.
    """
    checks = CheckPoints.of(equations.space)
    u, f = velocity.coefficients, traction.coefficients
    thin = np.where(equations.thin, 0.0, u)
    twice = 2 * equations.system.free_term

    def source(checks: CheckPoints) -> Array:
        far = background.velocity_at(checks.points.position)
        return twice * (far - checks.values(u - thin))

    missed = residual(equations.system, checks, thin, f, source, coarser(equations.quadrature))
    norms = []
    if goal is None:
        functionals = _openings(equations, checks, velocity, traction)
        functionals += _forces(equations, checks, velocity, traction)
        norms = [_slip(equations, checks, missed / twice, velocity, background)]
    elif isinstance(goal, str) and goal == OPENINGS:
        functionals = _openings(equations, checks, velocity, traction)
    elif isinstance(goal, str) and goal == WALL_SHEAR:
        functionals = [_largest_shear(equations, traction)]
        norms = [_jumps(equations, checks, traction, functionals[0].scale)]
    else:
        points = points_of(goal, equations.boundary, OPENINGS, WALL_SHEAR)
        functionals = _velocities(equations, velocity, traction, background, points)
    if isinstance(equations.layers, CompressedLayers):
        adjoint = reciprocal_adjoints(equations, functionals)
    else:
        adjoint = adjoints(equations.system, functionals)
    return analysed(functionals, norms, adjoint, checks, missed, (u, f))


def _openings(
    equations: StokesEquations, checks: CheckPoints, velocity: Field, traction: Field
) -> list[Functional]:
    """Flow rates and mean pressures that are not given."""
    space, found = equations.space, []
    rates, pressures = {}, {}
    for name, condition in equations.conditions.items():
        if isinstance(condition, OPEN):
            patches = patches_named(space.boundary, name)
            weights = normal_integrals(space, patches)
            area = sum(float(space.boundary.patches[i].quadrature(8)[1].sum()) for i in patches)
            rates[name] = float((weights * velocity.coefficients).sum()), weights
            pressure = -float((weights * traction.coefficients).sum()) / area
            pressures[name] = pressure, -weights / area
    if not rates:
        return []
    area = sum(p.area for p in equations.openings.values())
    flow = sum(abs(value) for value, _ in rates.values()) / 2
    flow = max(flow, LEAST_FLOW * _speed(checks, velocity.coefficients) * area)
    values = [value for value, _ in pressures.values()]
    drop = max(max(values) - min(values), max(map(abs, values)))
    free = [n for n in rates if not isinstance(equations.conditions[n], Inflow)]
    for name, condition in equations.conditions.items():
        if isinstance(condition, Pressure | Traction) and len(free) > 1:  # else it is conserved
            value, weights = rates[name]
            found.append(Functional(FLOW_RATE, name, value, flow, weights, 0 * weights))
        elif isinstance(condition, Inflow):
            value, weights = pressures[name]
            found.append(Functional(MEAN_PRESSURE, name, value, drop, 0 * weights, weights))
    return found


def _forces(
    equations: StokesEquations, checks: CheckPoints, velocity: Field, traction: Field
) -> list[Functional]:
    """Components of the forces on bodies, all compared with the largest of them, or with viscosity
    times speed times size where that is larger."""
    space, bodies = equations.space, [s.patches for s in equations.given_bodies]
    inside = {i for body in bodies for i in body}
    names = [
        name for name in space.boundary.names
        if set(patches_named(space.boundary, name)) <= inside
    ]  # fmt: skip
    found = []
    for name in names:
        integrals = np.zeros((1, space.count))
        for i in patches_named(space.boundary, name):
            integrals[0, space.functions(i)] = space.integrals(i)
        for axis, row in enumerate(np.eye(len(traction.coefficients))):
            weights = row[:, None] * integrals
            value = float((weights * traction.coefficients).sum())
            found.append((name, FORCES[axis], value, weights))
    if not found:
        return []
    dimension = space.boundary.dimension
    area = max(
        sum(float(space.boundary.patches[i].quadrature(8)[1].sum()) for i in body)
        for body in bodies
    )
    size = area ** (1 / (dimension - 1)) if dimension == 3 else 1.0
    scale = equations.viscosity * _speed(checks, velocity.coefficients) * size
    scale = max(scale, *(abs(value) for *_, value, _ in found))
    return [
        Functional(axis, name, value, scale, 0 * weights, weights)
        for name, axis, value, weights in found
    ]


def _slip(
    equations: StokesEquations,
    checks: CheckPoints,
    slip: Array,
    velocity: Field,
    background: Background,
) -> Norm:
    """The velocity's error in the mean square over the fluid, from the slip on its boundary.

    What a slip does fades into the fluid like exp(-2πy/λ), λ being the length over which it
    changes: the width h of an element for its mean there, h over its degree for the rest.
    """
    boundary = equations.boundary
    areas = checks.by_patch(np.ones(len(checks.weights)))
    means = np.array([checks.by_patch(row) for row in slip]) / areas
    steady = (means**2).sum(axis=0) * areas
    squares = checks.by_patch((slip**2).sum(axis=0)) - steady
    widths = np.array([min(lengths(p.surface)) for p in boundary.patches])
    degrees = np.array([max(p.surface.degrees) for p in boundary.patches])
    squares = widths / 2 * (steady + squares / (degrees + 1))
    if not any(s.holds_fluid for s in equations.surfaces):
        plates = [i for s in equations.surfaces if not s.is_body for i in s.patches]
        squares[plates] = 0.0  # in unbounded fluid they are as large as one likes
    far = background.velocity_at(checks.points.position)
    scale = _speed(checks, velocity.coefficients, far)
    parts = SLIP_SAFETY * np.sqrt(squares.clip(min=0.0) / _volume(equations, areas))
    return Norm("velocity in the mean square", scale, parts, 2.0, (slip**2).sum(axis=0))


def _speed(checks: CheckPoints, velocity: Array, far: Array | float = 0.0) -> float:
    """Mean square root of the speed over that part of the boundary that moves."""
    speed = np.linalg.norm(checks.values(velocity) - far, axis=0)
    moving = speed > 1e-6 * max(float(speed.max()), 1e-300)
    weights = checks.weights[moving]
    return float(np.sqrt(speed[moving] ** 2 @ weights / max(weights.sum(), 1e-300)))


def _volume(equations: StokesEquations, areas: Array) -> float:
    """Volume of the fluid; as much as that of the bodies in it where it is unbounded."""
    fluid = sum(s.volume for s in equations.surfaces)
    if fluid > 0:
        return fluid
    dimension = equations.boundary.dimension
    return abs(fluid) or float(areas.sum()) ** (dimension / (dimension - 1))


def _largest_shear(equations: StokesEquations, traction: Field) -> Functional:
    """The tangential traction where it is largest among collocation points of walls at rest: at
    the ends of elements tractions are less accurate."""
    space, best = equations.space, (0.0, -1, np.empty(0), np.empty(0))
    for i, kind in enumerate(equations.kinds):
        if isinstance(kind, NoSlip):
            parameters = list(space.parameters[i])
            along = shear(traction, i, parameters)
            size = np.linalg.norm(along, axis=0)
            k = int(size.argmax())
            if size[k] > best[0]:
                place = np.array([p[k] for p in parameters])
                best = float(size[k]), i, place, along[:, k] / size[k]
    top, patch, place, direction = best
    if patch < 0:
        raise ConditionError("there is no wall at rest whose shear could be judged")
    weights = np.zeros_like(traction.coefficients)
    basis = rational_basis(space.boundary.patches[patch].surface, place[:, None]).toarray()[0]
    weights[:, space.functions(patch)] = direction[:, None] * basis
    return Functional("largest wall shear", "", top, top, 0 * weights, weights, POINTWISE)


def _jumps(
    equations: StokesEquations, checks: CheckPoints, traction: Field, scale: float
) -> Norm:
    """The largest jump of the wall shear between elements."""
    jumps = shear_jumps(equations, traction)
    return Norm("jump of the wall shear", scale, jumps, np.inf, 0 * checks.weights)


def _velocities(
    equations: StokesEquations,
    velocity: Field,
    traction: Field,
    background: Background,
    points: Array,
) -> list[Functional]:
    """Components of the velocity at points (dim, M) in the fluid."""
    kernel, _ = stokes_kernels(len(points))
    within = 2 * kernel.free_term
    targets = Targets.free(np.ascontiguousarray(points))
    layers = assemble_layers(kernel, equations.space, targets, equations.quadrature)
    one, patches = np.eye(len(points)), range(len(equations.boundary.patches))
    push = -one / (within * equations.viscosity)
    single = np.concatenate([layers.columns(i, push, 0 * one) for i in patches], axis=3)
    double = np.concatenate([layers.columns(i, 0 * one, one / within) for i in patches], axis=3)
    double[..., equations.thin] = 0.0
    far, found = background.velocity_at(points), []
    for m in range(points.shape[1]):
        for axis in range(len(points)):
            a, b = double[axis, m], single[axis, m]
            value = far[axis, m] + (a * velocity.coefficients + b * traction.coefficients).sum()
            found.append((f"{'xyz'[axis]} velocity", f"point {m}", float(value), a, b))
    scale = max(abs(value) for _, _, value, *_ in found)
    return [Functional(kind, place, value, scale, a, b) for kind, place, value, a, b in found]
