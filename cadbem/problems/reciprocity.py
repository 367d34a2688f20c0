"""Adjoints of a flow's quantities from other flows through the same matrix.

By Lorentz's reciprocal theorem the error of a mean pressure is felt like the traction of the flow
that one unit enters there; of a flow rate, of the flow that one unit of pressure drives there; of a
force, of the flow around the body that moves with one unit of velocity.  The boundary equation's
adjoint z is the jump of such a traction between the flow inside and one outside with the same
velocity; taking both for alike, z = f / c.  That is rough, but asks for no transposed matrix.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from cadbem.errors import ConditionError
from cadbem.problems.equations import StokesEquations
from cadbem.problems.functionals import FLOW_RATE, FORCES, MEAN_PRESSURE, Functional
from cadbem.problems.mixed import Given, patches_named
from cadbem.problems.profiles import Port
from cadbem.spline.basis import Array


def reciprocal_adjoints(
    equations: StokesEquations, functionals: Sequence[Functional]
) -> list[Array]:
    """Coefficients (dim, F) of the adjoint of each functional, approximately.

    Raises ``ConditionError`` for quantities that are neither flow rates, pressures nor forces.
    """
    found = []
    for functional in functionals:
        known = _driving(equations, functional)
        _, traction, _ = equations.fields(known, 0.0, 0.0)
        found.append(traction / equations.system.free_term)
    return found


def _unit_flow(opening: Port) -> Given:
    """The developed velocity of one unit of flow."""
    return lambda x: opening.profile(x.position) * opening.normal[:, None] / opening.area


def _driving(equations: StokesEquations, functional: Functional) -> tuple[Array, Array]:
    """Known velocity and traction of the flow that is adjoint to a functional."""
    space = equations.space
    velocity = np.zeros((equations.boundary.dimension, space.count))
    traction = np.zeros_like(velocity)
    if functional.kind not in (MEAN_PRESSURE, FLOW_RATE, *FORCES):
        raise ConditionError(
            f"the error of the {functional.name} is estimated with a dense matrix only; solve "
            "with storage=Dense()"
        )
    for i in patches_named(space.boundary, functional.place):
        part = space.functions(i)
        if functional.kind == MEAN_PRESSURE:
            velocity[:, part] = space.project(i, _unit_flow(equations.openings[functional.place]))
        elif functional.kind == FLOW_RATE:
            normal = space.boundary.patches[i].middle().normal
            traction[:, part] = -normal
        else:
            velocity[FORCES.index(functional.kind), part] = 1.0
    return velocity, traction
