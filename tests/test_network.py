"""Hydraulic networks against exact resistances, conservation and reciprocity."""

import json
from pathlib import Path

import numpy as np
import pytest
from shapes import channel as duct
from test_stokes_2d import channel

import cadbem as cb

ROOT = Path(__file__).parents[1]
REFERENCE = json.loads((Path(__file__).parent / "data" / "reference.json").read_text())
PLANE = 12 * 3.0 * 2.0 / 0.5**3  # 12 μ L / h³ of test_stokes_2d's channel, with μ = 3


def plane_channel(**options) -> cb.Network:
    boundary = channel().elevated(2).refined(size=0.2)
    return cb.hydraulic_network(boundary, 3.0, ["inlet", "outlet"], cb.Quadrature(1e-9), **options)


@pytest.fixture(scope="module")
def straight() -> cb.Network:
    return plane_channel()


@pytest.fixture(scope="module")
def focusing() -> cb.Network:
    """Four openings in a plane, without symmetry between inlet and outlet."""
    plan = cb.read_outline(ROOT / "geometries" / "flow_focusing.step").elevated(2).refined(size=0.3)
    return cb.hydraulic_network(plan, 2.0, ["inlet", "side_a", "side_b", "outlet"])


def test_plane_channel(straight):
    """Q = (p_in - p_out) h³ / (12 μ L): two openings make one number."""
    assert straight.resistance("outlet") == pytest.approx(np.array([[PLANE]]), rel=1e-8)
    exact = np.array([[1, -1], [-1, 1]]) / PLANE
    assert straight.conductance == pytest.approx(exact, rel=1e-7)


def test_compressed_storage():
    """The same exact resistance by iteration."""
    found = plane_channel(storage=cb.Compressed(1e-9)).resistance("inlet")
    assert found == pytest.approx(np.array([[PLANE]]), rel=1e-6)


def test_square_duct():
    """Δp = 28.454... μ U L / W² with Q = U W², within 1 % from 150 points."""
    boundary = duct().elevated(2).refined(3)
    found = cb.hydraulic_network(boundary, 1.0, ["inlet", "outlet"]).resistance("outlet")[0, 0]
    gradient = float(REFERENCE["duct"]["W1_H1"]["minus_dpdx_over_muUm"])
    assert found == pytest.approx(2 * gradient, rel=1e-2)


def test_round_pipe():
    """Hagen-Poiseuille: Δp = 8 μ L Q / (π R⁴), L = 6 and R = 1, within 1 %."""
    pipe = cb.read_cad(ROOT / "geometries" / "round_pipe.step").elevated(2).refined(size=1.0)
    found = cb.hydraulic_network(pipe, 1.0, ["inlet", "outlet"], cb.Quadrature(1e-4))
    assert found.resistance("outlet")[0, 0] == pytest.approx(8 * 6 / np.pi, rel=1e-2)


def test_reciprocity_and_conservation(focusing):
    """G = Gᵀ; equal pressures drive nothing, what enters leaves; mirror images conduct alike."""
    conductance, scale = focusing.conductance, abs(focusing.conductance).max()
    assert focusing.asymmetry < 1e-4
    assert abs(conductance.sum(axis=0)).max() < 1e-10 * scale
    assert abs(conductance.sum(axis=1)).max() < 1e-4 * scale
    assert conductance[1, 1] == pytest.approx(conductance[2, 2], rel=1e-6)
    assert np.linalg.eigvalsh(conductance + conductance.T)[1] > 0  # dissipation


def test_operating_points_are_flows(focusing):
    """Rates and pressures of any mix are those of a flow that is solved for afresh."""
    pressures, rates = {"outlet": 1.0, "side_b": 5.0}, {"inlet": 2.0, "side_a": 0.5}
    point = focusing.operate(pressures, rates)
    assert point.flow_rates.sum() == pytest.approx(0, abs=1e-9)
    ends = {n: cb.Pressure(p) for n, p in pressures.items()}
    ends |= {n: cb.Inflow(flow_rate=q) for n, q in rates.items()}
    problem = focusing.problem
    fresh = cb.StokesProblem(problem.boundary, 2.0, {"walls": cb.NoSlip(), **ends}).solve()
    found = [fresh.flow_rate(n) for n in point.names]
    assert point.flow_rates == pytest.approx(found, abs=2e-3)
    flow = focusing.flow(point)
    assert [flow.flow_rate(n) for n in point.names] == pytest.approx(point.flow_rates, abs=1e-9)
    assert flow.mean_pressure("inlet") == pytest.approx(fresh.mean_pressure("inlet"), rel=1e-3)


def test_resistance_matrix_inverts_the_network(focusing):
    """p_i - p_reference = Σ R_ij Q_j with the pressures and rates of an operating point."""
    point = focusing.operate({"outlet": 0.0, "inlet": 3.0}, {"side_a": 1.0, "side_b": 0.2})
    drops = focusing.resistance("outlet") @ point.flow_rates[:3]
    assert drops == pytest.approx(point.pressures[:3], rel=1e-3)


