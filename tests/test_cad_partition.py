"""Plane faces divided into patches: exact areas, nothing left out or covered twice, few patches and
no sharp ones.

Faces are authored with gmsh's OpenCASCADE, which also says what lies inside of them.
"""

from collections.abc import Callable
from itertools import pairwise
from math import asin, atan, cos, degrees, pi, sin, sqrt
from pathlib import Path

import gmsh
import numpy as np
import pytest

from cadbem.boundary import Boundary, Patch
from cadbem.cad.kernel.brep import read_brep
from cadbem.cad.layout.face_patches import face_patches
from cadbem.spline.nurbs import Nurbs

occ = gmsh.model.occ

Author = Callable[[], object]


def patches_of(record: Path) -> list[Nurbs]:
    """Of the only face of the model."""
    occ.synchronize()
    gmsh.write(str(record))
    (face,) = read_brep(record.read_text())
    return list(face_patches(face).surfaces)


def polygon(*corners: tuple[float, float]) -> None:
    points = [occ.addPoint(x, y, 0) for x, y in corners]
    lines = [occ.addLine(a, b) for a, b in pairwise([*points, points[0]])]
    occ.addPlaneSurface([occ.addCurveLoop(lines)])


def regular(count: int, ratio: float = 1.0) -> None:
    """Corners on the unit circle, every other one on one of radius `ratio`."""
    turns = [2 * pi * k / count for k in range(count)]
    radii = [1.0, ratio] * count
    polygon(*[(r * cos(t), r * sin(t)) for t, r in zip(turns, radii, strict=False)])


def l_shape() -> None:
    polygon((0, 0), (3, 0), (3, 1), (1, 1), (1, 3), (0, 3))


def t_shape() -> None:
    polygon((0, 0), (1, 0), (1, 2), (2.5, 2), (2.5, 3), (-1.5, 3), (-1.5, 2), (0, 2))


def plus() -> None:
    polygon((1, 0), (2, 0), (2, 1), (3, 1), (3, 2), (2, 2), (2, 3), (1, 3), (1, 2), (0, 2),
            (0, 1), (1, 1))  # fmt: skip


def y_shape() -> None:
    """Three arms of width 1 reach 3 from the middle; they meet at 1 / sqrt(3) from it."""
    corners = []
    for turn in (pi / 2, 7 * pi / 6, 11 * pi / 6):
        for angle, radius in (
            (-atan(1 / 6), sqrt(9.25)),
            (atan(1 / 6), sqrt(9.25)),
            (pi / 3, 1 / sqrt(3)),
        ):
            corners.append((radius * cos(turn + angle), radius * sin(turn + angle)))
    polygon(*corners)


def comb(teeth: int) -> None:
    """Teeth of 1 × 3, 1 apart, on a base that is 1 high."""
    corners = [(0.0, 0.0), (2 * teeth - 1.0, 0.0)]
    for k in reversed(range(teeth)):
        corners += [(2 * k + 1.0, 4.0), (2.0 * k, 4.0)]
        corners += [(2.0 * k, 1.0), (2 * k - 1.0, 1.0)] if k else []
    polygon(*corners)


def serpentine() -> None:
    """12 passes of 1 × 9, 1 apart, joined at alternating ends."""
    passes = [(2, occ.addRectangle(2 * k, 0, 0, 1, 9)) for k in range(12)]
    bends = [(2, occ.addRectangle(2 * k + 1, 8 * (k % 2), 0, 1, 1)) for k in range(11)]
    occ.fuse(passes, bends)


def disk() -> None:
    occ.addDisk(1, 2, 0, 2, 2)


def half_disk() -> None:
    occ.intersect([(2, occ.addDisk(0, 0, 0, 1, 1))], [(2, occ.addRectangle(-1, 0, 0, 2, 2))])


def washer() -> None:
    occ.cut([(2, occ.addDisk(0, 0, 0, 2, 2))], [(2, occ.addDisk(0.3, 0, 0, 0.5, 0.5))])


def framed(corners: list[tuple[float, float]], middles: dict[int, tuple[float, float]]) -> None:
    """A loop through corners; sides of the numbers in `middles` are arcs about these."""
    points = [occ.addPoint(x, y, 0) for x, y in corners]
    sides = []
    for k, (start, end) in enumerate(pairwise([*points, points[0]])):
        if k in middles:
            sides.append(occ.addCircleArc(start, occ.addPoint(*middles[k], 0), end))
        else:
            sides.append(occ.addLine(start, end))
    occ.addPlaneSurface([occ.addCurveLoop(sides)])


def ring_sector() -> None:
    """Radii 1 and 2, 50° wide, turned so that no side runs along an axis."""
    start, end = 0.3, 0.3 + 5 * pi / 18
    places = [(1, start), (2, start), (2, end), (1, end)]
    framed([(r * cos(t), r * sin(t)) for r, t in places], {1: (0, 0), 3: (0, 0)})


