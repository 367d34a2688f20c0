"""T-junction of channels with square cross-section, 1 wide and 1 high (|z| <= 1/2).

The main channel |y| <= 1/2 runs along x from `inlet_a` at x = -3 to `outlet` at x = 3; the side
branch |x| <= 1/2 enters from `inlet_b` at y = -3. Everything else is `walls`.

18 plane four-sided faces: floor 4, ceiling 4, ports 3, walls 7. Volume 8.5, area 36.
"""

from authoring import extruded, joined, written

PORTS = {
    "inlet_a": lambda p: p[0] + 3,
    "inlet_b": lambda p: p[1] + 3,
    "outlet": lambda p: p[0] - 3,
}

if __name__ == "__main__":
    with written(__file__, PORTS) as drawing:
        floor = [
            drawing.face((x, y, -0.5), (x + dx, y, -0.5), (x + dx, y + dy, -0.5), (x, y + dy, -0.5))
            for x, y, dx, dy in ((-3, -0.5, 2.5, 1), (-0.5, -0.5, 1, 1), (0.5, -0.5, 2.5, 1),
                                 (-0.5, -3, 1, 2.5))
        ]  # fmt: skip
        cells, _ = extruded(floor, (0, 0, 1))
        joined(cells)
