"""Y-junction, 4 high (0 <= z <= 4), branches 4 wide; plan view symmetric about y = Yc = 5 sqrt(2).

Branch A runs from its port `inlet_a`, on the line x + y = 2 sqrt(2) between (0, 2 sqrt(2)) and
(2 sqrt(2), 0), along (1, 1)/sqrt(2) with centreline y = x. Its inner wall ends at the crotch
C = (3 sqrt(2), Yc), its outer wall at P = (7 sqrt(2) - 2, Yc - 2), where it meets the outlet's
lower wall. Branch B with `inlet_b` is its mirror image. The outlet branch runs along x,
|y - Yc| <= 2, and ends at `outlet`, x = 7 sqrt(2) + 6. Everything else is `walls`.

18 plane four-sided faces: floor 4, ceiling 4, walls 6, inlets 2, outlet 2 (it is halved, as the
floor is, by the axis). Volume 368, area 424 - 16 sqrt(2).

A drop of radius 1 that starts at (2.8284, 2, 2) is inside branch A and 0.586 off its centreline.
"""

from math import sqrt

from authoring import extruded, joined, written

ROOT = sqrt(2)
AXIS = 5 * ROOT
PORTS = {
    "inlet_a": lambda p: p[0] + (p[1] - AXIS) + 3 * ROOT,
    "inlet_b": lambda p: p[0] - (p[1] - AXIS) + 3 * ROOT,
    "outlet": lambda p: p[0] - (7 * ROOT + 6),
}

if __name__ == "__main__":
    with written(__file__, PORTS) as drawing:
        crotch = (3 * ROOT, AXIS, 0.0)
        end = (7 * ROOT + 6, AXIS, 0.0)
        floor = []
        for side in (-1, 1):
            inner = (0.0, AXIS + side * 3 * ROOT, 0.0)
            outer = (2 * ROOT, AXIS + side * 5 * ROOT, 0.0)
            bend = (7 * ROOT - 2, AXIS + side * 2, 0.0)
            corner = (7 * ROOT + 6, AXIS + side * 2, 0.0)
            floor.append(drawing.face(inner, outer, bend, crotch))
            floor.append(drawing.face(crotch, bend, corner, end))
        cells, _ = extruded(floor, (0, 0, 4))
        joined(cells)