def equal_cusp() -> None:
    """Between two unit circles that touch in the origin, 0.9 radians down their rims."""
    x, y = 1 - cos(0.9), -sin(0.9)
    framed([(0, 0), (-x, y), (x, y)], {0: (-1, 0), 2: (1, 0)})


def unequal_cusp() -> None:
    """Between quarters of circles of radius 1 and 1/2 that touch in the origin."""
    framed([(0, 0), (1, 1), (0.5, 0.5)], {0: (1, 0), 2: (0.5, 0)})


def three_cusps() -> None:
    """Between two unit circles that touch each other and a line."""
    framed([(0, 0), (-1, -1), (1, -1)], {0: (-1, 0), 2: (1, 0)})


def lens() -> None:
    occ.intersect([(2, occ.addDisk(0, 0, 0, 1, 1))], [(2, occ.addDisk(0.8, 0, 0, 1, 1))])


def drilled(width: float, height: float, radius: float, *middles: tuple[float, float]) -> None:
    plate = occ.addRectangle(0, 0, 0, width, height)
    occ.cut([(2, plate)], [(2, occ.addDisk(x, y, 0, radius, radius)) for x, y in middles])


def five_holes() -> None:
    drilled(6, 4, 0.6, (1, 1), (5, 1), (1, 3), (5, 3), (3, 2))


def fifteen_holes(shift: float) -> None:
    """Three rows of five; the second is shifted."""
    rows = [(1 + 2 * i + shift * (j % 2), 1 + 2 * j) for i in range(5) for j in range(3)]
    drilled(10 + 2 * shift, 6, 0.6, *rows)


def slot() -> None:
    """4 long between half disks of radius 1/2; the border has no corner."""
    ends = [(2, occ.addDisk(x, 0.5, 0, 0.5, 0.5)) for x in (0, 4)]
    occ.fuse([(2, occ.addRectangle(0, 0, 0, 4, 1))], ends)


def square_hole() -> None:
    occ.cut([(2, occ.addDisk(0, 0, 0, 2, 2))], [(2, occ.addRectangle(-0.5, -0.5, 0, 1, 1))])


RIM = 2 * sin(0.9) - sin(0.9) * cos(0.9) - 0.9  # of the equal cusp: below, two segments less

# name: author, area, most patches, least angle (degrees) between parameter lines
CASES: dict[str, tuple[Author, float, int, float]] = {
    "L": (l_shape, 5, 2, 90),
    "T": (t_shape, 6, 3, 90),
    "plus": (plus, 5, 3, 90),
    "Y": (y_shape, 3 * (3 - 1 / sqrt(12)) + sqrt(3) / 4, 5, 45),
    "comb of 4": (lambda: comb(4), 7 + 12, 5, 90),
    "comb of 10": (lambda: comb(10), 19 + 30, 11, 90),
    "serpentine": (serpentine, 12 * 9 + 11, 23, 90),
    "triangle": (lambda: regular(3), 1.5 * sin(2 * pi / 3), 3, 60),
    "pentagon": (lambda: regular(5), 2.5 * sin(2 * pi / 5), 2, 54),
    "hexagon": (lambda: regular(6), 3 * sin(pi / 3), 2, 60),
    "heptagon": (lambda: regular(7), 3.5 * sin(2 * pi / 7), 3, 360 / 7),
    "star of 5": (lambda: regular(10, 0.4), 5 * 0.4 * sin(pi / 5), 10, 30),
    "star of 6": (lambda: regular(12, 0.6), 6 * 0.6 * sin(pi / 6), 12, 45),
    "disk": (disk, 4 * pi, 5, 45),
    "half disk": (half_disk, pi / 2, 6, 40),
    "washer": (washer, pi * (4 - 0.25), 4, 70),
    "ring sector": (ring_sector, 5 * pi / 18 * 1.5, 1, 90),
    "one hole": (lambda: drilled(4, 3, 0.7, (2, 1.5)), 12 - 0.49 * pi, 8, 30),
    "five holes": (five_holes, 24 - 5 * 0.36 * pi, 24, 20),
    "fifteen holes": (lambda: fifteen_holes(0), 60 - 15 * 0.36 * pi, 60, 45),
    "shifted holes": (lambda: fifteen_holes(0.5), 66 - 15 * 0.36 * pi, 90, 20),
    "rounded": (lambda: occ.addRectangle(0, 0, 0, 4, 2, roundedRadius=0.5),
                8 - (4 - pi) / 4, 16, 20),
    "slot": (slot, 4 + pi / 4, 16, 20),
    "square hole": (square_hole, 4 * pi - 1, 4, 45),
    "lens": (lens, 2 * np.arccos(0.4) - 0.4 * sqrt(4 - 0.64), 5, 30),
    "equal cusp": (equal_cusp, RIM, 1, 30),
    "unequal cusp": (unequal_cusp, pi / 4 - pi / 16 - 0.375, 6, 10),
    "three cusps": (three_cusps, 2 - pi / 2, 6, 10),
}  # fmt: skip


