"""The CAD kernel at work, in a process of its own: it may print, crash or hang.

Run as a script: `_child.py record INPUT FOLDER` or `_child.py mesh INPUT FOLDER SIZE` (mm).
Writes `model.json` with what was found, and `model.brep` (faces, exactly) or `mesh.npz`
(tetrahedra) into the folder. Imports nothing from the project, so that it starts quickly.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path

SEWING = (1e-9, 1e-8, 1e-7, 1e-6)  # tolerances tried, per size of the model


def main(task: str, source: str, folder: str, size: str = "") -> None:
    import gmsh

    gmsh.initialize(interruptible=False, readConfigFiles=False)
    gmsh.option.setNumber("General.Verbosity", 2)
    try:
        found = _import(gmsh, source)
        if task == "record" and found["faces"]:
            gmsh.write(str(Path(folder, "model.brep")))
        elif task == "mesh" and len(found["solids"]) == 1:
            _mesh(gmsh, float(size), Path(folder, "mesh.npz"))
    except Exception as error:  # whatever the kernel throws, the parent words it
        found = {"error": str(error)}
    Path(folder, "model.json").write_text(json.dumps(found))
    gmsh.finalize()


def _import(gmsh, source: str) -> dict:
    _load(gmsh, source)
    loose = len(gmsh.model.getEntities(2))
    sewn = False
    if loose and not gmsh.model.getEntities(3):
        sewn = _sew(gmsh, source)
    return {
        "faces": len(gmsh.model.getEntities(2)),
        "curves": len(gmsh.model.getEntities(1)),
        "sewn": sewn,
        "solids": [_solid(gmsh, tag) for _, tag in gmsh.model.getEntities(3)],
    }


def _load(gmsh, source: str) -> None:
    gmsh.clear()
    gmsh.model.occ.importShapes(source, highestDimOnly=False)
    gmsh.model.occ.synchronize()


def _sew(gmsh, source: str) -> bool:
    """Join loose faces into a solid; if that fails, leave them as they were."""
    box = gmsh.model.getBoundingBox(-1, -1)
    size = max(high - low for low, high in zip(box[:3], box[3:], strict=True))
    for tolerance in SEWING:
        _load(gmsh, source)
        gmsh.model.occ.healShapes(
            [],  # all at once: given one by one, faces would not be joined
            tolerance=tolerance * size,
            fixDegenerated=False,
            fixSmallEdges=False,
            fixSmallFaces=False,
            sewFaces=True,
            makeSolids=True,
        )
        gmsh.model.occ.synchronize()
        if gmsh.model.getEntities(3):
            return True
    _load(gmsh, source)
    return False


def _solid(gmsh, tag: int) -> dict:
    return {
        "name": gmsh.model.getEntityName(3, tag).split("/")[-1],
        "box": list(gmsh.model.getBoundingBox(3, tag)),
        "faces": len(gmsh.model.getBoundary([(3, tag)], oriented=False)),
    }


def _mesh(gmsh, size: float, target: Path) -> None:
    import numpy as np

    gmsh.option.setNumber("Mesh.MeshSizeMax", size)
    gmsh.option.setNumber("Mesh.MeshSizeFromPoints", 0)
    gmsh.model.mesh.generate(3)
    tags, coordinates, _ = gmsh.model.mesh.getNodes()
    _, nodes = gmsh.model.mesh.getElementsByType(4)  # 4: tetrahedron of four nodes
    corners = np.array(nodes, dtype=np.int64)
    used = np.unique(corners)
    index = np.zeros(int(tags.max()) + 1, dtype=np.int64)
    index[tags] = np.arange(len(tags))
    points = coordinates.reshape(-1, 3)[index[used]]
    np.savez(target, points=points.T, tetrahedra=np.searchsorted(used, corners).reshape(-1, 4).T)


if __name__ == "__main__":
    main(*sys.argv[1:])
