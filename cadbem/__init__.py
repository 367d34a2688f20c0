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
    from cadbem.cad import read_layout as read_layout
    from cadbem.cad import read_outline as read_outline
    from cadbem.cad import write_patches as write_patches
    from cadbem.design.deformation_limit import ShearDeformation as ShearDeformation
    from cadbem.design.deformation_limit import largest_capillary as largest_capillary
    from cadbem.design.deformation_limit import largest_deformation as largest_deformation
    from cadbem.design.fate import Fate as Fate
    from cadbem.design.fate import droplet_fate as droplet_fate
    from cadbem.design.fate import droplet_fates as droplet_fates
    from cadbem.design.fate import fate_of as fate_of
    from cadbem.design.fate import fates_report as fates_report
    from cadbem.design.network import Network as Network
    from cadbem.design.network import OperatingPoint as OperatingPoint
    from cadbem.design.network import hydraulic_network as hydraulic_network
    from cadbem.design.network import network_of as network_of
    from cadbem.design.network import tube_resistance as tube_resistance
    from cadbem.design.release_points import ReleasePoints as ReleasePoints
    from cadbem.design.release_points import inlet_points as inlet_points
    from cadbem.design.residence import residence_report as residence_report
    from cadbem.design.run_report import bodies_report as bodies_report
    from cadbem.design.run_report import course_report as course_report
    from cadbem.design.tracers import Tracers as Tracers
    from cadbem.design.tracers import trace as trace
    from cadbem.design.wall_shear import WallShear as WallShear
    from cadbem.design.wall_shear import wall_shear as wall_shear
    from cadbem.errors import AccuracyWarning as AccuracyWarning
    from cadbem.errors import CadbemError as CadbemError
    from cadbem.errors import CadError as CadError
    from cadbem.errors import CadWarning as CadWarning
    from cadbem.errors import ConditionError as ConditionError
    from cadbem.errors import DisplayError as DisplayError
    from cadbem.errors import InputError as InputError
    from cadbem.errors import ResultsError as ResultsError
    from cadbem.errors import SelectionError as SelectionError
    from cadbem.errors import ShapeError as ShapeError
    from cadbem.errors import UnitsError as UnitsError
    from cadbem.extension import extended as extended
    from cadbem.operators.compressed.storage import Compressed as Compressed
    from cadbem.operators.compressed.storage import Dense as Dense
    from cadbem.operators.far.equivalent import FarField as FarField
    from cadbem.post import Frame as Frame
    from cadbem.post import bezier_grid as bezier_grid
    from cadbem.post import draw_around as draw_around
    from cadbem.post import draw_boundary as draw_boundary
    from cadbem.post import draw_collocation as draw_collocation
    from cadbem.post import draw_droplets as draw_droplets
    from cadbem.post import draw_flow as draw_flow
    from cadbem.post import draw_movie as draw_movie
    from cadbem.post import draw_outlines as draw_outlines
    from cadbem.post import draw_paths as draw_paths
    from cadbem.post import draw_run as draw_run
    from cadbem.post import draw_scene as draw_scene
    from cadbem.post import draw_series as draw_series
    from cadbem.post import draw_slices as draw_slices
    from cadbem.post import draw_solution as draw_solution
    from cadbem.post import draw_streamlines as draw_streamlines
    from cadbem.post import draw_traction as draw_traction
    from cadbem.post import draw_trajectories as draw_trajectories
    from cadbem.post import filmstrip as filmstrip
    from cadbem.post import volume_grid as volume_grid
    from cadbem.post import write_droplets as write_droplets
    from cadbem.post import write_frames as write_frames
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
    from cadbem.results import RunFolder as RunFolder
    from cadbem.results import StoredRun as StoredRun
    from cadbem.results import open_run as open_run
    from cadbem.results import render as render
    from cadbem.results import run_folder as run_folder
    from cadbem.script import run as run
    from cadbem.space import Field as Field
    from cadbem.space import Space as Space
    from cadbem.spline import Nurbs as Nurbs
    from cadbem.spline.closed import ClosedSpline as ClosedSpline
    from cadbem.spline.closed import closed_spline as closed_spline
    from cadbem.spline.closed_shapes import spline_circle as spline_circle
    from cadbem.spline.closed_shapes import spline_ellipse as spline_ellipse
    from cadbem.spline.closed_shapes import spline_ellipsoid as spline_ellipsoid
    from cadbem.spline.closed_shapes import spline_sphere as spline_sphere
    from cadbem.spline.shapes import box as box
    from cadbem.spline.shapes import cylinder as cylinder
    from cadbem.spline.shapes import ellipsoid as ellipsoid
    from cadbem.spline.shapes import plate as plate
    from cadbem.spline.shapes import sphere as sphere
    from cadbem.spline.shapes import sphere_octants as sphere_octants
    from cadbem.suspension.bodies.droplet import Droplet as Droplet
    from cadbem.suspension.bodies.particle import RigidParticle as RigidParticle
    from cadbem.suspension.bodies.plug import plug as plug
    from cadbem.suspension.bodies.rigid_shapes import rigid_ellipsoid as rigid_ellipsoid
    from cadbem.suspension.bodies.rigid_shapes import rigid_sphere as rigid_sphere
    from cadbem.suspension.interface.laws import Bending as Bending
    from cadbem.suspension.interface.laws import SurfaceTension as SurfaceTension
    from cadbem.suspension.interface.laws import capillary_tension as capillary_tension
    from cadbem.suspension.interface.membrane import InextensibleMembrane as InextensibleMembrane
    from cadbem.suspension.interface.mesh import RelaxMesh as RelaxMesh
    from cadbem.suspension.interface.motion import affine_velocity as affine_velocity
    from cadbem.suspension.interface.motion import full_velocity as full_velocity
    from cadbem.suspension.interface.motion import normal_velocity as normal_velocity
    from cadbem.suspension.interface.points import AdaptivePoints as AdaptivePoints
    from cadbem.suspension.interface.volume import CorrectVolume as CorrectVolume
    from cadbem.suspension.multibody.contact import Repel as Repel
    from cadbem.suspension.multibody.contact import StopAtError as StopAtError
    from cadbem.suspension.multibody.contact import StopAtGap as StopAtGap
    from cadbem.suspension.multibody.measures import inclination as inclination
    from cadbem.suspension.multibody.measures import taylor_deformation as taylor_deformation
    from cadbem.suspension.surroundings.channel_flow import ChannelFlow as ChannelFlow
    from cadbem.suspension.surroundings.flows import UserFlow as UserFlow
    from cadbem.suspension.surroundings.flows import at_rest as at_rest
    from cadbem.suspension.surroundings.flows import linear_flow as linear_flow
    from cadbem.suspension.surroundings.flows import pipe_poiseuille as pipe_poiseuille
    from cadbem.suspension.surroundings.flows import plane_extension as plane_extension
    from cadbem.suspension.surroundings.flows import plane_poiseuille as plane_poiseuille
    from cadbem.suspension.surroundings.flows import shear as shear
    from cadbem.suspension.surroundings.flows import uniaxial_extension as uniaxial_extension
    from cadbem.suspension.surroundings.free_flow import FreeFlow as FreeFlow
    from cadbem.suspension.time.history import Course as Course
    from cadbem.suspension.time.history import History as History
    from cadbem.suspension.time.history import record as record
    from cadbem.suspension.time.simulation import Simulation as Simulation
    from cadbem.suspension.time.state import State as State
    from cadbem.suspension.time.stepping import Adaptive as Adaptive
    from cadbem.suspension.time.stepping import Euler as Euler
    from cadbem.tables import text_table as text_table
    from cadbem.units import Numbers as Numbers
    from cadbem.units import Quantity as Quantity
    from cadbem.units import Units as Units
    from cadbem.units import numbers as numbers

