"""Quantities with units: exact conversions, and the places that check them."""

import math
import pickle

import numpy as np
import pytest
from test_stokes_2d import channel

import cadbem as cb

ENDS = {"outlet": cb.Pressure(0.0), "walls": cb.NoSlip()}


@pytest.fixture(scope="module")
def u() -> cb.Units:
    """mm, s, Pa."""
    return cb.Units()


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("50 um", 0.05), ("50 µm", 0.05), ("50 μm", 0.05), ("2 inch", 50.8),
        ("30 uL/min", 0.5), ("30 µL / min", 0.5), ("30 mm^3 min^-1", 0.5), ("30 mm³/min", 0.5),
        ("1 mPa s", 1e-3), ("1 mPa*s", 1e-3), ("1 mPa·s", 1e-3), ("1 cP", 1e-3),
        ("72 mN/m", 72.0), ("72 dyn/cm", 72.0), ("72 mN m-1", 72.0),
        ("1000 kg/m^3", 1e-3), ("1000 kg/m3", 1e-3), ("1 g/mL", 1e-3),
        ("2 bar", 2e5), ("10 cmH2O", 980.665), ("1.5 kPa", 1500.0), ("-3 mm/s", -3.0),
        ("5 1/s", 5.0), ("5 /s", 5.0),
        ("3 nN", 3e-3), ("1e3 s", 1000.0), (".5 ms", 5e-4), ("5 nL", 5e-3),
    ],
)  # fmt: skip
def test_conversions(u, text, value):
    """In mm, s and Pa: 1 µL = 1 mm³, 1 mN/m = 1 Pa mm, 1 kg = 1000 Pa mm s², so that 1 kg/m³
    = 1e-6 Pa s²/mm²."""
    assert u(text) == pytest.approx(value, rel=1e-12)


def test_other_units():
    """In µm, ms and kPa: 1 mm/s = 1 µm/ms, 1 mPa s = 1e-3 kPa ms, 1 mN/m = 1 kPa µm."""
    small = cb.Units("um", "ms", "kPa")
    found = [small(text) for text in ("1 mm/s", "1 mPa s", "1 mN/m", "1 nL")]
    assert found == pytest.approx([1.0, 1e-3, 1.0, 1e6], rel=1e-12)
    assert small.si(1.0, "viscosity") == pytest.approx(1.0, rel=1e-12)


def test_back_to_si(u):
    assert u.si(0.5, "flow_rate") == pytest.approx(5e-10, rel=1e-12)
    assert u.si(u("72 mN/m"), "tension") == pytest.approx(0.072, rel=1e-12)
    shown = {
        "flow_rate": (0.5, "30 µL/min"), "pressure": (12345.0, "12.35 kPa"),
        "viscosity": (1e-3, "1 mPa·s"), "tension": (72.0, "72 mN/m"), "length": (0.05, "50 µm"),
        "volume": (3e-4, "300 pL"), "velocity": (2.0, "2 mm/s"), "time": (0.02, "20 ms"),
        "area": (2.0, "2 mm²"), "rate": (30.0, "30 1/s"),
    }  # fmt: skip
    assert {kind: u.show(value, kind) for kind, (value, _) in shown.items()} == {
        kind: text for kind, (_, text) in shown.items()
    }
    assert u.show(0.0, "pressure") == "0 Pa"
    with pytest.raises(cb.UnitsError, match="'weight' is no kind of quantity"):
        u.show(1.0, "weight")


