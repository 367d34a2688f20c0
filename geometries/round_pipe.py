"""Straight round pipe of radius 1 about the x axis, from `inlet` at x = 0 to `outlet` at x = 6.

Each port is a central square (corners at radius 1/2) and four plane pieces out to a 90-degree arc;
`walls` are four 90-degree strips of the cylinder: 14 four-sided faces.
Volume 6 pi, area 14 pi.
"""

from authoring import extruded, joined, written

PORTS = {"inlet": lambda p: p[0], "outlet": lambda p: p[0] - 6}

if __name__ == "__main__":
    with written(__file__, PORTS) as drawing:
        cells, _ = extruded(drawing.disk(x=0, radius=1), (6, 0, 0))
        joined(cells)
