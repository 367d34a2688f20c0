"""Chips and connectors as people draw them, whose room is the fluid: `read_cad(between=...)` and
`read_layout`. Written beside this script, or into a folder given on the command line.

`pdms_block.step`: a block 6 × 4 × 2 on a larger slide, a groove 4 × 0.6 × 0.4 in its underside, and
wells of radius 0.5 punched through at both ends. V of the room: 0.96 + π/2 (2 · 2) · 0.5 less what
groove and wells share.
`luer.step`: a hub with a flange, a cone of 6 % from radius 2 to 1.64 over 6, a bore of radius 0.5
and length 3 and a stub with it, 2 long: V = 2π (2² + 2 · 1.64 + 1.64²) + 1.25π.
`manifold.step`: a base with a bore of 0.8 × 0.8 along it and two blocks on it, each with a bore of
radius 0.3 up, of different heights: V = 0.64 · 8 + 0.09π ((0.6 + 1) + (0.6 + 2)).
`mixer.dxf`: two inlets of 100 µm and a bend between them and the outlet, in a frame.
"""

import sys
from math import pi, tan
from pathlib import Path

import ezdxf
import gmsh

occ = gmsh.model.occ
FOLDER = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parent


def turned(profile: list[tuple[float, float]]) -> list[tuple[int, int]]:
    """The solid that a polygon (r, z) leaves when it turns round z."""
    points = [occ.addPoint(r, 0, z) for r, z in profile]
    lines = [occ.addLine(points[k - 1], points[k]) for k in range(len(points))]
    face = occ.addPlaneSurface([occ.addCurveLoop(lines)])
    made = occ.revolve([(2, face)], 0, 0, 0, 0, 0, 1, 2 * pi)
    occ.remove([(2, face)], recursive=True)
    return [entity for entity in made if entity[0] == 3]


def pdms_block() -> None:
    groove = [(3, occ.addBox(1, 1.7, 0, 4, 0.6, 0.4))]
    wells = [(3, occ.addCylinder(x, 2, 0, 0, 0, 2, 0.5)) for x in (1, 5)]
    occ.cut([(3, occ.addBox(0, 0, 0, 6, 4, 2))], groove + wells)
    occ.addBox(-0.5, -0.5, -0.5, 7, 5, 0.5)


def luer() -> None:
    hub = turned([(0, 2), (2.8, 2), (2.8, 10), (3.8, 10), (3.8, 11), (0, 11)])
    stub = [(3, occ.addCylinder(0, 0, 0, 0, 0, 2, 0.9))]
    body, _ = occ.fuse(hub, stub)
    cone = turned([(0, 5), (1.64, 5), (2, 11), (0, 11)])
    occ.cut(body, [*cone, (3, occ.addCylinder(0, 0, 0, 0, 0, 5, 0.5))])


def manifold() -> None:
    bore = [(3, occ.addBox(0, 1.1, 0.6, 8, 0.8, 0.8))]
    ups = [(3, occ.addCylinder(x, 1.5, 1.4, 0, 0, 0.6, 0.3)) for x in (2, 6)]
    occ.cut([(3, occ.addBox(0, 0, 0, 8, 3, 2))], bore + ups)
    for x, height in ((2, 1), (6, 2)):
        block = [(3, occ.addBox(x - 1, 0.5, 2, 2, 2, height))]
        occ.cut(block, [(3, occ.addCylinder(x, 1.5, 2, 0, 0, height, 0.3))])


def mixer() -> None:
    """Both walls of the bend are arcs, whose bulge is the tangent of a quarter of their angle."""
    quarter, half = tan(pi / 8), tan(pi / 4)
    right = [(350, -50, 0), (600, -50, quarter), (800, 150, 0), (800, 300, -half), (900, 300, 0),
             (900, 150, quarter), (1100, -50, 0), (1350, -50, 0)]  # fmt: skip
    left = [(1350, 50, 0), (1100, 50, -quarter), (1000, 150, 0), (1000, 300, half), (700, 300, 0),
            (700, 150, -quarter), (600, 50, 0), (350, 50, 0)]  # fmt: skip
    outline = [(350, 500, 0), (250, 500, 0), (250, -500, 0), (350, -500, 0), *right, *left]
    document = ezdxf.new(units=13)  # micrometres
    space = document.modelspace()
    space.add_lwpolyline(outline, format="xyb", close=True, dxfattribs={"layer": "channels"})
    frame = [(0, -500), (1350, -500), (1350, 500), (0, 500)]
    space.add_lwpolyline(frame, close=True, dxfattribs={"layer": "frame"})
    document.saveas(FOLDER / "mixer.dxf")


if __name__ == "__main__":
    gmsh.initialize(interruptible=False, readConfigFiles=False)
    gmsh.option.setNumber("General.Terminal", 0)
    for draw in (pdms_block, luer, manifold):
        gmsh.clear()
        draw()
        occ.synchronize()
        gmsh.write(str(FOLDER / f"{draw.__name__}.step"))
    gmsh.finalize()
    mixer()
