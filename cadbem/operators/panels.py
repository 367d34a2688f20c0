"""The integration panels of a patch: Bézier pieces with tables of nodes and functions."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
from numpy.typing import NDArray

from cadbem.compiled import compiled
from cadbem.operators.turning import panel_breaks, ruled
from cadbem.points import area_vector
from cadbem.quadrature.gauss import gauss_unit
from cadbem.quadrature.panels import closest_on_panels, open_squares
from cadbem.quadrature.polar import collapsed_sides
from cadbem.spline.basis import Array, bernstein, refinement_matrix
from cadbem.spline.nurbs import Nurbs

Index = NDArray[np.int64]
SAME_PARAMETER = 1e-10  # share of a panel below which parameters count as equal


@dataclass(frozen=True, eq=False)
class Panels:
    """A grid of panels over a patch, at least one an element.

    A curve is a patch of degree 0 with one panel across, over [0, 1].
    ``breaks`` in each parameter; ``nets`` (P_u, P_v, p + 1, q + 1, dim + 1), homogeneous Bézier
    points; ``extraction`` one (P, p + 1, p + 1) array a parameter, the Bernstein coefficients
    (second axis) of the functions that live on a panel (third axis), the first of which has the
    number in ``first`` (P,).
    """

    surface: Nurbs
    breaks: tuple[Array, ...]
    nets: Array
    extraction: tuple[Array, ...]
    first: tuple[Index, ...]

    @property
    def shape(self) -> tuple[int, int]:
        """Panels in each direction."""
        return self.nets.shape[0], self.nets.shape[1]

    @cached_property
    def flat_nets(self) -> Array:
        """Nets with one panel index, the second parameter fastest."""
        return np.ascontiguousarray(self.nets.reshape(-1, *self.nets.shape[2:]))

    @cached_property
    def functions(self) -> tuple[Index, Index]:
        """Places in the net of the functions on each panel: (P_u, 1, i, 1) and (1, P_v, 1, j)."""
        u, v = (
            first[:, None] + np.arange(degree + 1)
            for first, degree in zip(self.first, self.surface.degrees, strict=True)
        )
        return u[:, None, :, None], v[None, :, None, :]

    @cached_property
    def controls(self) -> Array:
        """Their weights: (P_u, P_v, i, j)."""
        return self.surface.weights[self.functions]

    @cached_property
    def samples(self) -> tuple[Array, Array, Array]:
        """Parameters u, v (S,) and positions (E, S, dim) of a coarse grid on each panel."""
        axes = [np.linspace(0, 1, n) for n in self._sample_counts]
        u, v = (g.ravel() for g in np.meshgrid(*axes, indexing="ij"))
        p, q = self.surface.degrees
        table = bernstein(p, u)[:, None] * bernstein(q, v)[None]
        values = np.einsum("ijs,eijc->esc", table, self.flat_nets)
        return u, v, np.ascontiguousarray(values[..., :-1] / values[..., -1:])

    @property
    def _sample_counts(self) -> list[int]:
        return [5 if degree else 1 for degree in self.surface.degrees]

    @cached_property
    def sphere(self) -> tuple[Array, Array]:
        """Centres (dim, E) and radii (E,) of balls that hold the panels' control points."""
        points = self.flat_nets[..., :-1] / self.flat_nets[..., -1:]
        points = points.reshape(len(points), -1, points.shape[-1])
        centres = 0.5 * (points.min(axis=1) + points.max(axis=1))
        return centres.T, np.linalg.norm(points - centres[:, None], axis=2).max(axis=1)

    @cached_property
    def open_squares(self) -> Array:
        """Bounds (E, 4) without sides that are points: see ``open_squares``."""
        return open_squares(self.flat_nets)

    @cached_property
    def collapsed_sides(self) -> Index | None:
        """Sides that are points: see ``collapsed_sides``."""
        return collapsed_sides(self.flat_nets)

    @cached_property
    def lengths(self) -> Array:
        """The longer side of each panel: (E,)."""
        return self.sides.max(axis=0)

    @cached_property
    def sides(self) -> Array:
        """The longest line of each panel in each direction: (2, E)."""
        grid = self.samples[2].reshape(len(self.flat_nets), *self._sample_counts, -1)
        u = np.linalg.norm(np.diff(grid, axis=1), axis=3).sum(axis=1).max(axis=1)
        v = np.linalg.norm(np.diff(grid, axis=2), axis=3).sum(axis=2).max(axis=1)
        return np.stack([u, v])

    def levels(self, position: Array, reaches: Array) -> NDArray[np.int8]:
        """The number of ``reaches`` (J, E) that may exceed the distance of each pair: (T, E).

        Points (dim, T) are taken for nearer than they are: by the ball around a panel.
        """
        centres, radii = self.sphere
        level = np.empty((position.shape[1], len(radii)), dtype=np.int8)
        position, centres = np.ascontiguousarray(position), np.ascontiguousarray(centres)
        ball_levels(position, centres, reaches + radii, level)
        return level

    def close_pairs(self, position: Array, reach: Array) -> tuple[Index, Index]:
        """Pairs of points (dim, T) and panels that may be nearer than ``reach`` (E,)."""
        target, panel = np.nonzero(self.levels(position, reach[None]))
        return target, panel

    def closest(self, position: Array, target: Index, panel: Index) -> Array:
        """Closest points (3, pairs) of pairs: u, v within the panel, distance."""
        result = np.empty((3, len(target)))
        target, panel = np.ascontiguousarray(target), np.ascontiguousarray(panel)
        nets, squares = self.flat_nets, self.open_squares
        closest_on_panels(position, target, panel, nets, squares, *self.samples, result)
        return result

    def locate(self, direction: int, parameter: Array) -> NDArray[np.bool_]:
        """Whether parameters (T,) lie in each closed panel interval: bool (T, P)."""
        breaks = self.breaks[direction]
        low = breaks[:-1] - SAME_PARAMETER * np.diff(breaks)
        high = breaks[1:] + SAME_PARAMETER * np.diff(breaks)
        return (parameter[:, None] >= low) & (parameter[:, None] <= high)

    def local(self, direction: int, parameter: Array, panel: Index) -> Array:
        """Parameters within their panels, in [0, 1]; exactly 0 and 1 on the borders, since polar
        rules cannot take a border at the distance of a rounding error."""
        breaks = self.breaks[direction]
        share = (parameter - breaks[panel]) / (breaks[panel + 1] - breaks[panel])
        share = np.where(share < SAME_PARAMETER, 0.0, share)
        return np.where(share > 1.0 - SAME_PARAMETER, 1.0, share)


