"""Compressed layers: clusters, cross approximations, and flows solved with them."""

import numpy as np
import pytest
from shapes import bulged, channel

import cadbem as cb
from cadbem.boundary import Boundary, Patch
from cadbem.errors import SolverError
from cadbem.kernels.laplace_3d import LAPLACE_3D
from cadbem.kernels.stokes_2d import STOKES_2D
from cadbem.kernels.stokes_3d import STOKES_3D
from cadbem.operators.compressed import iterate
from cadbem.operators.compressed.clusters import cluster, partition
from cadbem.operators.compressed.compress import compress
from cadbem.operators.compressed.cross import MixedKernel, recompressed
from cadbem.operators.compressed.matrix import CompressedMatrix
from cadbem.operators.compressed.storage import storage_for
from cadbem.operators.layers import assemble_layers, collocation_targets
from cadbem.problems.heat import HeatProblem
from cadbem.problems.heat_conditions import HeatFlux, Temperature
from cadbem.space import Space, discontinuous_space
from cadbem.spline.outlines import ellipse, rectangle
from cadbem.spline.shapes import box, sphere

CURVED = bulged().elevated(2).refined(9)
PLANE = Boundary(tuple(Patch(s, "wall") for s in ellipse((3.0, 1.0), inwards=True)))
CASES = {
    "Stokes": (STOKES_3D, CURVED),
    "Laplace": (LAPLACE_3D, CURVED),
    "plane Stokes": (STOKES_2D, PLANE.elevated(3).refined(60)),
}


def matrix(kernel, boundary, tolerance, layer) -> tuple[CompressedMatrix, Space]:
    """The single (0) or double (1) layer of a boundary."""
    space = discontinuous_space(boundary)
    mixing = np.zeros((len(boundary.patches), 2, kernel.components, kernel.components))
    mixing[:, layer] = np.eye(kernel.components)
    own = np.zeros((len(boundary.patches), kernel.rows, kernel.components))
    targets, rules = collocation_targets(space), cb.Quadrature(min(tolerance, 1e-3) / 10)
    return compress(MixedKernel(kernel, mixing), space, targets, rules, tolerance, own), space


def test_partition_holds_each_pair_once():
    """Far and near blocks cover the whole matrix without overlap, whatever counts as far."""
    rng = np.random.default_rng(1)
    points, others = rng.normal(size=(3, 300)), rng.normal(size=(3, 170)) + 1.0
    rows = cluster(points, np.zeros(300), 20)
    columns = cluster(others, np.full(170, 0.05), 20)

    def is_far(t: int, s: int) -> bool:
        away = np.linalg.norm(rows.centre[:, t] - columns.centre[:, s])
        return away > rows.radius[t] + columns.radius[s]

    far, near = partition(rows, columns, is_far)
    times = np.zeros((300, 170), dtype=int)
    for t, s in far + near:
        times[np.ix_(rows.items(t), columns.items(s))] += 1
    assert far and near
    assert (times == 1).all()
    assert all(is_far(t, s) for t, s in far)
    for tree, at in ((rows, points), (columns, others)):
        for c in range(len(tree.start)):
            away = np.linalg.norm(at[:, tree.items(c)] - tree.centre[:, [c]], axis=0)
            assert (away <= tree.radius[c] * (1 + 1e-12)).all()


@pytest.mark.parametrize("case", CASES)
def test_constant_density_under_the_double_layer(case):
    """Half of what ∫ ∂G/∂n dS is inside, for n inwards; the error falls with the tolerance."""
    kernel, boundary = CASES[case]
    tolerances, errors = [1e-3, 1e-5, 1e-7, 1e-9], []
    for tolerance in tolerances:
        layer, space = matrix(kernel, boundary, tolerance, 1)
        assert layer.target_factors, "no block is far"
        made = layer.apply(np.ones((kernel.components, space.count)))
        errors.append(abs(made - kernel.free_term).max() / kernel.free_term)
        assert errors[-1] < 3 * tolerance
    slope = np.polyfit(np.log(tolerances), np.log(errors), 1)[0]
    assert 0.8 < slope < 1.3


