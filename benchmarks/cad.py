"""How fast a CAD file is read: CPU seconds of the kernel's process and of laying patches.

    python -m benchmarks.cad [FACES ...]     numbers of faces, by default 50 200 800

The model is a ring whose section is a zigzag: untrimmed cone faces only. A file of one face is read
in turn with it, so that what starting the CAD kernel costs can be taken off.
"""

import os
import sys
import tempfile
from math import cos, pi, sin
from pathlib import Path

import gmsh

import cadbem as cb
from benchmarks.table import Table, show

ROUNDS = 2


def zigzag(path: Path, faces: int) -> None:
    """A ring about the z axis; its section is a star with `faces` slanted edges."""
    gmsh.initialize(interruptible=False, readConfigFiles=False)
    gmsh.option.setNumber("General.Terminal", 0)
    occ = gmsh.model.occ
    turns = [2 * pi * (k + 0.25) / faces for k in range(faces)]
    radii = [1.0 + 0.1 * (-1) ** k for k in range(faces)]
    places = zip(radii, turns, strict=True)
    corners = [occ.addPoint(3 + r * cos(t), 0, r * sin(t)) for r, t in places]
    edges = [occ.addLine(a, b) for a, b in zip(corners, corners[1:] + corners[:1], strict=True)]
    section = occ.addPlaneSurface([occ.addCurveLoop(edges)])
    occ.revolve([(2, section)], 0, 0, 0, 0, 0, 1, 2 * pi)
    occ.remove([(2, section)])
    occ.synchronize()
    gmsh.write(str(path))
    gmsh.finalize()


def seconds_to_read(path: Path) -> tuple[float, float]:
    """CPU seconds of the kernel's process and of this one."""
    before = os.times()
    cb.read_cad(path)
    after = os.times()
    kernel = after.children_user - before.children_user
    kernel += after.children_system - before.children_system
    return kernel, after.user + after.system - before.user - before.system


def tables(counts: tuple[int, ...] = (50, 200, 800)) -> list[Table]:
    """Seconds for files with so many faces."""
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        small = Path(folder, "small.step")
        zigzag(small, 4)
        seconds_to_read(small)
        for count in counts:
            path = Path(folder, f"ring_{count}.step")
            zigzag(path, count)
            times = [(seconds_to_read(small)[0], *seconds_to_read(path)) for _ in range(ROUNDS)]
            start, kernel, patches = map(min, zip(*times, strict=True))
            rate = count / (kernel - start + patches)
            rows.append((str(count), f"{kernel:.2f}", f"{patches:.2f}", f"{rate:.0f}"))
    text = """
CPU seconds of the CAD kernel's process and of laying patches, for a ring whose faces are untrimmed
cones. The rate leaves out what starting the kernel costs (a file of four faces, read in turn).
"""
    head = ("faces", "CAD kernel", "patches", "faces a second")
    return [Table("Reading a CAD file", text, head, rows)]


if __name__ == "__main__":
    show(tables(tuple(map(int, sys.argv[1:])) or (50, 200, 800)))
