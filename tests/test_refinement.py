"""Elements as small as asked for, by sizes that are measured here; shapes stay."""

from math import ceil, log

import numpy as np
import pytest

from cadbem.boundary import Boundary, Patch
from cadbem.errors import InputError
from cadbem.problems.heat import HeatProblem
from cadbem.problems.heat_conditions import Temperature
from cadbem.quadrature import Quadrature
from cadbem.refinement import path_distance
from cadbem.spline.basis import Array
from cadbem.spline.nurbs import Nurbs
from cadbem.spline.outlines import circle, line, rectangle
from cadbem.spline.shapes import box, cylinder, sphere_octants

GAUSS = np.polynomial.legendre.leggauss(12)
PATH = np.array([[-1.0, 0.0, 3.0, 9.0], [0.5, 0.5, -0.5, 0.5], [0.0, 0.2, 0.2, 0.0]])


def boundary_of(surfaces) -> Boundary:
    return Boundary(tuple(Patch(s, "rim") for s in surfaces))


def element_count(boundary: Boundary) -> int:
    return sum(
        int(np.prod([len(p.surface.breaks(d)) - 1 for d in range(boundary.dimension - 1)]))
        for p in boundary.patches
    )


def lengths(spline: Nurbs, direction: int, lines: int = 7) -> tuple[Array, Array]:
    """Lengths (elements, lines) of elements by Gauss quadrature, and the Gauss points on them."""
    breaks = spline.breaks(direction)
    half = 0.5 * np.diff(breaks)
    along = (0.5 * (breaks[1:] + breaks[:-1]) + GAUSS[0][:, None] * half).T.ravel()
    across = [np.linspace(*ends, lines) for d, ends in enumerate(spline.domain) if d != direction]
    grids = list(np.meshgrid(along, *across, indexing="ij"))
    grids = grids[::-1] if direction == 1 else grids
    derivatives = spline.derivatives(1, *grids)
    key = (1,) if not across else (1, 0) if direction == 0 else (0, 1)
    speed = np.linalg.norm(derivatives[key], axis=0).reshape(len(half), len(GAUSS[0]), -1)
    points = derivatives[(0,) * len(key)].reshape(spline.dimension, len(half), len(GAUSS[0]), -1)
    return np.einsum("egl,g,e->el", speed, GAUSS[1], half), points


def assert_fits(boundary: Boundary, size) -> None:
    """No element is longer than the size wanted at any of its points."""
    for patch in boundary.patches:
        for direction in range(boundary.dimension - 1):
            length, points = lengths(patch.surface, direction)
            wanted = size(points.reshape(boundary.dimension, -1)).reshape(points.shape[1:])
            assert (length <= 1.01 * wanted.min(axis=1)).all()


def test_distance_from_a_path():
    """From a piece's inside, from its end, from one point."""
    points = np.array([[1.0, -2.0, 4.0], [3.0, 1.0, -1.0]])
    path = np.array([[0.0, 2.0, 2.0], [1.0, 1.0, 1.0]])
    assert path_distance(points, path) == pytest.approx([2, 2, np.sqrt(8)], rel=1e-15)
    assert path_distance(points, path[:, :1]) == pytest.approx(
        [np.sqrt(5), 2, np.sqrt(20)], rel=1e-15
    )


def test_the_fewest_elements_on_a_line():
    """h = a + g s from the end of a line of length L: elements that are just as long as h at
    their near end have s_k+1 = s_k + h(s_k), so a + g s_k = a (1 + g)^k, and
    n = ln(1 + g L / a) / ln(1 + g), rounded up.  At the line's other end alike."""
    a, g, length = 0.01, 0.25, 3.0
    exact = log(1 + g * length / a) / log(1 + g)
    assert 0.2 < ceil(exact) - exact < 0.8  # room for errors of quadrature
    for end in (0.0, length):
        refined = boundary_of([line((0, 0), (length, 0))]).refined(size=a, near=(end, 0), growth=g)
        assert element_count(refined) == ceil(exact) == 20
        assert_fits(refined, lambda x, end=end: a + g * abs(x[0] - end))


def test_elements_along_a_path():
    """Channel 8 × 2 × 2 with a path through it: sizes at all places, and the number of elements
    along its middle: at the walls' middles h = 0.1 + 0.5 · 1 all along, 14 on a length of 8."""
    channel = boundary_of(box((0, -1, -1), (8, 1, 1)))
    axis = [[-1, 9], [0, 0], [0, 0]]
    refined = channel.refined(size=0.1, near=axis, growth=0.5)
    assert_fits(refined, lambda x: 0.1 + 0.5 * np.hypot(x[1], x[2]))
    for patch in refined.patches[2:]:
        along = int(np.ptp(patch.surface.points[..., 0], axis=0).max() < 8)
        assert len(patch.surface.breaks(along)) - 1 == ceil(8 / 0.6) == 14
    assert refined.volume() == pytest.approx(32, rel=1e-13)
    bent = channel.refined(size=0.2, near=PATH)
    assert_fits(bent, lambda x: 0.2 + 0.5 * path_distance(x, PATH))
    assert element_count(bent) < element_count(channel.refined(size=0.35))


def test_size_as_a_function_on_round_walls():
    """A pipe with small elements about x = 1, same area, volume, points."""
    pipe = boundary_of(cylinder(0.5, 2.0)).elevated(3)

    def size(x):
        return 0.05 + 0.4 * abs(x[0] - 1)

    refined = pipe.refined(size=size)
    assert_fits(refined, size)
    assert refined.area() == pytest.approx(2 * np.pi * 0.5 * 2, rel=1e-13)
    u, v = np.meshgrid(np.linspace(0, 1, 13), np.linspace(0, 1, 11))
    for old, new in zip(pipe.patches, refined.patches, strict=True):
        gap = new.surface.evaluate(u, v) - old.surface.evaluate(u, v)
        assert np.abs(gap).max() < 1e-14
    assert element_count(pipe.refined(size=lambda x: 0.3)) == element_count(pipe.refined(size=0.3))


