"""What the drawings in this folder share: cells are drawn, swept, joined to one solid, written.

A channel is drawn in plan as four-sided faces that share their edges. Sweeping them gives cells
with six faces; the faces that only one cell has bound the fluid, and become one closed solid of
four-sided faces. The coordinates are dimensionless; the files call them millimetres.
"""

import sys
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

import gmsh

from cadbem.cad.export.write_model import write_cad

Point = tuple[float, float, float]


@dataclass(frozen=True)
class Drawing:
    """Corners and edges, each drawn once however many faces use it; edges are straight unless
    an arc or spline was drawn between the same corners before.
    """

    corners: dict[Point, int] = field(default_factory=dict)
    edges: dict[frozenset[Point], int] = field(default_factory=dict)

    def corner(self, point: Point) -> int:
        if point not in self.corners:
            self.corners[point] = gmsh.model.occ.addPoint(*point)
        return self.corners[point]

    def edge(self, start: Point, end: Point) -> int:
        key = frozenset((start, end))
        if key not in self.edges:
            self.edges[key] = gmsh.model.occ.addLine(self.corner(start), self.corner(end))
        return self.edges[key]

    def arc(self, start: Point, centre: Point, end: Point) -> None:
        """The circular arc below 180 degrees from `start` to `end`."""
        middle = gmsh.model.occ.addPoint(*centre)
        tag = gmsh.model.occ.addCircleArc(self.corner(start), middle, self.corner(end))
        gmsh.model.occ.remove([(0, middle)])
        self.edges[frozenset((start, end))] = tag

    def spline(self, points: Sequence[Point], knots: Sequence[float]) -> None:
        """The clamped cubic B-spline with these control points and distinct `knots`."""
        inner = [gmsh.model.occ.addPoint(*point) for point in points[1:-1]]
        tags = [self.corner(points[0]), *inner, self.corner(points[-1])]
        multiplicities = [4, *[1] * (len(knots) - 2), 4]
        tag = gmsh.model.occ.addBSpline(
            tags, degree=3, knots=list(knots), multiplicities=multiplicities
        )
        gmsh.model.occ.remove([(0, point) for point in inner])
        self.edges[frozenset((points[0], points[-1]))] = tag

    def face(self, *corners: Point) -> int:
        """The plane face with these corners, in order around it."""
        around = zip(corners, corners[1:] + corners[:1], strict=True)
        loop = gmsh.model.occ.addCurveLoop([self.edge(start, end) for start, end in around])
        return gmsh.model.occ.addPlaneSurface([loop])

    def disk(self, x: float, radius: float) -> list[int]:
        """The disk at `x` about the x axis: a square and four pieces with a 90-degree arc each."""
        ring = [(radius * y, radius * z) for y, z in _SQUARE]
        outer = [(x, y, z) for y, z in ring]
        inner = [(x, y / 2, z / 2) for y, z in ring]
        faces = [self.face(*inner)]
        for here, there in ((0, 1), (1, 2), (2, 3), (3, 0)):
            self.arc(outer[here], (x, 0.0, 0.0), outer[there])
            faces.append(self.face(inner[here], outer[here], outer[there], inner[there]))
        return faces


_HALF_ROOT = 0.5**0.5
_SQUARE = [
    (-_HALF_ROOT, -_HALF_ROOT), (_HALF_ROOT, -_HALF_ROOT),
    (_HALF_ROOT, _HALF_ROOT), (-_HALF_ROOT, _HALF_ROOT),
]  # fmt: skip


def extruded(faces: Sequence[int], shift: Point) -> tuple[list[int], list[int]]:
    """Cells swept along `shift`, and the faces at their far ends."""
    return _cells(gmsh.model.occ.extrude([(2, face) for face in faces], *shift))


def revolved(
    faces: Sequence[int], centre: Point, axis: Point, angle: float
) -> tuple[list[int], list[int]]:
    """Cells swept about the axis through `centre` by `angle` (radians), and their far faces."""
    return _cells(gmsh.model.occ.revolve([(2, face) for face in faces], *centre, *axis, angle))


def _cells(swept: list[tuple[int, int]]) -> tuple[list[int], list[int]]:
    """gmsh lists, for each face swept, the far face, the cell, and the sides."""
    places = [index for index, (dimension, _) in enumerate(swept) if dimension == 3]
    return [swept[index][1] for index in places], [swept[index - 1][1] for index in places]


def joined(cells: Sequence[int]) -> None:
    """Replace the cells by the one solid that they fill, keeping their outer faces."""
    occ = gmsh.model.occ
    uses = Counter(face for cell in cells for face in _faces_of(cell))
    occ.remove([(3, cell) for cell in cells])
    outer = [face for face, count in uses.items() if count == 1]
    solid = occ.addVolume([occ.addSurfaceLoop(outer)])
    kept = set(_faces_of(solid))  # OpenCASCADE replaces some faces, with other tags
    left = [(2, face) for _, face in occ.getEntities(2) if face not in kept]
    occ.remove(left, recursive=True)


def _faces_of(cell: int) -> list[int]:
    _, loops = gmsh.model.occ.getSurfaceLoops(cell)
    return [int(face) for faces in loops for face in faces]


@contextmanager
def written(script: str, names: dict[str, Callable[[Point], float]]) -> Iterator[Drawing]:
    """Draw in the body; on leaving it, `<script>.step` and `.igs` are written beside the script.

    A face all of whose corners are zeros of a function in `names` gets its name, the others are
    `walls`. A folder given on the command line is written to instead.
    """
    source = Path(script)
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else source.parent
    gmsh.initialize(interruptible=False, readConfigFiles=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        yield Drawing()
        gmsh.model.occ.synchronize()
        tags = {face: _name_of(face, names) for _, face in gmsh.model.getEntities(2)}
        for suffix in (".step", ".igs"):
            write_cad(folder / f"{source.stem}{suffix}", tags)
    finally:
        gmsh.finalize()


def _name_of(face: int, names: dict[str, Callable[[Point], float]]) -> str:
    ends = gmsh.model.getBoundary([(2, face)], combined=False, recursive=True)
    corners = [gmsh.model.getValue(0, tag, []) for _, tag in ends]
    for name, plane in names.items():
        if all(abs(plane(corner)) < 1e-9 for corner in corners):
            return name
    return "walls"
