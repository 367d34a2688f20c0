"""Random drawings, written as STEP and IGES: they are read rightly, or refused by a CadError."""

from collections.abc import Iterator
from math import asin, copysign, cos, hypot, pi, sin
from pathlib import Path
from random import Random

import gmsh
import pytest
from drawn import exported

from cadbem.boundary import Boundary
from cadbem.cad import read_cad
from cadbem.errors import CadError

occ = gmsh.model.occ
BULGES = (0, 0, 0.001, 0.05, 0.2, -0.001, -0.05, -0.2)  # rise of an arc per chord, outward positive
SUFFIXES = (".step", ".igs")


def corners_and_bulges(random: Random) -> tuple[list[tuple[float, float]], list[float]]:
    """A polygon that is seen from the origin, sharp and uneven, and a bulge for each side."""
    count = random.randint(3, 9)
    angles = sorted(random.uniform(0, 2 * pi) for _ in range(count))
    gaps = [(b - a) % (2 * pi) for a, b in zip(angles, angles[1:] + angles[:1], strict=True)]
    if max(gaps) > pi - 0.2:
        return corners_and_bulges(random)
    radii = [random.uniform(0.3, 1.5) for _ in angles]
    points = [(r * cos(a), r * sin(a)) for r, a in zip(radii, angles, strict=True)]
    return points, [random.choice(BULGES) for _ in points]


def prism(random: Random) -> tuple[float, float]:
    """Draws a prism. The area inside is the polygon's by the shoelace rule and the segments'
    R² (t - sin t) / 2, with R = (c²/4 + s²) / 2s and t = 2 asin(c / 2R) for a chord c and a rise s.
    Volume and area of the surface follow."""
    points, bulges = corners_and_bulges(random)
    height, plan, perimeter, lines = random.uniform(0.2, 2), 0.0, 0.0, []
    tags = [occ.addPoint(x, y, 0) for x, y in points]
    for k, bulge in enumerate(bulges):
        (x, y), (u, v) = points[k], points[(k + 1) % len(points)]
        chord = hypot(u - x, v - y)
        plan += 0.5 * (x * v - u * y)
        if not bulge:
            perimeter += chord
            lines.append(occ.addLine(tags[k], tags[(k + 1) % len(points)]))
            continue
        rise = abs(bulge) * chord
        radius = (chord**2 / 4 + rise**2) / (2 * rise)
        turn = 2 * asin(chord / (2 * radius))
        plan += copysign(0.5 * radius**2 * (turn - sin(turn)), bulge)
        perimeter += radius * turn
        arm = copysign(radius - rise, bulge) / chord
        centre = occ.addPoint(0.5 * (x + u) - arm * (v - y), 0.5 * (y + v) + arm * (u - x), 0)
        lines.append(occ.addCircleArc(tags[k], centre, tags[(k + 1) % len(points)]))
    occ.extrude([(2, occ.addPlaneSurface([occ.addCurveLoop(lines)]))], 0, 0, height)
    return plan * height, 2 * plan + perimeter * height


def solid(random: Random) -> tuple[int, int]:
    """A box, a cylinder or a ball about the origin."""
    corner = [random.uniform(-1, 1) for _ in range(3)]
    shape = random.randrange(3)
    if shape == 0:
        return 3, occ.addBox(*corner, *(random.uniform(0.3, 1.5) for _ in range(3)))
    if shape == 1:
        axis = [random.uniform(-1, 1) for _ in range(3)]
        return 3, occ.addCylinder(*corner, *axis, random.uniform(0.2, 0.7))
    return 3, occ.addSphere(*corner, random.uniform(0.2, 0.8))


def readings(path: Path) -> Iterator[Boundary]:
    """What is drawn, read from STEP and IGES files, where it is not refused in one line."""
    for suffix in SUFFIXES:
        try:
            yield read_cad(exported(path.with_suffix(suffix)))
        except CadError as error:
            assert "\n" not in str(error)


def check_prism(folder: Path, seed: int) -> bool:
    """Whether it is read. Files that contradict themselves are read with a warning, and are no more
    exact than that."""
    gmsh.clear()
    volume, area = prism(Random(seed))
    found = list(readings(folder / f"prism{seed}"))
    for boundary in found:
        assert boundary.volume() == pytest.approx(volume, rel=1e-4), seed
        assert boundary.area() == pytest.approx(area, rel=1e-4), seed
    return bool(found)


def check_boolean(folder: Path, seed: int) -> bool:
    """Whether a union or a cut is read as large as the kernel, which is exact to 3e-3 on these,
    says that it is."""
    gmsh.clear()
    random = Random(seed)
    pair = [solid(random)], [solid(random)]
    bodies, _ = (occ.fuse if random.random() < 0.5 else occ.cut)(*pair)
    volume = sum(occ.getMass(*tag) for tag in bodies if tag[0] == 3)
    found = list(readings(folder / f"boolean{seed}"))
    for boundary in found:
        assert boundary.volume() == pytest.approx(volume, rel=3e-3), seed
    return bool(found)


@pytest.mark.filterwarnings("ignore::cadbem.errors.CadWarning")
@pytest.mark.parametrize("check", [check_prism, check_boolean])
def test_a_few_random_drawings(folder: Path, check):
    assert any([check(folder, seed) for seed in range(2)])


@pytest.mark.filterwarnings("ignore::cadbem.errors.CadWarning")
def test_an_outline_that_crosses_itself_is_refused(folder: Path):
    """The drawing of this seed has two arcs that cross near [0.18, -0.31]."""
    prism(Random(5015))
    with pytest.raises(CadError, match=r"cross at \[0.18\d*, -0.3"):
        read_cad(exported(folder / "crossed.step"))


@pytest.mark.long
@pytest.mark.filterwarnings("ignore::cadbem.errors.CadWarning")
@pytest.mark.parametrize(("check", "count"), [(check_prism, 300), (check_boolean, 100)])
def test_many_random_drawings(folder: Path, check, count: int):
    """More than a third is read: others cross themselves, or are two bodies."""
    assert sum(check(folder, seed) for seed in range(count)) > count / 3
