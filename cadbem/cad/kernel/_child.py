"""The child process in which the CAD kernel runs, as it may print, crash or hang.

Run as a script: `_child.py record INPUT FOLDER ROOM SEW`, `_child.py mesh INPUT FOLDER SIZE` (mm).
SEW is the largest gap, per size, that is sewn, 0 for the usual ones.
ROOM is "solid" (the file's shapes as they are), "all" (solids that touch made to share their faces)
or "void" (the solids' box without the solids); `_child.py section INPUT FOLDER PLANE` makes plane
figures. Writes `model.json` with what was
found, and `model.brep` (faces, exactly) or `mesh.npz` (tetrahedra) into the folder. Imports
nothing from the project, so that it starts quickly.
"""

from __future__ import annotations

import json
import os
import sys
from pathlib import Path
from runpy import run_path


def main(task: str, source: str, folder: str, option: str, sew: str = "0") -> None:
    limit_memory()
    import gmsh

    gmsh.initialize(interruptible=False, readConfigFiles=False)
    gmsh.option.setNumber("General.Verbosity", 2)
    try:
        section = task == "section"
        found = _section(gmsh, source, option) if section else _import(gmsh, source, float(sew))
        if section:
            gmsh.write(str(Path(folder, "model.brep")))
        elif task == "record":
            found |= _prepared(gmsh, option)
            if found["faces"]:
                gmsh.write(str(Path(folder, "model.brep")))
                found |= _beside("_witness")["measured"](gmsh)
        elif len(found["solids"]) == 1:
            _mesh(gmsh, float(option), Path(folder, "mesh.npz"))
    except Exception as error:  # whatever the kernel throws, the parent words it
        found = {"error": str(error) or type(error).__name__}
    _check_room(Path(folder, "room"))
    Path(folder, "model.json").write_text(json.dumps(found))
    gmsh.finalize()


def limit_memory(share: float = 0.75) -> None:
    """A file that asks for more than this share of the machine's memory ends this process."""
    try:
        import resource
    except ImportError:  # Windows
        return
    most = int(share * os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES"))
    resource.setrlimit(resource.RLIMIT_AS, (most, most))


def _check_room(path: Path) -> None:
    """Fails where the disk is full: the kernel writes what fits, and says nothing."""
    path.write_bytes(bytes(2**16))
    path.unlink()


def _import(gmsh, source: str, sew: float) -> dict:
    found = _beside("_joining")["imported"](gmsh, source, sew)
    return _found(gmsh) | found


def _beside(name: str) -> dict:
    """The names of another part of the child."""
    return run_path(str(Path(__file__).with_name(f"{name}.py")))


def _found(gmsh) -> dict:
    return {
        "faces": len(gmsh.model.getEntities(2)),
        "curves": len(gmsh.model.getEntities(1)),
        "solids": [gmsh.model.getEntityName(*solid) for solid in gmsh.model.getEntities(3)],
    }


# The fluid's room


def _prepared(gmsh, room: str) -> dict:
    """The file's shapes, or the box without them: see the top of this file."""
    solids = gmsh.model.getEntities(3)
    if room == "all" and len(solids) > 1:
        gmsh.model.occ.removeAllDuplicates()
        gmsh.model.occ.synchronize()
        return _found(gmsh)
    if room == "void" and solids:
        box, flat = _beside("_surrounding_box")["room_box"](gmsh, solids)
        sides = [high - low for low, high in zip(box[:3], box[3:], strict=True)]
        gmsh.model.occ.cut([(3, gmsh.model.occ.addBox(*box[:3], *sides))], solids)
        gmsh.model.occ.synchronize()
        return _found(gmsh) | {"box": box, "flat": flat}
    return {}


# Plane figures


def _section(gmsh, source: str, plane: str) -> dict:
    """The faces in which solids meet a plane (a point and the normal, JSON, mm); without a plane
    those that closed wires bound, one each, and the ends of wires that are open."""
    occ, model = gmsh.model.occ, gmsh.model
    gmsh.model.occ.importShapes(source, highestDimOnly=False)
    occ.synchronize()
    if plane:
        solids = model.getEntities(3)
        occ.intersect([(2, _plane_face(gmsh, *json.loads(plane)))], solids)
        occ.synchronize()
        return {"faces": len(model.getEntities(2)), "open": []}
    occ.removeAllDuplicates()
    occ.synchronize()
    ends = {tag: list(model.getAdjacencies(1, tag)[1]) for _, tag in model.getEntities(1)}
    uses: dict = {}
    for curve, corners in ends.items():
        for corner in corners:
            uses.setdefault(corner, []).append(curve)
    loose = [c for c, curves in uses.items() if len(curves) == 1 and len(set(ends[curves[0]])) > 1]
    if not loose:
        try:
            for wire in _wires(ends, uses):
                occ.addPlaneSurface([occ.addCurveLoop(wire)])
        except Exception:  # not in a plane, or across each other
            return {"faces": 0, "open": []}
        occ.synchronize()
    places = [list(map(float, model.getValue(0, corner, []))) for corner in loose]
    return {"faces": len(model.getEntities(2)), "open": places}


def _wires(ends: dict, uses: dict) -> list[list[int]]:
    """Curves that follow each other from end to end."""
    left, wires = set(ends), []
    while left:
        wire = [min(left)]
        end = ends[wire[0]][-1]
        while following := [tag for tag in uses[end] if tag in left - {wire[0]}]:
            wire.append(following[0])
            left.remove(following[0])
            end = next((other for other in ends[following[0]] if other != end), end)
        left.remove(wire[0])
        wires.append(wire)
    return wires


def _plane_face(gmsh, point: list, normal: list) -> int:
    """A square in the plane, larger than the model."""
    import numpy as np

    occ, n = gmsh.model.occ, np.array(normal) / np.linalg.norm(normal)
    low, high = np.reshape(gmsh.model.getBoundingBox(-1, -1), (2, 3))
    middle = 0.5 * (low + high)
    middle -= (middle - point) @ n * n
    x = np.cross(n, np.eye(3)[np.argmin(np.abs(n))])
    x *= np.linalg.norm(high - low) / np.linalg.norm(x)
    y = np.cross(n, x)
    signs = ((1, 1), (-1, 1), (-1, -1), (1, -1))
    corners = [occ.addPoint(*(middle + a * x + b * y)) for a, b in signs]
    sides = [occ.addLine(corners[k - 1], corners[k]) for k in range(4)]
    return occ.addPlaneSurface([occ.addCurveLoop(sides)])


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
