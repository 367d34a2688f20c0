"""What the kernel itself says about size and place of its shapes. Part of `_child.py`."""

from __future__ import annotations


def measured(gmsh) -> dict:
    """Area and middle (x, y, z) of each face by the kernel's triangles, which lie on the face with
    their corners, and the volume of each solid; mm."""
    import numpy as np

    gmsh.option.setNumber("General.Verbosity", 0)  # nothing that concerns the file
    gmsh.model.mesh.importStl()
    faces = []
    for _, tag in gmsh.model.getEntities(2):
        tags, coordinates, _ = gmsh.model.mesh.getNodes(2, tag, includeBoundary=True)
        _, nodes = gmsh.model.mesh.getElementsByType(2, tag)  # 2: triangle
        if not len(nodes):  # it could not be triangulated
            occ = gmsh.model.occ
            faces.append([occ.getMass(2, tag), *occ.getCenterOfMass(2, tag)])
            continue
        order = np.argsort(tags)
        index = order[np.searchsorted(tags, nodes, sorter=order)].reshape(-1, 3)
        a, b, c = coordinates.reshape(-1, 3)[index].swapaxes(0, 1)
        areas = 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)
        middle = areas @ (a + b + c) / (3 * max(areas.sum(), 1e-300))
        faces.append([float(areas.sum()), *middle.tolist()])
    volumes = [abs(gmsh.model.occ.getMass(3, tag)) for _, tag in gmsh.model.getEntities(3)]
    return {"measures": faces, "volumes": volumes}