__version__ = "0.1.0"

_NAMES = {
    "boundary": ("Boundary", "Patch"),
    "cad": (
        "inspect_cad", "mesh_volume", "read_cad", "read_layout", "read_outline", "write_patches",
    ),
    "design.deformation_limit": ("ShearDeformation", "largest_capillary", "largest_deformation"),
    "design.fate": ("Fate", "droplet_fate", "droplet_fates", "fate_of", "fates_report"),
    "design.network": (
        "Network", "OperatingPoint", "hydraulic_network", "network_of", "tube_resistance",
    ),  # fmt: skip
    "design.release_points": ("ReleasePoints", "inlet_points"),
    "design.residence": ("residence_report",),
    "design.run_report": ("bodies_report", "course_report"),
    "design.tracers": ("Tracers", "trace"),
    "design.wall_shear": ("WallShear", "wall_shear"),
    "errors": (
        "AccuracyWarning", "CadError", "CadWarning", "CadbemError", "ConditionError",
        "DisplayError", "InputError", "ResultsError", "SelectionError", "ShapeError",
        "UnitsError",
    ),  # fmt: skip
    "extension": ("extended",),
    "operators.compressed.storage": ("Compressed", "Dense"),
    "operators.far.equivalent": ("FarField",),
    "post": (
        "Frame", "bezier_grid", "draw_around", "draw_boundary", "draw_collocation",
        "draw_droplets", "draw_flow", "draw_movie", "draw_outlines", "draw_paths", "draw_run",
        "draw_scene", "draw_series", "draw_slices", "draw_solution", "draw_streamlines",
        "draw_traction", "draw_trajectories", "filmstrip", "volume_grid", "write_droplets",
        "write_frames", "write_mesh", "write_vtu",
    ),  # fmt: skip
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
    "results": ("RunFolder", "StoredRun", "open_run", "render", "run_folder"),
    "script": ("run",),
    "space": ("Field", "Space"),
    "spline": ("Nurbs",),
    "spline.closed": ("ClosedSpline", "closed_spline"),
    "spline.closed_shapes": (
        "spline_circle",
        "spline_ellipse",
        "spline_ellipsoid",
        "spline_sphere",
    ),
    "spline.shapes": ("box", "cylinder", "ellipsoid", "plate", "sphere", "sphere_octants"),
    "suspension.bodies.droplet": ("Droplet",),
    "suspension.bodies.particle": ("RigidParticle",),
    "suspension.bodies.plug": ("plug",),
    "suspension.bodies.rigid_shapes": ("rigid_ellipsoid", "rigid_sphere"),
    "suspension.interface.laws": ("Bending", "SurfaceTension", "capillary_tension"),
    "suspension.interface.membrane": ("InextensibleMembrane",),
    "suspension.interface.mesh": ("RelaxMesh",),
    "suspension.interface.motion": ("affine_velocity", "full_velocity", "normal_velocity"),
    "suspension.interface.points": ("AdaptivePoints",),
    "suspension.interface.volume": ("CorrectVolume",),
    "suspension.multibody.contact": ("Repel", "StopAtError", "StopAtGap"),
    "suspension.multibody.measures": ("inclination", "taylor_deformation"),
    "suspension.surroundings.channel_flow": ("ChannelFlow",),
    "suspension.surroundings.flows": (
        "UserFlow",
        "at_rest",
        "linear_flow",
        "pipe_poiseuille",
        "plane_extension",
        "plane_poiseuille",
        "shear",
        "uniaxial_extension",
    ),
    "suspension.surroundings.free_flow": ("FreeFlow",),
    "suspension.time.history": ("Course", "History", "record"),
    "suspension.time.simulation": ("Simulation",),
    "suspension.time.state": ("State",),
    "suspension.time.stepping": ("Adaptive", "Euler"),
    "tables": ("text_table",),
    "units": ("Numbers", "Quantity", "Units", "numbers"),
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
