"""Flow focusing: a cross of channels, then an orifice; 1 high (|z| <= 1/2), symmetric about y = 0.

The main channel, 1 wide, comes from `inlet` at x = -3; the side channels |x| <= 1/2 come from
`side_a` at y = -3 and `side_b` at y = 3. After the crossing |x|, |y| <= 1/2 the channel narrows
from width 1 at x = 1/2 to a throat of width 1/2 between x = 1 and x = 3/2, widens to width 3/2 at
x = 5/2, and ends at `outlet`, x = 5. Everything else is `walls`.

34 plane four-sided faces: floor 8, ceiling 8, ports 4, walls 14. Volume 13.875,
area 53.25 + 1.5 sqrt(5).
"""

from authoring import extruded, joined, written

PORTS = {
    "inlet": lambda p: p[0] + 3,
    "side_a": lambda p: p[1] + 3,
    "side_b": lambda p: p[1] - 3,
    "outlet": lambda p: p[0] - 5,
}
STATIONS = [(-3, 0.5), (-0.5, 0.5), (0.5, 0.5), (1, 0.25), (1.5, 0.25), (2.5, 0.75), (5, 0.75)]

if __name__ == "__main__":
    with written(__file__, PORTS) as drawing:
        floor = [
            drawing.face((x, -h, -0.5), (end, -end_h, -0.5), (end, end_h, -0.5), (x, h, -0.5))
            for (x, h), (end, end_h) in zip(STATIONS, STATIONS[1:], strict=False)
        ]
        for side in (-1, 1):
            near, far = 0.5 * side, 3 * side
            floor.append(
                drawing.face((-0.5, near, -0.5), (0.5, near, -0.5), (0.5, far, -0.5),
                             (-0.5, far, -0.5))
            )  # fmt: skip
        cells, _ = extruded(floor, (0, 0, 1))
        joined(cells)
