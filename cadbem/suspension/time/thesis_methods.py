"""The methods of the thesis, for comparison."""

from __future__ import annotations

from typing import Any

from cadbem.quadrature.closed import SingularitySubtraction
from cadbem.suspension.interface.motion import normal_velocity
from cadbem.suspension.interface.volume import CorrectVolume
from cadbem.suspension.time.stepping import Euler


def thesis_methods(step: float = 0.01) -> dict[str, Any]:
    """Keyword arguments of ``Simulation`` for the methods of the thesis: Euler's steps, points
    that move with the normal velocity (Eq. 3.12), singularity subtraction (Eq. 4.4), and the
    volume corrected when it is wrong by 0.1 %.  Its splines have degree 2; the mesh is not relaxed.
    """
    return {
        "stepper": Euler(step),
        "motion": normal_velocity,
        "rule": SingularitySubtraction(),
        "volume": CorrectVolume(1e-3),
    }