def test_tubing(straight):
    """Resistances in series add up: P = (R_tube + R + R_tube') Q."""
    point = straight.operate({"inlet": 10.0, "outlet": 0.0}, tubing={"inlet": 100, "outlet": 50})
    rate = 10.0 / (150 + PLANE)
    assert point.flow_rates == pytest.approx([rate, -rate], rel=1e-7)
    assert point.pressures == pytest.approx([10 - 100 * rate, 50 * rate], rel=1e-7)
    assert point.outside == pytest.approx([10, 0], abs=1e-7)
    pushed = straight.operate({"outlet": 0.0}, {"inlet": 2.0}, {"inlet": 100})
    assert pushed.outside[0] == pytest.approx(2 * (100 + PLANE), rel=1e-7)


def test_split_of_a_symmetric_junction():
    """Fluid that enters a T through its stem leaves by halves; a closed opening gets nothing."""
    plan = cb.read_outline(ROOT / "geometries" / "t_junction.step").elevated(2).refined(size=0.4)
    network = cb.hydraulic_network(plan, 1.0, ["inlet_a", "inlet_b", "outlet"])
    halves = network.operate({"inlet_a": 0.0, "outlet": 0.0}, {"inlet_b": 1.0}).fractions
    assert halves == pytest.approx({"inlet_a": 0.5, "outlet": 0.5}, abs=1e-6)
    closed = network.operate({"outlet": 0.0}, {"inlet_b": 1.0, "inlet_a": 0.0}).fractions
    assert closed == pytest.approx({"outlet": 1.0}, abs=1e-9)


def test_other_data_of_the_same_kinds():
    """Δp = 12 μ U L / h², for U from 2 to 5 with the same matrix."""
    boundary = channel().elevated(2).refined(size=0.2)
    ends = {"inlet": cb.Inflow(mean_velocity=2.0), "outlet": cb.Pressure(0.0)}
    problem = cb.StokesProblem(boundary, 3.0, {**ends, "walls": cb.NoSlip()}, cb.Quadrature(1e-9))
    other = problem.with_data({"inlet": cb.Inflow(mean_velocity=5.0)})
    assert other.system.factors is problem.system.factors
    for chosen, speed in ((other, 5.0), (problem, 2.0)):
        exact = 12 * 3.0 * speed * 2.0 / 0.5**2
        assert chosen.solve().mean_pressure("inlet") == pytest.approx(exact, rel=1e-8)
    with pytest.raises(cb.ConditionError, match="'inlet' has Inflow.* cannot take Pressure"):
        problem.with_data({"inlet": cb.Pressure(1.0)})


def test_mistakes(straight):
    with pytest.raises(cb.ConditionError, match="'outlet' must have either a pressure or a flow"):
        straight.operate({"inlet": 1.0})
    with pytest.raises(cb.ConditionError, match="give one opening its own"):
        straight.operate(flow_rates={"inlet": 1.0, "outlet": -1.0})
    with pytest.raises(cb.SelectionError, match="no opening is called 'drain'"):
        straight.operate({"inlet": 1.0, "drain": 0.0})
    with pytest.raises(cb.ConditionError, match="cannot be negative"):
        straight.operate({"inlet": 1.0, "outlet": 0.0}, tubing={"inlet": -1.0})
    with pytest.raises(cb.ConditionError, match="at least two"):
        cb.hydraulic_network(channel(), 1.0, ["inlet"])
    with pytest.raises(cb.SelectionError, match="no face is named 'drain'"):
        cb.hydraulic_network(channel(), 1.0, ["inlet", "drain"])
    moving = {"inlet": cb.Pressure(1.0), "outlet": cb.Pressure(0.0), "walls": cb.Velocity((1, 0))}
    with pytest.raises(cb.ConditionError, match="walls are at rest"):
        cb.network_of(cb.StokesProblem(channel(), 1.0, moving))


def test_accuracy_of_a_network():
    """A square duct from six faces: Q / p = 1 / (28.45415 L) within what was asked, errors said."""
    length = 3.0
    patches = tuple(map(cb.Patch, cb.box((0, 0, 0), (length, 1, 1))))
    ends = {"left": lambda x, n: n[0] > 0.9, "right": lambda x, n: n[0] < -0.9}
    duct = cb.Boundary(patches).named(rest="walls", **ends)
    network = cb.hydraulic_network(duct, 1.0, ["left", "right"], accuracy=1e-2)
    exact = 1 / (28.454153769562279 * length)
    wrong = abs(network.conductance[0, 0] - exact)
    assert wrong <= 3 * network.errors[0, 0] <= 3e-2 * exact
    point = network.operate(pressures={"right": 0.0}, flow_rates={"left": 1.0})
    assert abs(point.pressures[0] - 1 / exact) <= 3 * point.pressure_errors[0] <= 0.1 / exact