@pytest.mark.parametrize("name", CASES)
def test_plane_regions(record: Path, name: str):
    """Areas by formulas of polygons, sectors and segments; a hole asks for four patches, n corners
    for n / 2 - 1.

    Angles of 90 (right-angled polygons, sector), 60, 54 and 360/7 (diagonals of regular polygons),
    45 (a square's corners joined with a circle) degrees are exact, the others are floors: patches
    of 20 degrees still solve, and those in a cusp may be sharper. Random points lie in one patch
    if the kernel says that they are inside, and in none if not.
    """
    author, area, most, sharpest = CASES[name]
    author()
    patches = patches_of(record)
    assert len(patches) <= most
    assert least_angle(patches) > sharpest - 1e-4
    assert Boundary(tuple(map(Patch, patches))).area() == pytest.approx(area, rel=1e-12)
    (_, tag), *_ = gmsh.model.getEntities(2)
    low_x, low_y, _, high_x, high_y, _ = gmsh.model.getBoundingBox(2, tag)
    points = np.random.default_rng(1).uniform((low_x, low_y), (high_x, high_y), (200, 2)).T
    inside = [gmsh.model.isInside(2, tag, [x, y, 0]) for x, y in points.T]
    found = sum(is_within(points, outline(patch)).astype(int) for patch in patches)
    assert sum(inside) > 20
    assert found.tolist() == inside


def least_angle(patches: list[Nurbs]) -> float:
    """In degrees, on a grid with the edges; negative if a patch is folded or turned over. Where an
    edge is a point there is none."""
    angles, up = [], 0.0
    for patch in patches:
        grid = np.meshgrid(*[np.linspace(*ends, 21) for ends in patch.domain])
        tangents = patch.derivatives(1, *grid)
        a, b = tangents[1, 0], tangents[0, 1]
        lengths = np.linalg.norm(a, axis=0) * np.linalg.norm(b, axis=0)
        there = lengths > 1e-12 * lengths.max()
        sines = np.cross(a, b, axis=0)[2][there] / lengths[there]
        up = up or np.sign(sines.sum())
        angles.append(degrees(asin(np.clip((up * sines).min(), -1, 1))))
    return min(angles)


def outline(patch: Nurbs) -> np.ndarray:
    """Points (2, n) along the four edges."""
    (a, b), (c, d) = patch.domain
    t = np.linspace(0, 1, 400)[:-1]
    ones = np.ones_like(t)
    sides = [
        (a + (b - a) * t, c * ones),
        (b * ones, c + (d - c) * t),
        (b + (a - b) * t, d * ones),
        (a * ones, d + (c - d) * t),
    ]
    return np.concatenate([patch.evaluate(*side)[:2] for side in sides], axis=1)


def is_within(points: np.ndarray, rim: np.ndarray) -> np.ndarray:
    """Whether a ray from each point (2, n) meets the closed polygon an odd number of times."""
    (x, y), (next_x, next_y) = rim, np.roll(rim, -1, axis=1)
    level = points[1][:, None]
    passes = (y <= level) != (next_y <= level)
    share = (level - y) / np.where(next_y == y, 1, next_y - y)
    right = points[0][:, None] < x + share * (next_x - x)
    return (passes & right).sum(axis=1) % 2 == 1


@pytest.mark.parametrize(
    ("name", "scale"),
    [("L", 1e-3), ("T", 1e3), ("comb of 4", 1e-3), ("ring sector", 1),
     ("lens", 1), ("square hole", 1), ("equal cusp", 1)],
)  # fmt: skip
def test_place_and_size_do_not_matter(record: Path, name: str, scale: float):
    """The same region shifted, turned in space and scaled is divided into as many patches.

    The kernel makes splines of circles when it scales them."""
    author, area, *_ = CASES[name]
    author()
    count = len(patches_of(record))
    faces = gmsh.model.getEntities(2)
    occ.translate(faces, 3, -1, 2)
    occ.rotate(faces, 0, 0, 0, 1, 2, -1, 0.7)
    if scale != 1:
        occ.dilate(faces, 0, 0, 0, scale, scale, scale)
    patches = patches_of(record)
    assert len(patches) == count
    expected = area * scale**2
    assert Boundary(tuple(map(Patch, patches))).area() == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("name", ["washer", "half disk", "one hole", "slot"])
def test_splines_for_circles_are_as_good(record: Path, name: str):
    """Scaled by the kernel, circles become splines: the same areas, no sharper angles."""
    author, area, _, sharpest = CASES[name]
    author()
    occ.synchronize()
    occ.dilate(gmsh.model.getEntities(2), 0, 0, 0, 3, 3, 3)
    patches = patches_of(record)
    assert least_angle(patches) > sharpest - 1e-4
    assert Boundary(tuple(map(Patch, patches))).area() == pytest.approx(9 * area, rel=1e-12)
