"""Fully developed velocity profiles of ports: exact for rectangles, circles and plane gaps."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.spatial import ConvexHull

from cadbem.boundary import Patch
from cadbem.errors import ConditionError
from cadbem.problems.developed import developed_profile
from cadbem.spline.basis import Array

PLANAR = 1e-9  # how far a port may leave its plane, relative to its size
TERMS = 2000  # odd terms of the duct series: its tail falls like n⁻³ at the corners


def rectangle_profile(y: Array, z: Array, width: float, height: float) -> Array:
    """Velocity over mean velocity in a duct, y in ±width/2 and z in ±height/2.

    u = G/μ [(a² - y²)/2 - (16 a²/π³) Σ (-1)^((n-1)/2) cos(nπy/2a) cosh(nπz/2a)
    / (n³ cosh(nπb/2a))] over odd n, with a = width/2, b = height/2, divided by its mean
    (White, *Viscous Fluid Flow*, eq. 3-48).  Of the two ways to expand, each point takes the
    one whose series decays there.
    """
    result = np.empty_like(y)
    flip = (width - 2 * abs(y)) / height > (height - 2 * abs(z)) / width
    result[~flip] = _duct_series(y[~flip], z[~flip], width / 2, height / 2)
    result[flip] = _duct_series(z[flip], y[flip], height / 2, width / 2)
    return result / _duct_mean(width / 2, height / 2)


def _duct_series(y: Array, z: Array, a: float, b: float) -> Array:
    total = np.zeros_like(y)
    slow = np.arange(y.size)  # points where the series has not decayed yet
    for k in range(TERMS):
        n = 2 * k + 1
        rate = n * np.pi / (2 * a)
        slow = slow[rate * (b - abs(z[slow])) < 40]
        if not slow.size:
            break
        depth = abs(z[slow])
        ratio = np.exp(rate * (depth - b)) * (1 + np.exp(-2 * rate * depth))
        ratio /= 1 + np.exp(-2 * rate * b)
        total[slow] += (-1) ** k * np.cos(rate * y[slow]) * ratio / n**3
    return (a * a - y * y) / 2 - 16 * a * a / np.pi**3 * total


def _duct_mean(a: float, b: float) -> float:
    n = np.arange(1, 2 * TERMS, 2)
    series = (np.tanh(n * np.pi * b / (2 * a)) / n**5.0).sum()
    return a * a / 3 * (1 - 192 * a / (np.pi**5 * b) * series)


def circle_profile(radius: Array, outer: float) -> Array:
    """Hagen-Poiseuille velocity over mean velocity: 2 (1 - r²/R²)."""
    return 2 * (1 - (radius / outer) ** 2)


def plates_profile(distance: Array, gap: float) -> Array:
    """Velocity over mean velocity between plates, at a distance from the middle."""
    return 1.5 * (1 - (2 * distance / gap) ** 2)


@dataclass(frozen=True, eq=False)
class Port:
    """A flat opening: ``centre`` and unit ``normal`` (dim,) into the fluid, and ``area``.

    ``outline`` (dim, N) are points on its edge; in a plane the area is a length.
    """

    patches: tuple[Patch, ...]

    name: str
    centre: Array
    normal: Array
    area: float
    outline: Array

    @cached_property
    def profile(self) -> Callable[[Array], Array]:
        """Velocity over mean velocity, a function of points (dim, N) of the port.

        A shape that is neither a rectangle nor a circle has its profile computed on its rim.
        Raises ``ConditionError`` when a port in a plane is not one segment.
        """
        radius = float(np.linalg.norm(self.outline - self.centre[:, None], axis=0).max())
        if len(self.centre) == 2:
            return self._between_plates(radius)
        if abs(np.pi * radius**2 / self.area - 1) < 1e-6:
            disc = np.sqrt(self.area / np.pi)
            return lambda x: circle_profile(
                np.linalg.norm(x - self.centre[:, None], axis=0), disc
            )
        rectangle = self._rectangle()
        if rectangle is None:
            return developed_profile(self.patches, self.centre, self.normal)
        axes, middle, sides = rectangle
        return lambda x: rectangle_profile(*(axes @ x - middle[:, None]), *sides)

    def _between_plates(self, radius: float) -> Callable[[Array], Array]:
        if abs(2 * radius / self.area - 1) > 1e-6:
            raise ConditionError(
                f"'{self.name}' is not one straight segment, so its developed profile is not "
                "known; name one opening only, or give Velocity(function) on it"
            )
        return lambda x: plates_profile(
            np.linalg.norm(x - self.centre[:, None], axis=0), self.area
        )

    def _rectangle(self) -> tuple[Array, Array, Array] | None:
        """Axes (2, 3), middle along them and side lengths, if the port fills its smallest box."""
        frame = np.linalg.svd(self.normal[None])[2][1:]
        flat = frame @ self.outline
        hull = flat[:, ConvexHull(flat.T, qhull_options="QJ").vertices]
        edges = np.roll(hull, -1, axis=1) - hull
        longest = edges[:, np.argmax(np.linalg.norm(edges, axis=0))]
        first = longest / np.linalg.norm(longest)
        axes = np.stack([first, [-first[1], first[0]]]) @ frame
        low, high = (axes @ self.outline).min(axis=1), (axes @ self.outline).max(axis=1)
        sides = high - low
        if abs(sides[0] * sides[1] / self.area - 1) > 1e-6:
            return None
        return axes, 0.5 * (low + high), sides


def port(name: str, patches: list[Patch]) -> Port:
    """The opening that some patches make together.

    Raises ``ConditionError`` when they do not lie in one plane (on one straight line).
    """
    parts = [p.quadrature(max(p.surface.degrees) + 8) for p in patches]
    position = np.concatenate([p.position for p, _ in parts], axis=1)
    normals = np.concatenate([p.normal for p, _ in parts], axis=1)
    weights = np.concatenate([w for _, w in parts])
    area = float(weights.sum())
    centre = position @ weights / area
    normal = normals @ weights / area
    outline = np.concatenate([_outline(p) for p in patches], axis=1)
    off = np.abs(normal @ (outline - centre[:, None])).max()
    if off > PLANAR * area ** (1 / (len(centre) - 1)) or np.linalg.norm(normal) < 1 - 1e-9:
        raise ConditionError(
            f"'{name}' is not flat, which an inflow or a pressure asks for; "
            "name one flat opening only, or prescribe Velocity or Traction"
        )
    return Port(tuple(patches), name, centre, normal / np.linalg.norm(normal), area, outline)


def _outline(patch: Patch, samples: int = 33) -> Array:
    """Points (dim, N) on the edges of a patch."""
    if patch.surface.dimension == 2:
        return patch.surface.evaluate(patch.surface.domain[0])
    (u0, u1), (v0, v1) = patch.surface.domain
    u, v = np.linspace(u0, u1, samples), np.linspace(v0, v1, samples)
    x = patch.surface.evaluate
    return np.concatenate([x(u, v0), x(u, v1), x(u0, v), x(u1, v)], axis=1)
