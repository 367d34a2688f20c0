"""Checks of the thesis's tables 2.1 to 2.3: singular and nearly singular integrals.

Three ways each: our rule; the thesis's, which cuts an element evenly (Eq. 2.41), or takes polar
coordinates on the element itself; and, for tables 2.1 and 2.2, ten by ten Gauss points.  The latter
two are checked against what the thesis prints for them, since they are not meant to be exact.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial

import numpy as np

from cadbem.points import surface_points
from cadbem.quadrature.gauss import gauss_on_breaks
from cadbem.quadrature.options import UniformSubdivision
from cadbem.spline.basis import Array
from cadbem.spline.nurbs import Nurbs
from cadbem.spline.shapes import cylinder, parallelogram, sphere_octants
from cadbem.verification.check import Check
from cadbem.verification.rules import even_rule, near_rule, triangle_rule

EXACT = "iterated integration to 15 digits and more"
PRINTED = "the thesis's column, the same sum of Gauss points"
TOLERANCE = 1e-10  # of our rule
LAST_DIGIT = 6e-9  # of what is printed, with a margin for its rounding
# δ: exact, and the printed columns 'standard' and 'adaptive subdivision'
TABLE_1 = {
    3.0: (0.13245703771419043607, 0.13245704, 0.13245704),
    2.8: (0.14915422915722996258, 0.14915423, 0.14915423),
    2.6: (0.17094271558964884783, 0.17094271, 0.17094271),
    2.4: (0.20073773569332359807, 0.20073733, 0.20073733),
    2.2: (0.24474869678651907097, 0.24470265, 0.24470265),
    2.1: (0.27705794270407650506, 0.27639831, 0.27705677),
    2.01: (0.32201384418586856441, 0.31295413, 0.32201384),
    2.001: (0.32979371558808110659, 0.31687109, 0.32979370),
}
CONTRADICTION = 2.2, 0.2447486954  # its rule asks for 2 × 2 parts there, and prints 1 × 1
# 32 θ / π: the same
TABLE_2 = {
    24: (0.116477946127085887, 0.11647824, 0.11647824),
    23: (0.129472061366239636, 0.12947313, 0.12947313),
    22: (0.145475167222624546, 0.14547727, 0.14547727),
    21: (0.165678950873775215, 0.16567295, 0.16567295),
    20: (0.192075042674975613, 0.19197182, 0.19207505),
    19: (0.22839107463227493, 0.22753990, 0.22839105),
    18: (0.28300339678881859, 0.27688449, 0.28299932),
    17: (0.382747519931231262, 0.33875882, 0.38272197),
}
# ξ: exact, and the printed column 'coordinate transformation'
TABLE_3 = {
    0.75: (-2.05770138662817, -2.057678),
    0.875: (-3.12942243007891, -3.129290),
    0.995: (-4.20335353980598, -4.203397),
}


def checks() -> tuple[Check, ...]:
    """Of the three tables."""
    return (*_table_1(), *_table_2(), *_table_3())


def quarter_cylinder() -> Nurbs:
    """Radius 1 about the y axis, x and z positive, y from 0 to 2, which is the second parameter."""
    along_x = cylinder(1.0, 2.0)[0]
    return along_x.transformed(np.array([[0.0, 1, 0], [1, 0, 0], [0, 0, 1]])).swapped()


def rectangle() -> Nurbs:
    """-1 < x < 1, 0 < y < 4 in the plane z = 0, the parameters along x and y."""
    return parallelogram((-1, 0, 0), (2, 0, 0), (0, 4, 0))


def _table_1() -> Iterator[Check]:
    for delta, (exact, standard, adaptive) in TABLE_1.items():
        source = np.array([np.sqrt(0.5), delta, np.sqrt(0.5)])
        parts = _parts(2.0, delta - 2.0, singularity=1)
        true = CONTRADICTION[1] if delta == CONTRADICTION[0] else adaptive
        row = _Row("Table 2.1", f"∫ dS / 4πr over a quarter cylinder, δ = {delta:g}")
        yield row.ours(partial(_cylinder_ours, source), exact, adaptive)
        yield row.evenly(partial(_cylinder_evenly, source), 1, standard, standard)
        if parts > 1:
            yield row.evenly(partial(_cylinder_evenly, source), parts, true, adaptive)


def _table_2() -> Iterator[Check]:
    for share, (exact, standard, adaptive) in TABLE_2.items():
        theta = share * np.pi / 32
        source = np.array([np.cos(theta), np.sin(theta), 1.0]) * np.sqrt(0.5)
        parts = _parts(np.pi / 2, 2 * np.sin(np.arcsin(-source[0]) / 2), singularity=2)
        row = _Row("Table 2.2", f"∫ r,x / 4πr² dS over an octant, θ = {share}π/32")
        yield row.ours(partial(_octant_ours, source), exact, adaptive)
        yield row.evenly(partial(_octant_evenly, source), 1, standard, standard)
        if parts > 1:
            yield row.evenly(partial(_octant_evenly, source), parts, adaptive, adaptive)


def _table_3() -> Iterator[Check]:
    for xi, (exact, printed) in TABLE_3.items():
        row = _Row("Table 2.3", f"∫ r,x / r dS over a rectangle, ξ = {xi:g}")
        yield row.ours(partial(_plane_ours, xi), exact, printed)
        yield Check(
            row.place, f"{row.what}, polar, 10 points a direction", partial(_plane_polar, xi),
            printed, 6e-7 / abs(printed), PRINTED, printed,
        )  # fmt: skip


@dataclass(frozen=True)
class _Row:
    """One integral, done in several ways."""

    place: str
    what: str

    def ours(self, compute: Callable[[], float], exact: float, printed: float) -> Check:
        title = f"{self.what}, ours"
        return Check(self.place, title, compute, exact, TOLERANCE, EXACT, printed)

    def evenly(
        self, compute: Callable[[int], float], parts: int, expected: float, printed: float
    ) -> Check:
        """Ten by ten points on each of parts × parts."""
        title, allowed = f"{self.what}, {parts} × {parts} parts", LAST_DIGIT / expected
        value = partial(compute, parts)
        return Check(self.place, title, value, expected, allowed, PRINTED, printed)


def _parts(length: float, distance: float, singularity: int) -> int:
    """Parts a direction by Eq. 2.41, for ten points and a relative error of 1e-4."""
    rule = UniformSubdivision(limit=1000, singularity=singularity)
    return int(rule.pieces(np.array([length]), np.array([distance]))[0])


def _cylinder_ours(source: Array) -> float:
    position, weight = near_rule(quarter_cylinder(), source, TOLERANCE)
    return float(weight @ (1 / _distance(position, source))) / (4 * np.pi)


def _cylinder_evenly(source: Array, parts: int) -> float:
    """Arc times line: there are too many points to lay them out in full."""
    t, w = gauss_on_breaks(10, np.linspace(0, 1, parts + 1))
    arc = surface_points(quarter_cylinder(), t, np.zeros_like(t))
    across = (arc.position[0] - source[0]) ** 2 + (arc.position[2] - source[2]) ** 2
    r = np.sqrt(across[:, None] + (2 * t - source[1]) ** 2)
    return float((w * arc.jacobian) @ (1 / r) @ w) / (4 * np.pi)


def _octant_ours(source: Array) -> float:
    return _pull(*near_rule(sphere_octants()[0], source, TOLERANCE), source, 3) / (4 * np.pi)


def _octant_evenly(source: Array, parts: int) -> float:
    return _pull(*even_rule(sphere_octants()[0], parts), source, 3) / (4 * np.pi)


def _plane_ours(xi: float) -> float:
    source = np.array([2 * xi - 1, 1.0, 0.0])
    return _pull(*near_rule(rectangle(), source, TOLERANCE, own=(xi, 0.25)), source, 2)


def _plane_polar(xi: float) -> float:
    source = np.array([2 * xi - 1, 1.0, 0.0])
    return _pull(*triangle_rule(rectangle(), (xi, 0.25), 10), source, 2)


def _pull(position: Array, weight: Array, source: Array, power: int) -> float:
    """∫ (x - x₀) / rⁿ dS, the first component, with the power n."""
    return float(weight @ ((position[0] - source[0]) / _distance(position, source) ** power))


def _distance(position: Array, source: Array) -> Array:
    return np.linalg.norm(position - source[:, None], axis=0)
