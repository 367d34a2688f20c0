"""Stokes flow in microchannels, from CAD files, by isogeometric boundary elements.

The names below are fetched from their modules when first used, so that ``import cadbem`` is
quick.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from cadbem.boundary import Boundary as Boundary
    from cadbem.boundary import Patch as Patch
    from cadbem.errors import CadbemError as CadbemError
    from cadbem.errors import CadError as CadError
    from cadbem.errors import ConditionError as ConditionError
    from cadbem.errors import DisplayError as DisplayError
    from cadbem.errors import SelectionError as SelectionError
    from cadbem.spline import Nurbs as Nurbs

__version__ = "0.1.0"

_MODULES = {
    "Boundary": "cadbem.boundary",
    "CadError": "cadbem.errors",
    "CadbemError": "cadbem.errors",
    "ConditionError": "cadbem.errors",
    "DisplayError": "cadbem.errors",
    "Nurbs": "cadbem.spline",
    "Patch": "cadbem.boundary",
    "SelectionError": "cadbem.errors",
}


def __getattr__(name: str) -> Any:
    if name not in _MODULES:
        raise AttributeError(f"module 'cadbem' has no attribute '{name}'")
    value = getattr(import_module(_MODULES[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted([*_MODULES, "__version__"])
