"""Two parallel plates at z = +-W, W = 1 being half their distance, 24 W long and 24 W wide.

The box |x| <= 12, |y| <= 12, |z| <= 1: plates `top` (z = 1) and `bottom` (z = -1), closed by four
`sides`: 6 faces. Volume 1152, area 1344.
"""

from authoring import extruded, joined, written

NAMES = {
    "top": lambda p: p[2] - 1,
    "bottom": lambda p: p[2] + 1,
    "sides": lambda p: max(abs(p[0]), abs(p[1])) - 12,
}

if __name__ == "__main__":
    with written(__file__, NAMES) as drawing:
        plate = drawing.face((-12, -12, -1), (12, -12, -1), (12, 12, -1), (-12, 12, -1))
        cells, _ = extruded([plate], (0, 0, 2))
        joined(cells)
