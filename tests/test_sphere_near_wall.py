"""A sphere close to a wall: drag, torque, and what couples them, against bispherical series.

Exact values come from ``sphere_near_wall_series``, which is itself tested against values computed
elsewhere.  One solution has them all: for a sphere that moves along x and z and turns about x, the
planes of symmetry tell apart the drag along x and torque about y of the first motion, the drag
along z of the second, and the drag along y and torque about x of the third.
"""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from sphere_near_wall_series import along_wall, towards_wall

from cadbem.problems.conditions import Background, NoSlip
from cadbem.problems.stokes import StokesProblem
from cadbem.quadrature import Quadrature
from cadbem.verification.figures.rigid_bodies import WALLS
from cadbem.verification.spheres import SLIDING
from cadbem.verification.walls import near_wall

DATA = json.loads((Path(__file__).parent / "data" / "reference.json").read_text())
REFERENCE = {h: v for h, v in DATA["sphere_near_wall"].items() if h != "note"}


def problem(height, elements, **options):
    motion = replace(SLIDING, centre=(0.0, 0.0, height))
    conditions = {"body": motion, "wall": NoSlip()}
    mesh = {k: options.pop(k) for k in ("rings", "across", "side") if k in options}
    boundary = near_wall(height, elements, **mesh)
    return StokesProblem(boundary, 1.0, conditions, Quadrature(1e-6), **options)


def errors(height, solution):
    """Relative errors of Ft, Tt, Fr, Tr and of the drag away from the wall."""
    exact = along_wall(height)
    force = -solution.force("body") / (6 * np.pi)
    torque = -solution.torque("body", (0, 0, height)) / (8 * np.pi)
    # a quarter of a turn takes a rotation about y and a force along x to -x and y
    reached = np.array([force[0], torque[1], -force[1], torque[0], force[2]])
    return reached / [*(exact[k] for k in ("Ft", "Tt", "Fr", "Tr")), towards_wall(height)] - 1


@pytest.mark.parametrize("height", REFERENCE)
def test_series(height):
    """Values computed elsewhere; 12 digits of the height limit those at the second, cosh 1."""
    values = along_wall(float(height))
    for name, exact in REFERENCE[height].items():
        assert values[name] == pytest.approx(exact, rel=1e-10 if name[1] == "t" else 1e-11)


@pytest.mark.parametrize("height", [1.001, 1.01, 1.1, 3.0])
def test_series_is_reciprocal(height):
    """6 Fr = 8 Tt / (a = 1): the torque of a moving sphere is the force of a turning one."""
    values = along_wall(height)
    assert 6 * values["Fr"] == pytest.approx(8 * values["Tt"], rel=1e-10)


def test_series_far_and_near():
    """Far away, Ft = 1 / (1 - 9/16h + h⁻³/8 - 45 h⁻⁴/256 - h⁻⁵/16) (Faxén), Tr = 1 + 5 h⁻³/16, and
    the drag away from the wall is 1 / (1 - 9/8h + h⁻³/2) (Lorentz).  At a gap ε the lubrication
    layer gives 1/ε + ln(1/ε)/5 + 0.97128 for that drag (Cox and Brenner), and logarithms of slopes
    8/15, 2/5 and 2/15 (Goldman, Cox and Brenner) for Ft, Tr and |Fr|, up to terms like ε ln ε."""
    h = 40.0
    far = along_wall(h)
    drag = 1 / (1 - 9 / (16 * h) + h**-3 / 8 - 45 * h**-4 / 256 - h**-5 / 16)
    assert far["Ft"] == pytest.approx(drag, abs=1e-9)
    assert far["Tr"] == pytest.approx(1 + 5 / 16 * h**-3, abs=1e-8)
    assert towards_wall(h) == pytest.approx(1 / (1 - 9 / (8 * h) + h**-3 / 2), abs=1e-6)
    close = [along_wall(1 + gap) for gap in (1e-3, 5e-4)]
    for name, slope in {"Ft": 8 / 15, "Tr": 2 / 5, "Fr": -2 / 15}.items():
        measured = (close[1][name] - close[0][name]) / np.log(2)
        assert measured == pytest.approx(slope, rel=2e-2)
    expected = 1e3 + np.log(1e3) / 5 + 0.97128
    assert towards_wall(1.001) == pytest.approx(expected, abs=2e-3)


def test_constants_of_the_workflow():
    for height, exact in WALLS.items():
        values = along_wall(height)
        expected = (values["Ft"], values["Tr"], towards_wall(height))
        assert exact == pytest.approx(expected, rel=1e-11)


def test_gap_of_a_tenth():
    """All five within 1e-4 from 1228 points; what is missing of the plate, of side 100, is
    some 3e-5 of that (see ``test_truncated_plates``)."""
    assert np.abs(errors(1.1, problem(1.1, 8).solve())).max() < 1e-4


@pytest.mark.long
def test_gap_of_a_hundredth():
    """All five within 1e-3 from 1588 points, drag along the wall and torque within 1e-4."""
    error = np.abs(errors(1.01, problem(1.01, 14).solve()))
    assert error.max() < 1e-3
    assert error[[0, 3]].max() < 1e-4


@pytest.mark.long
def test_truncated_plates():
    """What is missing of a plate of side s feels a Stokeslet that is screened by the wall, whose
    wall traction falls like r⁻³ and acts back with another r⁻¹ screened to r⁻²: an error like
    ∫ r⁻⁵ r dr ~ s⁻³."""
    sides = np.array([12.0, 24.0])
    found = [abs(errors(1.1, problem(1.1, 8, side=s, rings=r).solve())) for s, r in
             zip(sides, (8, 10), strict=True)]  # fmt: skip
    slopes = -np.log2(found[1][[0, 1, 2, 3]] / found[0][[0, 1, 2, 3]])
    assert slopes == pytest.approx([3.0] * 4, abs=0.25)


def test_pressure_is_no_matter():
    """S n = 0 in the fluid and on all of its boundary, in the gap too, so that f may change
    by c n on the sphere; the pressure far away decides on c, and not on force and torque."""
    still = problem(1.1, 4, rings=5, across=2)
    ball = [p.surface.points.reshape(-1, 3) for p in still.boundary.patches if p.name == "body"]
    normal = np.zeros((3, still.space.count))
    normal[:, : sum(map(len, ball))] = np.concatenate(ball).T - [[0.0], [0.0], [1.1]]
    assert abs(still.layers.apply(normal, 0 * normal)).max() < 1e-5
    pressed = problem(1.1, 4, rings=5, across=2, background=Background(pressure=5.0))
    a, b = still.solve(), pressed.solve()
    difference = b.traction.coefficients - a.traction.coefficients
    assert difference == pytest.approx(-5 * normal, abs=1e-3)
    assert b.force("body") == pytest.approx(a.force("body"), abs=1e-4)
    assert b.torque("body", (0, 0, 1.1)) == pytest.approx(a.torque("body", (0, 0, 1.1)), abs=1e-4)
