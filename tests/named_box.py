"""The box [0, 1] × [0, 2] × [0, 3] as a file, for tests of what is written beside the geometry.

Its faces are called after the coordinate that is constant on them, and its value: "x0" is the face
in the plane x = 0, whose middle is (0, 1, 1.5).
"""

import re
from pathlib import Path

import gmsh
import numpy as np

from cadbem.cad import write_cad

occ = gmsh.model.occ
SIZES = np.array([1.0, 2.0, 3.0])


def named_box(path: Path, scale: float = 1.0) -> Path:
    occ.addBox(0, 0, 0, *SIZES * scale)
    occ.synchronize()
    names = {}
    for _, tag in gmsh.model.getEntities(2):
        middle = np.array(occ.getCenterOfMass(2, tag)) / scale
        axis = int(np.argmax(np.abs(middle - SIZES / 2)))
        names[tag] = f"{'xyz'[axis]}{middle[axis]:.0f}"
    write_cad(path, names)
    return path


def middle_of(face: str) -> np.ndarray:
    middle = SIZES / 2
    middle["xyz".index(face[0])] = float(face[1])
    return middle


def with_lines(path: Path, lines: str) -> Path:
    """The STEP file with entities added; {x0} stands for that face, {solid} for the solid."""
    text = path.read_text()
    numbers = {name: f"#{n}" for n, name in re.findall(r"#(\d+) = ADVANCED_FACE\('(\w+)'", text)}
    solid = re.search(r"#(\d+) = MANIFOLD_SOLID_BREP", text)
    shell = re.search(r"#(\d+) = CLOSED_SHELL", text)
    assert solid is not None
    assert shell is not None
    lines = lines.format(solid=f"#{solid[1]}", shell=f"#{shell[1]}", **numbers)
    path.write_text(text.replace("ENDSEC;\nEND-ISO", f"{lines}\nENDSEC;\nEND-ISO"))
    return path
