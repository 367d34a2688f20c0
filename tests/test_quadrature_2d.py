"""Singular and nearly singular rules on plane curves against closed forms."""

from math import atan2, cos, log, pi, sin

import numpy as np
import pytest

from cadbem.operators.panels import split_patch
from cadbem.quadrature import near
from cadbem.quadrature.gauss import log_unit
from cadbem.quadrature.panels import closest_on_panels, open_squares
from cadbem.spline.outlines import circle, line

TOLERANCES = (1e-6, 1e-10)
HEIGHTS = (0.3, 0.1, 1e-2, 1e-3, 1e-4, 1e-5)


def near_rule(panels, target, tolerance, own=None):
    """r = x - target and normals (2, n), and weights with Jacobian, on all of a curve's panels.

    ``own`` (panel, t) says that the target lies on the curve there."""
    nets = panels.flat_nets
    index = np.arange(len(nets))
    closest = np.empty((3, len(nets)))
    x = np.reshape(target, (2, 1)).astype(float)
    u, v, samples = panels.samples
    closest_on_panels(x, 0 * index, index, nets, open_squares(nets), u, v, samples, closest)
    if own is not None:
        closest[:, own[0]] = own[1], 0.0, 0.0
    p, capacity = nets.shape[1] - 1, 10_000
    position, normal, weight = np.empty((2, capacity)), np.empty((2, capacity)), np.empty(capacity)
    bu, bv = np.empty((p + 1, capacity)), np.empty((1, capacity))
    starts, foot = np.empty(len(nets) + 1, dtype=np.int64), np.empty((2, len(nets)))
    done = near.place_nodes(
        nets, None, None, index, 0, *closest, tolerance, None, 0, near.gauss_table(),
        starts, foot, np.empty((p + 1, 2)), position, normal, weight, bu, bv,
    )  # fmt: skip
    assert done == len(nets)
    count, owner = starts[-1], np.repeat(index, np.diff(starts))
    function = np.einsum("ki,ik->k", nets[owner, :, 0, 2], bu[:, :count])
    shift = np.where(closest[2] > 0, foot - x, 0.0)
    return position[:, :count] + shift[:, owner], normal[:, :count], weight[:count] * function


@pytest.mark.parametrize("order", [2, 8, 16, 24])
def test_log_rule(order):
    """∫₀¹ x^k ln x dx = -1 / (k + 1)², ∫₀¹ x^k dx = 1 / (k + 1); positive weights."""
    nodes, weights = log_unit(order)
    assert weights.min() > 0
    for k in range(order // 2):
        assert nodes**k @ weights == pytest.approx(1 / (k + 1), rel=1e-13)
        assert (nodes**k * np.log(nodes)) @ weights == pytest.approx(-1 / (k + 1) ** 2, rel=1e-12)


@pytest.mark.parametrize("degree", [1, 3, 6])
@pytest.mark.parametrize("tolerance", TOLERANCES)
def test_segment(tolerance, degree):
    """∫ ln r, ∫ h/r² and ∫ x/r² over a segment of length 1, above and beyond it at 0.3 to 1e-5;
    at most 90 nodes."""
    segment = split_patch(line((0, 0), (1, 0)).elevated((degree,)))
    for x in (0.37, 0.01, 1e-3, 0.0, 1.02, -0.1, 1.00001):
        for h in HEIGHTS:
            (along, _), _, weight = near_rule(segment, (x, h), tolerance)
            square = along**2 + h * h
            ends = (-x, 1 - x)
            logs = [0.5 * a * log(a * a + h * h) - a + h * atan2(a, h) for a in ends]
            angles = [atan2(a, h) for a in ends]
            slopes = [0.5 * log(a * a + h * h) for a in ends]
            for ours, (low, high) in (
                (weight @ np.log(square) / 2, logs),
                (weight @ (h / square), angles),
                (weight @ (along / square), slopes),
            ):
                assert abs(ours - (high - low)) < tolerance
            assert len(weight) <= 90


@pytest.mark.parametrize("tolerance", TOLERANCES)
def test_on_a_segment(tolerance):
    """∫ ln |x - a| dx and ∫ (x - a) ln |x - a| dx at a point of the segment."""
    segment = split_patch(line((0, 0), (1, 0)))
    for a in (0.5, 0.13, 1e-3, 1e-6, 0.0):
        (along, _), _, weight = near_rule(segment, (a, 0), tolerance, own=(0, a))
        ends = [e for e in (-a, 1 - a) if e]
        value = sum(abs(e) * (log(abs(e)) - 1) for e in ends)
        moment = sum(np.sign(e) * e * e * (0.5 * log(abs(e)) - 0.25) for e in ends)
        assert weight @ np.log(abs(along)) == pytest.approx(value, abs=tolerance)
        assert (weight * along) @ np.log(abs(along)) == pytest.approx(moment, abs=tolerance)


@pytest.mark.parametrize("degree", [2, 4, 7])
@pytest.mark.parametrize("tolerance", TOLERANCES)
def test_circle(tolerance, degree):
    """On the unit circle, x₀ = ρ (cos φ, sin φ), m = min(ρ, 1/ρ): ∮ ln r ds = 2π ln max(1, ρ),
    ∮ ln r cos θ ds = -π m cos φ, ∮ r·n / r² ds = 2π inside, π on, 0 outside."""
    arcs = [split_patch(arc.elevated((degree,))) for arc in circle()]
    for phi in (1e-4, 0.3, 1.2):
        for height in (*HEIGHTS, 0.0, *[-h for h in HEIGHTS]):
            rho = 1 - height
            source = np.array([rho * cos(phi), rho * sin(phi)])
            sums = np.zeros(3)
            for k, arc in enumerate(arcs):
                own = _own_place(phi) if height == 0.0 and k == 0 else None
                r, normal, weight = near_rule(arc, source, tolerance, own)
                square = (r**2).sum(axis=0)
                double = (r * normal).sum(axis=0) / square
                logs = 0.5 * np.log(square)
                sums += weight @ logs, (weight * (r[0] + source[0])) @ logs, weight @ double
            inside = pi if height == 0.0 else 2 * pi * (height > 0)
            exact = 2 * pi * log(max(1, rho)), -pi * min(rho, 1 / rho) * cos(phi), inside
            assert abs(sums - exact).max() < 4 * tolerance


def _own_place(phi):
    """Panel and parameter of the point at an angle on the first quarter, halved at 45°.

    With weights 1, √½, 1 the arc is symmetric, and tan(φ/2) = t (√2 - 1 + ...) is solved by
    bisection of the rational formula."""
    low, high = 0.0, 1.0
    for _ in range(60):
        t = 0.5 * (low + high)
        x, y = (1 - t) ** 2 + 2**0.5 * t * (1 - t), 2**0.5 * t * (1 - t) + t * t
        low, high = (t, high) if atan2(y, x) < phi else (low, t)
    return (0, 2 * low) if low < 0.5 else (1, 2 * low - 1)
