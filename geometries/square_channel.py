"""Straight channel of square cross-section: the box |x| <= 1, |y| <= 1/2, |z| <= 1/2.

Width and height 1, length 2. `inlet` at x = -1, `outlet` at x = +1, four `walls`: 6 faces.
Volume 2, area 10.
"""

from authoring import extruded, joined, written

PORTS = {"inlet": lambda p: p[0] + 1, "outlet": lambda p: p[0] - 1}

if __name__ == "__main__":
    with written(__file__, PORTS) as drawing:
        floor = drawing.face((-1, -0.5, -0.5), (1, -0.5, -0.5), (1, 0.5, -0.5), (-1, 0.5, -0.5))
        cells, _ = extruded([floor], (0, 0, 1))
        joined(cells)
