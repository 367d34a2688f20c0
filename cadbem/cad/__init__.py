"""Reading and writing CAD files; gmsh's OpenCASCADE is loaded only where it works."""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from cadbem.cad.export.export import write_patches as write_patches
    from cadbem.cad.export.write_model import write_cad as write_cad
    from cadbem.cad.layout_solid import read_layout as read_layout
    from cadbem.cad.plane import read_outline as read_outline
    from cadbem.cad.read import read_cad as read_cad
    from cadbem.cad.report import CadReport as CadReport
    from cadbem.cad.report import FaceReport as FaceReport
    from cadbem.cad.report import inspect_cad as inspect_cad
    from cadbem.cad.volume_mesh import mesh_volume as mesh_volume

_MODULES = {
    "CadReport": "report",
    "FaceReport": "report",
    "inspect_cad": "report",
    "mesh_volume": "volume_mesh",
    "read_cad": "read",
    "read_layout": "layout_solid",
    "read_outline": "plane",
    "write_cad": "export.write_model",
    "write_patches": "export.export",
}


def __getattr__(name: str) -> Any:
    if name not in _MODULES:
        raise AttributeError(f"module 'cadbem.cad' has no attribute '{name}'")
    return getattr(import_module(f"cadbem.cad.{_MODULES[name]}"), name)