@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize("layer", [0, 1])
def test_any_density_as_the_dense_layers_do(case, layer):
    """Random coefficients, one set and several at once."""
    kernel, boundary = CASES[case]
    compressed, space = matrix(kernel, boundary, 1e-8, layer)
    density = np.random.default_rng(2).normal(size=(kernel.components, space.count, 2))
    rules = cb.Quadrature(1e-9)
    dense = assemble_layers(kernel, space, collocation_targets(space), rules)
    made = compressed.apply(density)
    for k in range(2):
        parts = [0 * density[..., k], 0 * density[..., k]]
        parts[layer] = density[..., k]
        exact = dense.apply(*parts)
        size = np.linalg.norm(exact)
        assert np.linalg.norm(made[..., k] - exact) < 1e-8 * size
        single = compressed.apply(np.ascontiguousarray(density[..., k]))
        assert np.linalg.norm(single - exact) < 1e-8 * size


def test_recompression_finds_the_rank():
    """A product of rank 5 written with 20 rows, and noise of 1e-9: five rows are left."""
    rng = np.random.default_rng(3)
    factors = rng.normal(size=(5, 40)), rng.normal(size=(5, 60))
    mixing = rng.normal(size=(20, 5))
    right = np.linalg.pinv(mixing).T @ factors[1] + 1e-9 * rng.normal(size=(20, 60))
    left, short = recompressed(mixing @ factors[0], right, 1e-6)
    product = factors[0].T @ factors[1]
    assert len(left) == len(short) == 5
    assert np.linalg.norm(left.T @ short - product) < 1e-6 * np.linalg.norm(product)


@pytest.mark.parametrize("tolerance", [1e-6, 1e-8])
def test_drag_of_a_sphere(tolerance):
    """6π μ a U; the traction is open by a multiple of n, so that a border is solved for as well."""
    body = Boundary(tuple(Patch(s, "body") for s in sphere())).elevated(4).refined(6)
    flow = cb.StokesProblem(
        body, 2.0, {"body": cb.RigidMotion((1.0, 0.0, 0.0))}, cb.Quadrature(1e-9),
        storage=cb.Compressed(tolerance),
    ).solve()  # fmt: skip
    assert flow.iterations > 1
    assert flow.force("body") == pytest.approx([-12 * np.pi, 0, 0], abs=40 * tolerance)


@pytest.mark.parametrize("viscosity", [1e-3, 1.0, 1e3])
def test_shear_flow_in_a_box_with_an_open_end(viscosity):
    """u = (y, 0, 0) without pressure, which the splines hold; f = μ (n_y, n_x, 0).

    The open end mixes both layers with those of the walls; units must not matter.
    """
    boundary = channel().elevated(2).refined(9)

    def shear(x):
        return np.stack([x[1], 0 * x[0], 0 * x[0]])

    end = cb.Traction((0.0, -viscosity, 0.0))
    conditions = {"inlet": cb.Velocity(shear), "walls": cb.Velocity(shear), "outlet": end}
    flow = cb.StokesProblem(
        boundary, viscosity, conditions, cb.Quadrature(1e-9), storage=cb.Compressed(1e-9)
    ).solve()
    inside = np.random.default_rng(4).uniform(-0.45, 0.45, (3, 20))
    assert abs(flow.velocity_at(inside) - shear(inside)).max() < 1e-7
    assert abs(flow.force("outlet") - [0, -viscosity, 0]).max() < 1e-6 * viscosity
    assert abs(flow.velocity.on_patch(1, [0.3], [0.7])[1:]).max() < 1e-7