@lru_cache(maxsize=1024)
def split_patch(surface: Nurbs) -> Panels:
    """Panels of a patch: its elements, halved until none turns by more than 50 degrees."""
    if len(surface.degrees) == 1:
        surface = ruled(surface)
    breaks = tuple(panel_breaks(surface, d) for d in range(2))
    control = surface.homogeneous
    extraction, first = [], []
    for axis, (p, k, b) in enumerate(zip(surface.degrees, surface.knots, breaks, strict=True)):
        broken = np.repeat(b, [p + 1] + [p] * (len(b) - 2) + [p + 1])
        matrix = refinement_matrix(p, k, p, broken)
        control = np.moveaxis(np.tensordot(matrix, control, axes=(1, axis)), 0, axis)
        middles = 0.5 * (b[1:] + b[:-1])
        numbers = np.searchsorted(k, middles, side="right") - 1 - p
        blocks = [matrix[a * p : a * p + p + 1, f : f + p + 1] for a, f in enumerate(numbers)]
        extraction.append(np.ascontiguousarray(blocks))
        first.append(numbers)
    p, q = surface.degrees
    rows, columns = (range(len(b) - 1) for b in breaks)
    nets = np.array([[control[a * p :, b * q :][: p + 1, : q + 1] for b in columns] for a in rows])
    return Panels(surface, breaks, nets, tuple(extraction), tuple(first))


@dataclass(frozen=True, eq=False)
class Nodes:
    """Tensor Gauss nodes of one order on every panel.

    ``position``, ``normal`` (dim, P_u, P_v, N); ``weight`` (P_u, P_v, N), with Jacobian, over
    the weight function; ``functions`` one (P, m, p + 1) array of B-splines a parameter, where N
    is the product of both m.
    """

    position: Array
    normal: Array
    weight: Array
    functions: tuple[Array, ...]

    @cached_property
    def flat(self) -> tuple[Array, Array]:
        """Positions and normals (dim, nodes) of all panels' nodes."""
        return (
            np.ascontiguousarray(self.position.reshape(len(self.position), -1)),
            np.ascontiguousarray(self.normal.reshape(len(self.normal), -1)),
        )

    def weighted(self, panels: Panels, chosen: Index) -> Array:
        """Weighted functions of n ``chosen`` panels at their nodes: (n, N, functions)."""
        grid = np.divmod(chosen, panels.shape[1])
        return weighted_functions(self.functions, panels, grid, self.weight[grid])

    def densities(self, panels: Panels, density: Array) -> Array:
        """Weighted values (components, nodes) of coefficients (components, n_u, n_v)."""
        places = panels.functions
        local = density[:, *places] * panels.controls
        along_u, along_v = self.functions
        values = along_u[None, :, None] @ (local @ along_v.swapaxes(1, 2)[None, None])
        weighted = values * self.weight.reshape(values.shape[1:])
        return np.ascontiguousarray(weighted.reshape(len(density), -1))


