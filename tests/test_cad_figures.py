"""Like figures are divided once, and what is said of those that cannot be divided."""

from math import pi
from pathlib import Path

import gmsh
import numpy as np
import pytest
from drawn import exported

from cadbem.cad import read_cad
from cadbem.cad.kernel.brep import read_brep
from cadbem.cad.layout.causes import likely_cause
from cadbem.cad.layout.partition import divided
from cadbem.cad.layout.region import region_of
from cadbem.cad.layout.trimming_curves import line

occ = gmsh.model.occ


def triangle(scale: float):
    corners = scale * np.array([[0.0, 0.0], [3.0, 0.0], [0.0, 2.0]])
    return region_of([tuple(line(corners[k - 1], corners[k]) for k in range(3))])


def test_figures_of_other_sizes_are_others():
    """Parts of a triangle twice as large are twice as large; those of an equal one are the same."""
    small, again, large = (divided(triangle(scale)) for scale in (1.0, 1.0, 2.0))
    assert all(a is b for a, b in zip(small, again, strict=True))
    extents = [max(float(np.abs(s[0].samples).max()) for p in parts for s in p.sides)
               for parts in (small, large)]  # fmt: skip
    assert extents[1] == pytest.approx(2 * extents[0])


def test_discs_of_nearly_equal_size(folder: Path):
    """Two cylinders of radii 1 and 1.0001, one on the other and out of line: V = π (1 + 1.0002)."""
    lower = [(3, occ.addCylinder(0, 0, 0, 0, 0, 1, 1))]
    occ.fuse(lower, [(3, occ.addCylinder(0.0003, 0, 1, 0, 0, 1, 1.0001))])
    boundary = read_cad(exported(folder / "step.step"))
    assert boundary.volume() == pytest.approx(pi * (1 + 1.0001**2), rel=1e-7)


@pytest.mark.parametrize(
    ("points", "kind", "size"),
    [
        ([(0, 0), (5, 0), (5, 0.1)], "corner", np.degrees(np.arctan(0.02))),
        ([(0, 0), (4, 0), (4, 3), (0.02, 3), (0, 2.9)], "edge", np.hypot(0.02, 0.1)),
        ([(0, 0), (4, 0), (4, 3), (2, 3), (1.9, 0.01), (1.8, 3), (0, 3)], "gap", 0.01),
    ],
)
def test_causes(record: Path, points: list[tuple], kind: str, size: float):
    """A wedge, a bevel, and a notch that nearly reaches the other side."""
    tags = [occ.addPoint(x, y, 1) for x, y in points]
    lines = [occ.addLine(tags[k - 1], tags[k]) for k in range(len(tags))]
    occ.addPlaneSurface([occ.addCurveLoop(lines)])
    face = read_brep(exported(record).read_text())[0]
    cause = likely_cause(face)
    assert cause is not None
    assert (cause.kind, cause.place[2]) == (kind, pytest.approx(1))
    assert cause.size == pytest.approx(size, rel=1e-6)
