"""The equations of steady heat conduction: given data, space and layers."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from cadbem.boundary import Boundary
from cadbem.checks import finite, instance, positive
from cadbem.errors import ConditionError
from cadbem.kernels.kernel import Kernel
from cadbem.operators.compressed.layers import own_layers
from cadbem.operators.compressed.storage import Storage
from cadbem.operators.layers import OwnLayers
from cadbem.problems.bodies import check_closed, closed_surfaces
from cadbem.problems.heat_conditions import (
    HeatCondition,
    HeatFlux,
    SurfaceExchange,
    Temperature,
)
from cadbem.problems.heat_source import Source, SourceKernels, laplace_kernel, source_kernels
from cadbem.problems.mixed import check_names
from cadbem.quadrature.options import Quadrature, Rules
from cadbem.space import Space, discontinuous_space

KINDS = (Temperature, HeatFlux, SurfaceExchange)


@dataclass(frozen=True, eq=False)
class HeatEquations:
    """The data of a ``HeatProblem``, whose documentation says what they mean."""

    boundary: Boundary
    conductivity: float
    conditions: Mapping[str, HeatCondition]
    source: Source | None = None
    quadrature: Quadrature = field(default_factory=Quadrature)
    storage: Storage | None = None

    def __post_init__(self) -> None:
        positive("conductivity", self.conductivity)
        instance("boundary", self.boundary, Boundary, "a Boundary, as from read_cad")
        instance("conditions", self.conditions, Mapping, "a condition for each name: {name: ...}")
        instance("quadrature", self.quadrature, Rules, "Quadrature(tolerance)")
        if self.source is not None and not callable(self.source):
            finite("source", self.source)
        check_names(self.boundary, self.conditions, KINDS)
        check_closed(self.boundary, closed_surfaces(self.boundary), "add what is missing")
        if all(isinstance(c, HeatFlux) for c in self.conditions.values()):
            names = ", ".join(f"'{n}'" for n in self.boundary.names)
            raise ConditionError(
                f"only heat fluxes are given, so the temperature is open; give one of {names} "
                "a Temperature or a SurfaceExchange"
            )

    @property
    def size(self) -> float:
        """Diagonal of the box around the body."""
        low, high = self.boundary.bounds()
        return float(np.linalg.norm(high - low))

    @cached_property
    def space(self) -> Space:
        """Unknowns and collocation points."""
        return discontinuous_space(self.boundary)

    @cached_property
    def kernel(self) -> Kernel:
        """Fundamental solution of Laplace's equation, positive in this body."""
        return laplace_kernel(self.boundary.dimension, self.size)

    @cached_property
    def source_kernels(self) -> SourceKernels | None:
        """Kernels whose potentials are those of the source, if there is one."""
        if self.source is None:
            return None
        return source_kernels(self.source, self.space, self.size, self.quadrature.tolerance)

    @cached_property
    def layers(self) -> OwnLayers:
        """Both layers at the collocation points."""
        return own_layers(self.kernel, self.space, self.quadrature, self.storage)
