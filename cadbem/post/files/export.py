"""Files for other programs: ``.vtu`` for ParaView, and what meshio writes."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from cadbem.errors import CadbemError
from cadbem.files import make_folder, write_whole

# meshio offers Ansys first for .msh, a format that drops the fields
_PREFERRED = {".msh": "gmsh"}
# XDMF with its numbers in the same file needs no HDF5 library
_OPTIONS: dict[str, dict[str, str]] = {"xdmf": {"data_format": "XML"}}


def write_vtu(path: str | Path, grid: Any) -> Path:
    """Write a grid (see ``bezier_grid``, ``volume_grid``) to a ``.vtu`` file, exactly.

    Raises ``CadbemError`` when the name ends otherwise, ``ResultsError`` when it cannot be written.
    """
    target = prepared(path)
    if target.suffix != ".vtu":
        raise CadbemError(f"{target}: a grid is written to a file that ends in .vtu")
    from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridWriter

    writer = vtkXMLUnstructuredGridWriter()
    writer.SetInputData(grid)
    writer.SetDataModeToBinary()
    writer.WriteToOutputStringOn()
    writer.Write()
    write_whole(target, writer.GetOutputString().encode())
    return target


def write_mesh(path: str | Path, grid: Any) -> Path:
    """Write a mesh of flat cells (``volume_grid``, ``tessellated``) in the format of the ending.

    ``.xdmf``, ``.msh`` (Gmsh), ``.vtk``, ``.vtu``, ``.stl`` and whatever else meshio knows.
    Raises ``CadbemError`` for an ending that it does not know or a mesh the format cannot hold.
    """
    import meshio
    import pyvista

    target = prepared(path)
    known = meshio.extension_to_filetypes
    if target.suffix not in known:
        raise CadbemError(
            f"{target}: no mesh format ends in '{target.suffix}'; choose among {' '.join(known)}"
        )
    kind = _PREFERRED.get(target.suffix, known[target.suffix][0])
    # triangles are what every format for surfaces can hold
    mesh = pyvista.to_meshio(grid.triangulate() if isinstance(grid, pyvista.PolyData) else grid)
    mesh.field_data = {}
    try:
        meshio.write(target, mesh, kind, **_OPTIONS.get(kind, {}))
    except ModuleNotFoundError as error:
        raise CadbemError(
            f"{target}: the format '{kind}' needs a library; type: pip install {error.name}"
        ) from error
    except Exception as error:  # meshio's writers fail each in its own way
        raise CadbemError(
            f"{target}: the format '{kind}' cannot hold this mesh ({error}); choose another one"
        ) from error
    return target


def prepared(path: str | Path) -> Path:
    """The path, with its folder made if it was not there."""
    target = Path(path)
    make_folder(target.parent)
    return target
