"""Smooth constriction: a channel 1 high (|z| <= 1/2), |x| <= 4, from width 2 to 0.8 and back.

The side walls are y = +-h(x), h a cubic B-spline with knots at the integers: the control points
stand at the Greville abscissae, so that x is the spline's parameter; the control values are those
of HALF_WIDTHS. h(+-4) = 1 with level ends, and h(0) = 0.4.

`inlet` at x = -4, `outlet` at x = 4, `walls`: 6 four-sided faces.
Volume 11.2: twice the sum of control value times (knot i+4 - knot i)/4. Area 2 x 11.2 + 4 + twice
the length of the curve.
"""

from authoring import extruded, joined, written

PORTS = {"inlet": lambda p: p[0] + 4, "outlet": lambda p: p[0] - 4}
KNOTS = [-4, -3, -2, -1, 0, 1, 2, 3, 4]
GREVILLE = [-4, -11 / 3, -3, -2, -1, 0, 1, 2, 3, 11 / 3, 4]
HALF_WIDTHS = [1, 1, 1, 0.7, 0.4, 0.4, 0.4, 0.7, 1, 1, 1]

if __name__ == "__main__":
    with written(__file__, PORTS) as drawing:
        for side in (-1, 1):
            curve = [(x, side * h, -0.5) for x, h in zip(GREVILLE, HALF_WIDTHS, strict=True)]
            drawing.spline(curve, KNOTS)
        floor = drawing.face((-4, -1, -0.5), (4, -1, -0.5), (4, 1, -0.5), (-4, 1, -0.5))
        cells, _ = extruded([floor], (0, 0, 1))
        joined(cells)
