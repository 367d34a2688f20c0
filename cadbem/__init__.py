"""Stokes flow in microchannels, from CAD files, by isogeometric boundary elements.

The names below are fetched from their modules when first used, so that ``import cadbem`` is
quick.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from cadbem.boundary import Boundary as Boundary
    from cadbem.boundary import Patch as Patch
    from cadbem.cad import inspect_cad as inspect_cad
    from cadbem.cad import mesh_volume as mesh_volume
    from cadbem.cad import read_cad as read_cad
    from cadbem.errors import CadbemError as CadbemError
    from cadbem.errors import CadError as CadError
    from cadbem.errors import ConditionError as ConditionError
    from cadbem.errors import DisplayError as DisplayError
    from cadbem.errors import SelectionError as SelectionError
    from cadbem.post import bezier_grid as bezier_grid
    from cadbem.post import draw_around as draw_around
    from cadbem.post import draw_boundary as draw_boundary
    from cadbem.post import draw_collocation as draw_collocation
    from cadbem.post import draw_slices as draw_slices
    from cadbem.post import draw_streamlines as draw_streamlines
    from cadbem.post import draw_traction as draw_traction
    from cadbem.post import volume_grid as volume_grid
    from cadbem.post import write_mesh as write_mesh
    from cadbem.post import write_vtu as write_vtu
    from cadbem.problems.conditions import Background as Background
    from cadbem.problems.conditions import Inflow as Inflow
    from cadbem.problems.conditions import NoSlip as NoSlip
    from cadbem.problems.conditions import Pressure as Pressure
    from cadbem.problems.conditions import RigidMotion as RigidMotion
    from cadbem.problems.conditions import Traction as Traction
    from cadbem.problems.conditions import Velocity as Velocity
    from cadbem.problems.heat import HeatProblem as HeatProblem
    from cadbem.problems.heat_conditions import HeatFlux as HeatFlux
    from cadbem.problems.heat_conditions import SurfaceExchange as SurfaceExchange
    from cadbem.problems.heat_conditions import Temperature as Temperature
    from cadbem.problems.heat_solution import HeatSolution as HeatSolution
    from cadbem.problems.solution import StokesSolution as StokesSolution
    from cadbem.problems.stokes import StokesProblem as StokesProblem
    from cadbem.quadrature.options import Quadrature as Quadrature
    from cadbem.script import fresh_folder as fresh_folder
    from cadbem.script import run as run
    from cadbem.space import Field as Field
    from cadbem.space import Space as Space
    from cadbem.spline import Nurbs as Nurbs
    from cadbem.spline.shapes import box as box
    from cadbem.spline.shapes import cylinder as cylinder
    from cadbem.spline.shapes import ellipsoid as ellipsoid
    from cadbem.spline.shapes import plate as plate
    from cadbem.spline.shapes import sphere as sphere
    from cadbem.spline.shapes import sphere_octants as sphere_octants
    from cadbem.spline.shapes import sphere_with_poles as sphere_with_poles

__version__ = "0.1.0"

_NAMES = {
    "boundary": ("Boundary", "Patch"),
    "cad": ("inspect_cad", "mesh_volume", "read_cad"),
    "errors": ("CadError", "CadbemError", "ConditionError", "DisplayError", "SelectionError"),
    "post": (
        "bezier_grid",
        "draw_around",
        "draw_boundary",
        "draw_collocation",
        "draw_slices",
        "draw_streamlines",
        "draw_traction",
        "volume_grid",
        "write_mesh",
        "write_vtu",
    ),
    "problems.conditions": (
        "Background",
        "Inflow",
        "NoSlip",
        "Pressure",
        "RigidMotion",
        "Traction",
        "Velocity",
    ),
    "problems.heat": ("HeatProblem",),
    "problems.heat_conditions": ("HeatFlux", "SurfaceExchange", "Temperature"),
    "problems.heat_solution": ("HeatSolution",),
    "problems.solution": ("StokesSolution",),
    "problems.stokes": ("StokesProblem",),
    "quadrature.options": ("Quadrature",),
    "script": ("fresh_folder", "run"),
    "space": ("Field", "Space"),
    "spline": ("Nurbs",),
    "spline.shapes": (
        "box",
        "cylinder",
        "ellipsoid",
        "plate",
        "sphere",
        "sphere_octants",
        "sphere_with_poles",
    ),
}
_MODULES = {name: f"cadbem.{module}" for module, names in _NAMES.items() for name in names}


def __getattr__(name: str) -> Any:
    if name not in _MODULES:
        raise AttributeError(f"module 'cadbem' has no attribute '{name}'")
    value = getattr(import_module(_MODULES[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted([*_MODULES, "__version__"])