def test_quantities_are_floats(u):
    one = u("1 mm/s")
    assert isinstance(one, float) and type(2 * one) is float and type(one / one) is float
    assert one * np.arange(2) == pytest.approx([0, 1])
    kept = pickle.loads(pickle.dumps(one))
    assert (kept, kept.dimension, kept.text) == (1.0, (1, 0, -1), "1 mm/s")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("30", "'30' has no unit"),
        ("mm", "'mm' is not a quantity"),
        (30.0, "30.0 is not a quantity"),
        ("3 bananas", "the unit 'bananas' is not known"),
        ("0,5 mm", "is not known"),
        ("3 mm +", "is not known"),
        ("20 degC", "not a mechanical quantity"),
        ("1 mol/L", "not a mechanical quantity"),
        ("3 m^0.5", "not a mechanical quantity"),
        ("2 mm/m", "is a plain number"),
    ],
)
def test_text_that_is_no_quantity(u, text, message):
    with pytest.raises(cb.UnitsError, match=message) as caught:
        u(text)
    assert "\n" not in str(caught.value)


def test_base_units():
    with pytest.raises(cb.UnitsError, match="length='s' is not a length"):
        cb.Units(length="s")
    with pytest.raises(cb.UnitsError, match="pressure='N' is not a pressure"):
        cb.Units(pressure="N")
    boundary = channel()
    with pytest.raises(cb.UnitsError, match="no unit of length; say it"):
        cb.Units.of(boundary)
    inches = cb.Boundary(boundary.patches, unit="inch")
    assert cb.Units.of(inches)("25.4 mm") == pytest.approx(1.0, rel=1e-12)


def test_doors(u):
    """Each place that takes a quantity refuses one of another dimension, in one line."""
    flow = cb.FreeFlow(cb.shear())
    drop = cb.Droplet(cb.spline_sphere(points=50), cb.SurfaceTension(u("1 mN/m")))
    fine = {"inlet": cb.Inflow(mean_velocity=u("1 mm/s")), **ENDS}
    doors = {
        "mean_velocity: '1 uL/s' is a volume per time; give a length per time such as '1 mm/s'":
            lambda: cb.Inflow(mean_velocity=u("1 uL/s")),
        "flow_rate: '1 mm/s' is a length per time; give a volume per time such as '30 uL/min'":
            lambda: cb.Inflow(flow_rate=u("1 mm/s")),
        "Pressure: '1 N' is a force; give a pressure": lambda: cb.Pressure(u("1 N")),
        "viscosity: '1 Pa' is a pressure; give a viscosity":
            lambda: cb.StokesProblem(channel(), u("1 Pa"), fine),
        "tension: '1 Pa' is a pressure; give a force per length":
            lambda: cb.SurfaceTension(u("1 Pa")),
        "radius: '1 s' is a time; give a length": lambda: cb.spline_sphere(u("1 s")),
        "centre: '1 s' is a time; give a length":
            lambda: cb.spline_sphere(1.0, (0.0, u("1 s"), u("1 mm"))),
        "radius: '2 mm² / s' is an area per time; give a length":
            lambda: cb.rigid_sphere(u("2 mm² / s")),
        "position: '1 s' is a time; give a length":
            lambda: cb.rigid_sphere(1.0, [u("1 s"), 0.0, 0.0]),
        "end and every: '1 mm' is a length; give a time":
            lambda: next(cb.Simulation(flow, drop).run(u("1 mm"))),
        "every: '3 kg' is mass\\^1; give a time":
            lambda: next(cb.Simulation(flow, drop).run(u("1 s"), u("3 kg"))),
    }  # fmt: skip
    for message, door in doors.items():
        with pytest.raises(cb.UnitsError, match=message) as caught:
            door()
        assert "\n" not in str(caught.value)
    assert cb.Inflow(flow_rate=u("2 mm^2/s")).flow_rate == 2.0  # in a plane
    assert cb.spline_sphere(u("50 um"), (u("1 mm"), 0, 0), 50).coefficients.max() < 1.1


