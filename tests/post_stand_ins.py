"""Shapes and flows with known answers for the tests of pictures and files."""

from dataclasses import dataclass
from types import SimpleNamespace

import numpy as np

from cadbem.boundary import Boundary, Patch
from cadbem.post.fields.frames import Frame
from cadbem.spline import Nurbs
from cadbem.spline.outlines import rectangle

LINE = np.array([0.0, 0.0, 1.0, 1.0])
ARC = np.array([0.0, 0.0, 0.0, 1.0, 1.0, 1.0])
HALF = np.sqrt(0.5)  # cosine of half a quarter turn: weight of an arc's middle control point


def plate(corner, first, second, name, face):
    """Parallelogram whose normal is first × second."""
    corner, first, second = (np.array(v, dtype=float) for v in (corner, first, second))
    points = np.array([[corner, corner + second], [corner + first, corner + first + second]])
    return Patch(Nurbs((1, 1), (LINE, LINE), points, np.ones((2, 2))), name, face)


def box(length=2.0):
    """0 <= x <= length, 0 <= y, z <= 1: inlet is face 1, outlet face 2, walls 3 to 6."""
    x, y, z = length * np.eye(3)[0], np.eye(3)[1], np.eye(3)[2]
    low, high = np.zeros(3), x + y + z
    patches = (
        plate(low, y, z, "inlet", 1),
        plate(high, -z, -y, "outlet", 2),
        plate(low, z, x, "walls", 3),
        plate(high, -x, -z, "walls", 4),
        plate(low, x, y, "walls", 5),
        plate(high, -y, -x, "walls", 6),
    )
    return Boundary(patches, unit="mm")


def quarter_cylinder(radius=1.0, height=2.0, turn=0):
    """A quarter of a cylinder about z, its normal towards the axis."""
    angle = 0.5 * np.pi * turn
    rotation = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    points = np.zeros((2, 3, 3))
    points[..., :2] = radius * np.array([[1, 0], [1, 1], [0, 1]]) @ rotation.T
    points[1, :, 2] = height
    weights = np.broadcast_to([1, HALF, 1], (2, 3)).copy()
    return Patch(Nurbs((1, 2), (LINE, ARC), points, weights), "walls", 1)


def disk(radius, z, up, name, face):
    """Disk as one biquadratic patch whose four edges are quarters of its rim."""
    plane = np.array(
        [[[-1, -1], [-2, 0], [-1, 1]], [[0, -2], [0, 0], [0, 2]], [[1, -1], [2, 0], [1, 1]]]
    )
    points = np.concatenate([radius * HALF * plane, np.full((3, 3, 1), z)], axis=-1)
    weights = np.array([[1, HALF, 1], [HALF, 1, HALF], [1, HALF, 1]])
    surface = Nurbs((2, 2), (ARC, ARC), points, weights)
    return Patch(surface if up else surface.swapped(), name, face)


def pipe(radius=1.0, height=2.0):
    """Round pipe along z."""
    walls = tuple(quarter_cylinder(radius, height, turn) for turn in range(4))
    inlet = disk(radius, 0.0, True, "inlet", 2)
    outlet = disk(radius, height, False, "outlet", 3)
    return Boundary((*walls, inlet, outlet), unit="mm")


@dataclass(frozen=True, eq=False)
class PositionField:
    """The field x -> function(x), (3, N) -> (dim, N), on a boundary."""

    boundary: Boundary
    function: object

    def on_patch(self, index, *parameters):
        return self.function(self.boundary.patches[index].surface.evaluate(*parameters))

    def patch_coefficients(self, index):
        # an affine function of position has the same function of the control points
        points = np.moveaxis(self.boundary.patches[index].surface.points, -1, 0)
        return self.function(points)


@dataclass(frozen=True, eq=False)
class FlowInBox:
    """u = 16 y (1 - y) z (1 - z) e_x in ``box``, pressure 3 - x; largest speed 1."""

    def velocity_at(self, points, quadrature=None):
        _, y, z = points
        speed = 16 * y * (1 - y) * z * (1 - z)
        return np.stack([speed, 0 * speed, 0 * speed])

    def pressure_at(self, points, quadrature=None):
        return 3 - points[0]


def tetrahedra_in_box(length=2.0, counts=(8, 8, 8)):
    """Points (3, N) and tetrahedra (4, M): each cell of a lattice cut into six (Kuhn)."""
    axes = [np.linspace(0, extent, n + 1) for extent, n in zip((length, 1, 1), counts, strict=True)]
    points = np.stack([g.ravel() for g in np.meshgrid(*axes, indexing="ij")])
    number = np.arange(points.shape[1]).reshape([n + 1 for n in counts])
    # along the diagonal of a cell, one axis after the other; odd orders turned to keep volume > 0
    orders = [(0, 1, 2), (1, 2, 0), (2, 0, 1), (0, 2, 1), (2, 1, 0), (1, 0, 2)]
    cells = []
    for i, order in enumerate(orders):
        steps = np.cumsum([[0, 0, 0], *np.eye(3, dtype=int)[list(order)]], axis=0)
        corners = [
            number[tuple(slice(s, s + n) for s, n in zip(step, counts, strict=True))].ravel()
            for step in steps
        ]
        cells.append(np.stack(corners if i < 3 else [corners[k] for k in (0, 2, 1, 3)]))
    return points, np.concatenate(cells, axis=1)


def space(boundary, per_direction=3):
    """A space's boundary and some points on every patch."""
    inner = (np.arange(per_direction) + 0.5) / per_direction
    u, v = (g.ravel() for g in np.meshgrid(inner, inner, indexing="ij"))
    position = np.concatenate([p.surface.evaluate(u, v) for p in boundary.patches], axis=1)
    return SimpleNamespace(boundary=boundary, collocation=SimpleNamespace(position=position))


def rectangular_channel(length=2.0):
    """The plane channel 0 <= x <= length, 0 <= y <= 1 with an inlet and an outlet."""
    names = ("inlet", "outlet", "walls", "walls")
    sides = zip(rectangle((0, 0), (length, 1)), names, strict=True)
    return Boundary(tuple(Patch(side, name) for side, name in sides), unit="mm")


def frames_along(places, body):
    """Frames at the times 0, 1, ... with ``body(x)`` as number 0 at places x, gone where None."""
    return [Frame(float(k), {} if x is None else {0: body(x)}) for k, x in enumerate(places)]