def test_existing_knots_stay():
    once = boundary_of(sphere_octants(1.0)).refined(3)
    again = once.refined(size=0.1, near=(0, 0, 1))
    for old, new in zip(once.patches, again.patches, strict=True):
        for direction in (0, 1):
            assert set(old.surface.breaks(direction)) <= set(new.surface.breaks(direction))
    assert again.volume() == pytest.approx(-4 * np.pi / 3, rel=1e-13)


def test_number_of_elements():
    """A cube's faces have 4² elements for up to 6 · 5² - 1 in all; near a corner there are fewer
    on the far faces, and no more than asked for."""
    cube = boundary_of(box())
    for wanted, found in ((96, 96), (149, 96), (150, 150), (6, 6)):
        assert element_count(cube.refined(elements=wanted)) == found
    near = cube.refined(elements=150, near=(0, 0, 0), growth=0.3)
    counts = [element_count(Boundary((p,))) for p in near.patches]
    assert 100 < sum(counts) <= 150
    assert element_count(boundary_of(circle()).refined(elements=50)) in range(45, 51)


def test_grading_by_the_first_element():
    """Width 1 in one element, first element 0.01: 0.5^6 is longer, 0.5^7 shorter, so seven cuts
    at the ratio 0.01^(1/7)."""
    square = boundary_of(rectangle())
    graded = square.graded(ratio=0.5, size=0.01)
    ends = 0.01 ** (np.arange(7, 0, -1) / 7)
    for patch in graded.patches:
        breaks = patch.surface.breaks(0)
        assert breaks == pytest.approx(sorted([0, *ends, *(1 - ends), 1]), abs=1e-14)
    assert square.graded(size=2.0).patches[0].surface.breaks(0).tolist() == [0, 1]
    pipe = boundary_of(cylinder(0.5, 2.0)).refined(3)
    pipe = pipe.graded(size=0.03, toward=lambda x, inward: inward[0] > 0.9)
    for patch in pipe.patches:
        along, _ = lengths(patch.surface, 0)
        assert along[0] == pytest.approx([0.03] * 7)
        assert along[-1] == pytest.approx([2 / 3] * 7)


CORNERS = [(0, 0), (-1, 0), (-1, 1), (1, 1), (1, -1), (0, -1)]  # the fluid is to the right
POINTS = np.array([[0.5, 0.3, -0.4, 0.1], [0.5, -0.5, 0.6, 0.1]])


def corner_solution(x: Array) -> Array:
    """r^(2/3) sin(2a/3), harmonic, zero on both sides of the L's inner corner; a from (0, -1)."""
    angle = np.arctan2(x[1], x[0]) + np.pi / 2
    angle = np.where(angle < -1e-9, angle + 2 * np.pi, angle)
    return np.hypot(*x) ** (2 / 3) * np.sin(2 * angle / 3)


def corner_error(boundary: Boundary) -> tuple[int, float]:
    """Unknowns, and the largest error of the temperature at points inside."""
    conditions = {"rim": Temperature(corner_solution)}
    solution = HeatProblem(boundary, 1.0, conditions, quadrature=Quadrature(1e-10)).solve()
    error = solution.temperature_at(POINTS) - corner_solution(POINTS)
    return solution.space.count, float(np.abs(error).max())


def test_grading_towards_an_inner_corner():
    """The heat flux is singular like r^(-1/3): piecewise polynomials on equal elements h come as
    close as h^(2/3) in the energy norm, and twice that order, 4/3, inside.  With elements that
    shrink towards the corner as h = 0.001 + 0.2 r, or from 1/8 to 8^-3 / 4, fewer unknowns are
    thirty times nearer than the finest equal ones."""
    sides = [line(a, b) for a, b in zip(CORNERS, CORNERS[1:] + CORNERS[:1], strict=True)]
    shape = boundary_of(sides).elevated(2)
    assert shape.volume() == pytest.approx(3, rel=1e-14)
    equal = np.array([corner_error(shape.refined(n)) for n in (16, 32, 64)])
    order = -np.polyfit(*np.log(equal.T), 1)[0]
    assert 1.2 < order < 1.5
    count, error = corner_error(shape.refined(size=1e-3, near=(0, 0), growth=0.2))
    assert count < equal[1, 0] and error < 0.03 * equal[2, 1]
    steep = shape.refined(size=1 / 8).graded(
        size=8.0**-3 / 4, ratio=0.5, toward=lambda x, inward: np.hypot(*x) < 1e-9
    )
    count, error = corner_error(steep)
    assert count < equal[0, 0] and error < 0.03 * equal[2, 1]


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ({}, "give one of"),
        ({"spans": 2, "size": 0.1}, "give one of"),
        ({"size": 0.0}, "size is 0.0; give a finite number above 0"),
        ({"size": lambda x: x[0] - 0.5}, r"must be positive; it is not at \[0"),
        ({"spans": 2, "near": (0, 0, 0)}, "near goes with a size"),
        ({"size": (1, 1, 1), "near": (0, 0, 0)}, "near goes with a size"),
        ({"size": 0.1, "near": np.zeros((5, 3))}, r"near has shape \(5, 3\); give .* \(3, N\)"),
        ({"elements": 5}, "there are 6 elements already, more than 5"),
    ],
)
def test_mistakes(words, message):
    with pytest.raises(InputError, match=message):
        boundary_of(box()).refined(**words)
    with pytest.raises(InputError, match="levels of grading or a positive size"):
        boundary_of(box()).graded()
