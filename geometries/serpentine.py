"""Serpentine channel of square cross-section, 1 wide and 1 high (|z| <= 1/2): three U-turns.

Four straight legs of length 4 lie along x between x = 0 and x = 4, with centrelines at
y = 0, 2, 4, 6. Half circles of centreline radius 1 (inner radius 1/2, outer 3/2) join them, at
x = 4, at x = 0, at x = 4. `inlet` is the end of the first leg at x = 0, `outlet` the end of the
last at x = 0. Everything else is `walls`.

Each half circle is two sectors of 90 degrees, bounded by two arcs and two straight edges.
42 four-sided faces: floor 10, ceiling 10, ports 2, walls 20. Volume 16 + 3 pi, area 66 + 12 pi.
"""

from authoring import Drawing, extruded, joined, written

PORTS = {
    "inlet": lambda p: abs(p[0]) + max(0.0, p[1] - 1),
    "outlet": lambda p: abs(p[0]) + max(0.0, 5 - p[1]),
}
LOW = -0.5


def leg(drawing: Drawing, y: float) -> int:
    """Plan of the straight leg with centreline at `y`."""
    return drawing.face((0, y - 0.5, LOW), (4, y - 0.5, LOW), (4, y + 0.5, LOW), (0, y + 0.5, LOW))


def turn(drawing: Drawing, x: float, y: float, side: int) -> list[int]:
    """Plan of the half circle about (x, y), towards +x (`side` 1) or -x (-1): two sectors."""
    sectors = []
    for up in (-1, 1):
        for radius in (0.5, 1.5):
            drawing.arc((x, y + up * radius, LOW), (x, y, LOW), (x + side * radius, y, LOW))
        sectors.append(
            drawing.face((x, y + up * 0.5, LOW), (x, y + up * 1.5, LOW),
                         (x + side * 1.5, y, LOW), (x + side * 0.5, y, LOW))
        )  # fmt: skip
    return sectors


if __name__ == "__main__":
    with written(__file__, PORTS) as drawing:
        floor = [leg(drawing, y) for y in (0, 2, 4, 6)]
        for x, y, side in ((4, 1, 1), (0, 3, -1), (4, 5, 1)):
            floor += turn(drawing, x, y, side)
        cells, _ = extruded(floor, (0, 0, 1))
        joined(cells)
