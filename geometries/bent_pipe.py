"""Round pipe of radius 1 with a 90-degree bend of radius 3 between straight pieces of length 2.

The centreline starts at the origin (`inlet`, x = 0), runs along x to (2, 0, 0), turns about
(2, 3, z) to (5, 3, 0), and runs along y to (5, 5, 0) (`outlet`, y = 5).

Each port is a central square and four plane pieces out to a 90-degree arc; `walls` are four
strips each of cylinder, torus, cylinder: 22 four-sided faces.
Volume 4 pi + 1.5 pi^2, area 10 pi + 3 pi^2.
"""

from math import pi

from authoring import extruded, joined, revolved, written

PORTS = {"inlet": lambda p: p[0], "outlet": lambda p: p[1] - 5}

if __name__ == "__main__":
    with written(__file__, PORTS) as drawing:
        first, bend_start = extruded(drawing.disk(x=0, radius=1), (2, 0, 0))
        bend, bend_end = revolved(bend_start, (2, 3, 0), (0, 0, 1), pi / 2)
        last, _ = extruded(bend_end, (0, 2, 0))
        joined([*first, *bend, *last])