@lru_cache(maxsize=1024)
def tensor_nodes(panels: Panels, order: int) -> Nodes:
    """Nodes of the tensor Gauss rule of ``order`` on every panel; one node across a curve."""
    orders = order, order if panels.surface.degrees[1] else 1
    position, normal, weight = _places(panels, panels.flat_nets, orders)
    flat = (*panels.shape, orders[0] * orders[1])
    return Nodes(
        position.reshape(-1, *flat), normal.reshape(-1, *flat), weight.reshape(flat),
        _functions(panels, orders),
    )  # fmt: skip


def nodes_of_some(
    panels: Panels, orders: tuple[int, int], chosen: Index
) -> tuple[Array, Array, Array]:
    """Nodes of tensor rules with an order in each direction, on n ``chosen`` panels only.

    Positions and normals (dim, n N), and weighted functions (n, N, functions).
    """
    orders = orders[0], orders[1] if panels.surface.degrees[1] else 1
    position, normal, weight = _places(panels, panels.flat_nets[chosen], orders)
    grid = np.divmod(chosen, panels.shape[1])
    functions = _functions(panels, orders)
    return position, normal, weighted_functions(functions, panels, grid, weight)


def weighted_functions(
    functions: tuple[Array, ...], panels: Panels, grid: tuple[Index, Index], weight: Array
) -> Array:
    """Functions of panels at places ``grid`` times weights (n, N): (n, N, functions)."""
    u, v = (f[k] for f, k in zip(functions, grid, strict=True))
    values = u[:, :, None, :, None] * v[:, None, :, None, :]
    values *= panels.controls[grid][:, None, None]
    values *= weight.reshape(*values.shape[:3], 1, 1)
    return values.reshape(*weight.shape, -1)


def _functions(panels: Panels, orders: tuple[int, int]) -> tuple[Array, ...]:
    """B-splines (P, m, p + 1) of the panels at Gauss points, in each direction."""
    pairs = zip(panels.surface.degrees, orders, panels.extraction, strict=True)
    return tuple(_bernstein_tables(p, m)[0].T @ extraction for p, m, extraction in pairs)


def _places(panels: Panels, nets: Array, orders: tuple[int, int]) -> tuple[Array, Array, Array]:
    """Positions and normals (dim, n N) and weights (n, N) of tensor nodes on ``nets`` (n, ...)."""
    p, q = panels.surface.degrees
    (bu, du), (bv, dv) = (_bernstein_tables(p, m) for p, m in zip((p, q), orders, strict=True))
    control = np.ascontiguousarray(np.moveaxis(nets, 3, 0))
    across, slopes = control @ bv, control @ dv
    value, along_u, along_v = bu.T @ across, du.T @ across, bu.T @ slopes
    weight = value[-1]
    position = value[:-1] / weight
    tangent_u = (along_u[:-1] - along_u[-1] * position) / weight
    tangent_v = (along_v[:-1] - along_v[-1] * position) / weight
    normal = area_vector(tangent_u, *([tangent_v] if q else []))
    jacobian = np.linalg.norm(normal, axis=0)
    scale = np.where(jacobian > 0, jacobian, 1.0)
    factor = np.outer(gauss_unit(orders[0])[1], gauss_unit(orders[1])[1]) * jacobian / weight
    dim, count = len(position), len(nets)
    normal /= scale
    return position.reshape(dim, -1), normal.reshape(dim, -1), factor.reshape(count, -1)


@lru_cache(maxsize=256)
def _bernstein_tables(degree: int, order: int) -> tuple[Array, Array]:
    t, _ = gauss_unit(order)
    values = bernstein(degree, t)
    if degree == 0:
        return values, np.zeros_like(values)
    lower = bernstein(degree - 1, t)
    slopes = np.zeros_like(values)
    slopes[1:] += degree * lower
    slopes[:-1] -= degree * lower
    return values, slopes


@compiled
def ball_levels(targets, centres, bounds, level):
    """The number of ``bounds`` (J, E) that exceed the distance of each target to each centre.

    ``targets`` (dim, T), ``centres`` (dim, E); into ``level`` (T, E).
    """
    for t in range(targets.shape[1]):
        for e in range(centres.shape[1]):
            square = 0.0
            for c in range(len(targets)):
                square += (targets[c, t] - centres[c, e]) ** 2
            count = 0
            for j in range(len(bounds)):
                if square < bounds[j, e] ** 2:
                    count += 1
            level[t, e] = count