def test_units_that_do_not_go_together(u):
    """A quantity for lengths in µm, at a boundary in mm; quantities of two sets of units."""
    boundary = cb.Boundary(channel().patches, unit="mm")
    small = cb.Units("um")
    inflow = {"inlet": cb.Inflow(mean_velocity=small("1 mm/s")), **ENDS}
    with pytest.raises(cb.UnitsError, match="'inlet': '1 mm/s' was made for lengths in um, but"):
        cb.StokesProblem(boundary, 1.0, inflow)
    with pytest.raises(cb.UnitsError, match="'inlet': '1 mm/s' was made with Units"):
        cb.StokesProblem(channel(), u("1 mPa s"), inflow)


def test_a_channel_in_any_units():
    """12 μ U L / h² = 12 × 2 mPa s × 3 mm/s × 2 mm / (0.5 mm)² = 0.576 Pa, with lengths in mm and
    in µm, and from dimensionless numbers: 12 L / h² times μ U / mm."""

    def drop(boundary: cb.Boundary, viscosity: float, velocity: float) -> float:
        ends = {"inlet": cb.Inflow(mean_velocity=velocity), **ENDS}
        problem = cb.StokesProblem(boundary, viscosity, ends, cb.Quadrature(1e-9))
        return problem.solve().mean_pressure("inlet")

    plain = channel().elevated(2).refined(2)
    for unit, size in (("mm", 1.0), ("um", 1000.0)):
        scaled = [
            cb.Patch(p.surface.transformed(size * np.eye(2), np.zeros(2)), p.name)
            for p in plain.patches
        ]
        boundary = cb.Boundary(tuple(scaled), unit=unit)
        own = cb.Units.of(boundary, "ms", "kPa")
        found = drop(boundary, own("2 mPa s"), own("3 mm/s"))
        assert own.si(found, "pressure") == pytest.approx(0.576, rel=1e-7)
        assert own.show(found, "pressure") == "576 mPa"
    assert drop(plain, 1.0, 1.0) * 2e-3 * 3 == pytest.approx(0.576, rel=1e-7)


def test_numbers(u):
    """Water with oil drops: Ca = 1e-3 × 1e-2 / 0.05 = 2e-4, λ = 20, Re = 1000 × 1e-2 × 1e-4
    / 1e-3 = 1."""
    found = cb.numbers(
        viscosity=u("1 mPa s"), velocity=u("10 mm/s"), length=u("100 um"), tension=u("50 mN/m"),
        viscosity_inside=u("20 mPa s"), density=u("1 g/mL"),
    )  # fmt: skip
    assert [found.capillary, found.viscosity_ratio, found.reynolds] == pytest.approx([2e-4, 20, 1])
    bare = cb.numbers(viscosity=2.0, velocity=3.0, length=1.0)
    assert bare == cb.Numbers(None, None, None)
    with pytest.raises(cb.UnitsError, match="length: '1 s' is a time"):
        cb.numbers(viscosity=1.0, velocity=1.0, length=u("1 s"))
    assert math.isclose(cb.numbers(viscosity=2, velocity=3, length=1, tension=4).capillary, 1.5)


def test_text_and_other_dimensions_are_refused_at_the_doors(u):
    """Text that was not made a number, and quantities of openings and tubes."""
    with pytest.raises(cb.UnitsError, match="flow_rate: '30 uL/min' is text; make a number of it"):
        cb.Inflow(flow_rate="30 uL/min")
    conductance = np.array([[1.0, -1.0], [-1.0, 1.0]])
    network = cb.Network(("in", "out"), conductance, 0 * conductance, None)
    with pytest.raises(cb.UnitsError, match="flow rate at 'in': '30 mm/s' is a length per time"):
        network.operate({"out": 0.0}, {"in": u("30 mm/s")})
    with pytest.raises(cb.UnitsError, match="pressure at 'out': '2 mm' is a length"):
        network.operate({"out": u("2 mm")}, {"in": 1.0})
    with pytest.raises(cb.UnitsError, match="tubing at 'in': '1 Pa' is a pressure"):
        network.operate({"out": 0.0}, {"in": 1.0}, {"in": u("1 Pa")})