def test_plane_channel():
    """u = 1.5 U (1 - (2y/W)²), -dp/dx = 12 μ U / W²."""
    names = ("inlet", "outlet", "walls", "walls")
    sides = zip(rectangle((-1, -0.25), (1, 0.25)), names, strict=True)
    boundary = Boundary(tuple(Patch(s, n) for s, n in sides)).elevated(2).refined(size=0.015)
    conditions = {
        "inlet": cb.Inflow(mean_velocity=2.0),
        "outlet": cb.Pressure(0.0),
        "walls": cb.NoSlip(),
    }
    flow = cb.StokesProblem(
        boundary, 3.0, conditions, cb.Quadrature(1e-10), storage=cb.Compressed(1e-10)
    ).solve()
    assert flow.mean_pressure("inlet") == pytest.approx(12 * 3.0 * 2.0 / 0.5**2 * 2, rel=1e-7)
    assert abs(flow.net_flux()) < 1e-9


def test_heat_through_a_slab():
    """φ falls from 3 to 1 over the length 1, conductivity 2: a flux of 4."""
    names = ["left", "right"] + ["sides"] * 4
    boundary = Boundary(tuple(Patch(s, n) for s, n in zip(box(), names, strict=True)))
    conditions = {"left": Temperature(3.0), "right": Temperature(1.0), "sides": HeatFlux(0.0)}
    heat = HeatProblem(
        boundary.elevated(2).refined(9), 2.0, conditions, quadrature=cb.Quadrature(1e-9),
        storage=cb.Compressed(1e-9),
    ).solve()  # fmt: skip
    middle = np.array([[0.2, 0.5], [0.4, 0.5], [0.3, 0.5]])
    assert heat.temperature_at(middle) == pytest.approx([2.6, 2.0], abs=1e-7)


def test_bodies_in_a_channel():
    """A droplet and a sphere move as in the same channel with dense layers.

    Walls answer with an error of some times the tolerance, and the bodies' iteration ends above it.
    """
    velocities = []
    for storage in (cb.Dense(), cb.Compressed(1e-8)):
        boundary = channel().elevated(2).refined(6)
        conditions = {
            "inlet": cb.Inflow(mean_velocity=1.0),
            "outlet": cb.Pressure(0.0),
            "walls": cb.NoSlip(),
        }
        problem = cb.StokesProblem(
            boundary, 1.0, conditions, cb.Quadrature(1e-6), storage=storage
        )
        shape = cb.spline_sphere(0.2, (-0.4, 0.1, 0.0), points=72)
        bodies = [
            cb.Droplet(shape, cb.SurfaceTension(5.0), viscosity_ratio=5.0),
            cb.rigid_sphere(0.15, (0.3, -0.1, 0.05), spans=1),
        ]
        drop, ball = cb.Simulation(cb.ChannelFlow(problem), bodies).start.responses
        velocities.append((drop.velocity, ball.velocity))
    assert abs(velocities[0][0]).max() > 1
    for dense, compressed in zip(*velocities, strict=True):
        assert abs(compressed - dense).max() < 1e-5


def test_storage_follows_the_size():
    """Dense to 4000 points, compressed beyond; tolerances out of range are refused."""
    assert storage_for(4000) == cb.Dense()
    assert storage_for(4001) == cb.Compressed()
    with pytest.raises(cb.InputError, match="1e-12 to 0.01"):
        cb.Compressed(1.0)
    body = Boundary(tuple(Patch(s, "body") for s in sphere())).elevated(2)
    moving = {"body": cb.RigidMotion((1.0, 0.0, 0.0))}
    with pytest.raises(ValueError, match="storage is 'dense'; give Dense"):
        cb.StokesProblem(body, 1.0, moving, storage="dense").solve()


def test_iteration_that_fails_says_so(monkeypatch):
    """With three iterations allowed, the message gives the residual and what to do."""
    monkeypatch.setattr(iterate, "INNER", 2)
    monkeypatch.setattr(iterate, "KEPT", 0)
    monkeypatch.setattr(iterate, "OUTER", 1)
    body = Boundary(tuple(Patch(s, "body") for s in sphere())).elevated(2).refined(4)
    problem = cb.StokesProblem(
        body, 1.0, {"body": cb.RigidMotion((1.0, 0.0, 0.0))}, storage=cb.Compressed(1e-9)
    )
    with pytest.raises(SolverError, match="residual .* storage=Dense"):
        problem.solve()
